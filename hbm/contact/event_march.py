"""The Jenkins slider marched through everything that happens between the samples.

A slider behind a spring is a play operator: its position w, with T = kt (u - w), is pushed up by u - mu N / kt and down
by u + mu N / kt. Taken at the samples alone, both make a corner in the force wherever an event moves past a sample.
Where all contacts slip, and little but the bending of the blades holds the mean position, these corners are larger than
the stiffness that is left, and Newton's method goes round in circles. Here

- motions between samples are the cubics through values and slopes (`cubics.py`),
- the march goes from node to node: the samples, the openings and closings, the highest points of u - mu N / kt and the
  lowest of u + mu N / kt. Between two nodes neither limit pushes and then lets go, so that a clamp at each node is the
  exact march of the cubics, however rigid the friction,
- the Fourier coefficients are those of the exact path: constant where it sticks, at the limit where it slips. It is
  integrated piece by piece against the harmonics, taken as straight between samples, and scaled so that the cubics
  through the samples of a motion give its coefficients back. So an element that sticks has the coefficients of its
  springs, and the error is of fourth order in the step.

The path is continuous, so that its integrals do not change, to first order, with the instants at which its pieces end:
they are held in derivatives. Only where a contact closes, the position from which its slider starts moves with it.
"""

from typing import NamedTuple

import jax
import jax.numpy as jnp

from updamp.hbm.contact.cubics import Cubics, averages_against_hats, rises_through, through, tops
from updamp.hbm.contact.friction import FrictionParameters


class Path(NamedTuple):
    """Forces [N]. tangential: (n_time, 2) at the samples; averaged: (n_time, 3), what Fourier analysis should see."""

    tangential: jax.Array
    averaged: jax.Array


class _Openings(NamedTuple):
    """Shares of each segment after which the contact opens or closes, -1 for none, and whether it is closed before."""

    first: jax.Array
    second: jax.Array
    closed: jax.Array

    def parts(self, begins: jax.Array) -> tuple[tuple[jax.Array, jax.Array], tuple[jax.Array, jax.Array]]:
        """Ends of two parts in which a state holds that begins with the segment or not; (1, 1) where there is none."""
        until = jnp.where(self.second >= 0, self.second, 1.0)
        start = jnp.where(begins, 0.0, jnp.where(self.first >= 0, self.first, 1.0))
        end = jnp.where(begins, jnp.where(self.first >= 0, self.first, 1.0), until)
        return (start, jnp.maximum(start, end)), (jnp.where(begins, until, 1.0), jnp.ones_like(until))


class _Limit(NamedTuple):
    """The slip limit over kt, ratio times p where p is positive [m]."""

    ratio: jax.Array
    p: Cubics


class _Grid(NamedTuple):
    """Nodes in the order of time. number: of the segment; share: of it, where the node is; end: where the next one is
    crossing: whether the contact opens or closes; closed: whether it is closed up to the next node
    sample: (n_time,) nodes of the samples
    """

    number: jax.Array
    share: jax.Array
    end: jax.Array
    crossing: jax.Array
    closed: jax.Array
    sample: jax.Array


def march_slider(displacement: jax.Array, p: FrictionParameters, cycles: int) -> Path:
    """Total force over the last of `cycles` periods; each tangential direction has the limit mu N of its own.

    displacement: (n_time, 3) [m]; p.mu may have one value a sample, (n_time,), all positive
    """
    pressing = p.n0 / p.kn - p.gap + displacement[:, 2]
    ratio, holding = _friction(pressing, p)
    openings = _openings(jax.lax.stop_gradient(holding))

    def one(surface: jax.Array, first: jax.Array) -> tuple[jax.Array, jax.Array]:
        motion, limit = through(surface), _Limit(ratio, holding)
        grid = _grid(*jax.lax.stop_gradient((motion, limit)), openings)
        slider = _positions(grid, motion, limit, first, cycles)
        return surface - slider[grid.sample], surface - _averaged(_integrals(grid, motion, limit, slider))

    tangential, averaged = jax.vmap(one, in_axes=(1, 0), out_axes=1)(displacement[:, :2], -p.t0 / p.kt)
    normal = pressing - _averaged(_open_integrals(through(pressing)))
    return Path(p.kt * tangential, jnp.concatenate([p.kt * averaged, p.kn * normal[:, None]], axis=1))


def _friction(pressing: jax.Array, p: FrictionParameters) -> tuple[jax.Array, Cubics]:
    """A ratio and a compression whose product is the slip limit over kt. Friction that varies over the period goes with
    the compression: it has the same sign, so that openings and closings stay where they are."""
    if jnp.ndim(p.mu) == 0:
        return p.mu * p.kn / p.kt, through(pressing)
    return p.kn / p.kt, through(p.mu * pressing)


def _openings(p: Cubics) -> _Openings:
    """Of a compression, or of a limit, which has the same sign."""
    end = jnp.ones_like(p.c0)
    closed, closes = p.c0 > 0, jnp.roll(p.c0 > 0, -1)
    sign = jnp.where(closes, 1.0, -1.0)
    turn = tops(p.times(-sign), 0 * end, end)
    twice = (closed == closes) & (turn >= 0) & (sign * p.value(turn) < 0)
    once = closed != closes
    # what is looked for rises: the sign that the segment ends with, at first its opposite where there are two
    toward = jnp.where(twice, -sign, sign)
    first = rises_through(p.times(toward), 0 * end, 0 * end, jnp.where(twice, turn, end), once | twice)
    second = rises_through(p.times(sign), 0 * end, jnp.where(twice, turn, 0 * end), end, twice)
    return _Openings(jnp.where(once | twice, first, -1.0), jnp.where(twice, second, -1.0), closed)


def _grid(motion: Cubics, limit: _Limit, openings: _Openings) -> _Grid:
    n = len(motion.c0)
    shares, crosses = _in_order(motion, limit, openings)
    there = (shares >= 0).ravel()
    found = jnp.nonzero(there, size=n + most_between(n), fill_value=there.size)[0]
    number = jnp.minimum(found // shares.shape[1], n - 1)
    share = shares.ravel().at[found].get(mode="fill", fill_value=1.0)
    crossing = crosses.ravel().at[found].get(mode="fill", fill_value=False)
    end = jnp.where(jnp.roll(number, -1) == number, jnp.roll(share, -1), 1.0).at[-1].set(1.0)
    closed = limit.p.of(number).value((share + end) / 2) > 0
    return _Grid(number, share, end, crossing, closed, jnp.cumsum(there)[:: shares.shape[1]] - 1)


def _in_order(motion: Cubics, limit: _Limit, openings: _Openings) -> tuple[jax.Array, jax.Array]:
    """(n_time, 7) shares of the nodes of each segment in the order of time, -1 for none, and which are crossings."""
    bound, (before, behind) = limit.p.times(limit.ratio), openings.parts(openings.closed)
    turns = [[tops(motion.times(sign).less(bound), *part) for sign in (1.0, -1.0)] for part in (before, behind)]
    pairs = [(jnp.minimum(*pair), jnp.maximum(*pair)) for pair in turns]
    first, second = (jnp.where(share < 1, share, -1.0) for share in (openings.first, openings.second))
    none, closed = jnp.full_like(first, -1.0), openings.closed[:, None]
    # a contact that is open at first has its turns behind the first crossing
    from_closed = jnp.stack([0 * first, *pairs[0], first, second, *pairs[1]], axis=1)
    from_open = jnp.stack([0 * first, first, *pairs[0], second, none, none], axis=1)
    places = jnp.arange(from_closed.shape[1])
    crosses = jnp.where(closed, (places == 3) | (places == 4), (places == 1) | (places == 4))
    return jnp.where(closed, from_closed, from_open), crosses


def most_between(n_time: int) -> int:
    """Nodes between samples that are followed in each direction of each contact.

    Motions of harmonics up to the order h have at most h highest and h lowest points, and 2 h zeros: no more than there
    are samples, where a period of the highest harmonic has four.
    """
    return n_time


def _positions(grid: _Grid, motion: Cubics, limit: _Limit, first: jax.Array, cycles: int) -> jax.Array:
    """(n_nodes,) where the slider stands; first: where it rests."""
    up, down, free = _pushed(grid, motion, limit)
    n = len(up)

    def step(
        state: tuple[jax.Array, jax.Array], node: tuple[jax.Array, ...]
    ) -> tuple[tuple[jax.Array, jax.Array], jax.Array]:
        stands, source = state
        number, up, down, free = node
        source = jnp.where((stands < up) | free, number, jnp.where(stands > down, number + n, source))
        return (jnp.clip(stands, up, down), source), source

    nodes = (jnp.arange(n), *jax.lax.stop_gradient((up, down)), free)
    state = (jax.lax.stop_gradient(first), jnp.asarray(2 * n))
    for _ in range(cycles - 1):
        state, _ = jax.lax.scan(lambda s, x: (step(s, x)[0], None), state, nodes)
    _, sources = jax.lax.scan(step, state, nodes)
    return jnp.concatenate([up, down, first[None]])[sources]


def _pushed(grid: _Grid, motion: Cubics, limit: _Limit) -> tuple[jax.Array, jax.Array, jax.Array]:
    """Up to where, and down to where, each node pushes the slider; whether nothing presses there, and it goes along."""
    u, p = motion.of(grid.number), limit.p.of(grid.number)
    rate = jax.lax.stop_gradient(p.slope(grid.share))
    moves = jnp.where(grid.crossing, p.value(grid.share) / jnp.where(grid.crossing, rate, 1.0), 0.0)
    at = u.value(grid.share - (moves - jax.lax.stop_gradient(moves)))
    free = grid.crossing | (jax.lax.stop_gradient(p.value(grid.share)) <= 0)
    most = jnp.where(free, 0.0, limit.ratio * p.value(grid.share))
    return at - most, at + most, free


def _integrals(grid: _Grid, motion: Cubics, limit: _Limit, slider: jax.Array) -> jax.Array:
    """(n_time,) of the slider's path against the hat about each sample."""
    u, bound, ends = motion.of(grid.number), limit.p.of(grid.number).times(limit.ratio), (grid.share, grid.end)
    fixed_u, fixed_bound, before = jax.lax.stop_gradient((u, bound, slider))
    side = jnp.where(grid.closed, jnp.sign(jnp.roll(before, -1) - before), 0.0)
    pushed = fixed_u.times(side).less(fixed_bound)
    slips = jnp.where(side == 0, grid.end, rises_through(pushed, side * before, *ends, side != 0))
    slips = jnp.where(grid.closed, slips, grid.share)
    one = Cubics(slider, *jnp.zeros((3, len(slider)))).halves(grid.share, slips)
    other = u.less(bound.times(side)).halves(slips, grid.end)
    return _on_hats(len(motion.c0), grid.number, one[0] + other[0], one[1] + other[1])


def _open_integrals(p: Cubics) -> jax.Array:
    """(n_time,) of the compression against the hats where it is negative."""
    openings, n = _openings(jax.lax.stop_gradient(p)), len(p.c0)
    first, second = (p.halves(*part) for part in openings.parts(~openings.closed))
    return _on_hats(n, jnp.arange(n), first[0] + second[0], first[1] + second[1])


def _on_hats(n: int, number: jax.Array, start: jax.Array, end: jax.Array) -> jax.Array:
    return jnp.zeros(n).at[number].add(start).at[(number + 1) % n].add(end)


def _averaged(integrals: jax.Array) -> jax.Array:
    """Samples of the motion that has these integrals against the hats."""
    n = len(integrals)
    return jnp.fft.irfft(jnp.fft.rfft(integrals) / averages_against_hats(n), n)
