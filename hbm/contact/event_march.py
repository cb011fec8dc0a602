"""The Jenkins slider marched with its events between the samples.

A slider behind a spring is a play operator: its position w, with T = kt (u - w), is pushed up by max(u - mu N / kt) and
down by min(u + mu N / kt). Taken at the samples alone, both make a corner in the force wherever an event moves past a
sample. Where all contacts slip, and little but the bending of the blades holds the mean position, these corners are
larger than the stiffness that is left, and Newton's method goes round in circles. Here

- extrema of the motion between samples are those of a parabola through values and slopes,
- the start of slip, opening and closing are located on straight lines between samples, and the limit follows the same
  lines: with a limit that dips below them, the slider would jump where a dip first reaches a sample,
- what the force does between samples beyond a straight line is added to its neighbours, shared like the load on a beam,
  so that the mean, and nearly so every harmonic, is that of the continuous path. Where there is no event nothing is
  added, and the Fourier coefficients are those of the samples.

Two things make this cheap. A push is a clamp, so the slider always stands where one segment put it: the march only
finds out which, and the tangents need not be marched. And corners are few: they are picked out.
"""

from typing import NamedTuple

import jax
import jax.numpy as jnp

from updamp.hbm.contact.friction import FrictionParameters

# Trial forces this close to the limit (relative) are at it.
_AT_LIMIT = 1e-9


class Path(NamedTuple):
    """Forces [N]. tangential: (n_time, 2) at the samples; averaged: (n_time, 3), what Fourier analysis should see."""

    tangential: jax.Array
    averaged: jax.Array


class _Segment(NamedTuple):
    """From a sample (0) to the next (1), in one direction, any shape: u the spring's end that moves with the surface,
    du its slope a sample; p the compression of the normal spring, negative where open [m].
    """

    u0: jax.Array
    u1: jax.Array
    p0: jax.Array
    p1: jax.Array
    du0: jax.Array
    du1: jax.Array

    def at(self, number: jax.Array) -> "_Segment":
        """Those of these numbers, zero beyond the last."""
        return _Segment(*(value.at[number].get(mode="fill", fill_value=0.0) for value in self))

    def turned(self, sign: jax.Array | float) -> "_Segment":
        """Seen from the other side where sign is -1: what pushes down pushes up."""
        return self._replace(u0=sign * self.u0, u1=sign * self.u1, du0=sign * self.du0, du1=sign * self.du1)

    def closing_and_opening(self) -> tuple[jax.Array, jax.Array]:
        """Share of the segment after which the contact closes (0 where it does not) and opens (1)."""
        crosses = (self.p0 > 0) != (self.p1 > 0)
        share = self.p0 / jnp.where(crosses, self.p0 - self.p1, 1.0)
        return jnp.where(crosses & (self.p1 > 0), share, 0.0), jnp.where(crosses & (self.p0 > 0), share, 1.0)


def march_slider(displacement: jax.Array, p: FrictionParameters, cycles: int) -> Path:
    """Total force over the last of `cycles` periods; each tangential direction has the limit mu N of its own.

    displacement: (n_time, 3) [m]; p.mu may have one value a sample, (n_time,), all positive
    """
    slope = _slope(displacement)
    after, slope_after = _next(displacement), _next(slope)
    rest = p.n0 / p.kn - p.gap
    pressing = (rest + displacement[:, 2], rest + after[:, 2])
    ratio, holding = _friction(pressing, p)

    def one(surface: tuple[jax.Array, ...], first: jax.Array) -> tuple[jax.Array, jax.Array]:
        u0, u1, du0, du1 = surface
        segments = _Segment(u0, u1, *holding, du0, du1)
        slider = _sliders(segments, ratio, first, cycles)
        return u0 - slider, u0 - slider + _between_samples(segments, ratio, slider)

    directions = tuple(value[:, :2] for value in (displacement, after, slope, slope_after))
    tangential, averaged = jax.vmap(one, in_axes=(1, 0), out_axes=1)(directions, -p.t0 / p.kt)
    normal = jnp.maximum(pressing[0], 0.0) + _between_contacts(_Segment(*pressing, *pressing, *pressing))
    return Path(p.kt * tangential, jnp.concatenate([p.kt * averaged, p.kn * normal[:, None]], axis=1))


def _friction(
    pressing: tuple[jax.Array, jax.Array], p: FrictionParameters
) -> tuple[jax.Array, tuple[jax.Array, jax.Array]]:
    """A ratio and compressions whose product is the slip limit over kt.

    Friction that varies over the period goes with the compression: it has the same sign, so that closing and opening
    stay where they are.
    """
    if jnp.ndim(p.mu) == 0:
        return p.mu * p.kn / p.kt, pressing
    held = p.mu * pressing[0]
    return p.kn / p.kt, (held, _next(held))


def _sliders(segments: _Segment, ratio: jax.Array, first: jax.Array, cycles: int) -> jax.Array:
    """(n_time,) positions at the samples; first: where the slider rests."""
    n_time = len(segments.u0)
    fixed, rest, limit = jax.lax.stop_gradient((segments, first, ratio))
    up, down = _push(fixed, limit), -_push(fixed.turned(-1.0), limit)

    def step(
        state: tuple[jax.Array, jax.Array], segment: tuple[jax.Array, ...]
    ) -> tuple[tuple[jax.Array, jax.Array], jax.Array]:
        slider, source = state
        number, closes, up, down = segment
        pushed = jnp.maximum(slider, up)
        moved_up, moved_down = closes | (slider < up), pushed > down
        moved = jnp.where(moved_down & ~closes, number + n_time, jnp.where(moved_up, number, source))
        return (jnp.where(closes, up, jnp.minimum(pushed, down)), moved), source

    closes = (fixed.p0 <= 0) & (fixed.p1 > 0)
    passing = (jnp.arange(n_time), closes, up, down)
    # At first the slider is within the limits of sample 0, the end of the last segment.
    bound = limit * jnp.maximum(fixed.p0[0], 0.0)
    start = jnp.clip(rest, fixed.u0[0] - bound, fixed.u0[0] + bound)
    source = jnp.where(start > rest, n_time - 1, jnp.where(start < rest, 2 * n_time - 1, 2 * n_time))
    state = (start, source)
    for _ in range(cycles - 1):
        state, _ = jax.lax.scan(lambda s, x: (step(s, x)[0], None), state, passing)
    _, sources = jax.lax.scan(step, state, passing)
    return jnp.where(sources == 2 * n_time, first, _positions(segments, ratio, sources))


def _positions(segments: _Segment, ratio: jax.Array, sources: jax.Array) -> jax.Array:
    """(n_time,) where the segments of these numbers push to: up from 0, down from n_time on.

    Most push to where their end stands; where within them the rest comes from is worked out only for those in which
    something turns or closes.
    """
    n_time = len(segments.u0)
    number, sign = sources % n_time, jnp.where(sources < n_time, 1.0, -1.0)
    ends = segments.u1.at[number].get() - sign * ratio * jnp.maximum(segments.p1.at[number].get(), 0.0)
    fixed, limit = jax.lax.stop_gradient((segments, ratio))
    used = jnp.zeros(2 * n_time, dtype=bool).at[sources].set(True, mode="drop")
    further = jnp.concatenate([_beyond_end(fixed, limit), _beyond_end(fixed.turned(-1.0), limit)])
    where = _corner_numbers((further > 0) & used)
    s = segments.at(jnp.where(where < 2 * n_time, where % n_time, n_time)).turned(jnp.where(where < n_time, 1.0, -1.0))
    beyond = jnp.zeros(2 * n_time).at[where].set(_beyond_end(s, ratio), mode="drop")
    return ends + sign * beyond.at[sources].get(mode="fill", fill_value=0.0)


def _beyond_end(s: _Segment, ratio: jax.Array) -> jax.Array:
    return _push(s, ratio) - (s.u1 - ratio * jnp.maximum(s.p1, 0.0))


def _push(s: _Segment, ratio: jax.Array) -> jax.Array:
    """The position up to which a segment pushes the slider; where the contact closes in it, where the slider starts."""
    limit0, limit1 = ratio * jnp.maximum(s.p0, 0.0), ratio * jnp.maximum(s.p1, 0.0)
    closing, _ = s.closing_and_opening()
    highest = jnp.where(
        (s.p0 <= 0) & (s.p1 > 0),
        s.u0 + closing * (s.u1 - s.u0),
        _top(s.u0 - limit0, s.u1 - limit1, s.du0 - (limit1 - limit0), s.du1 - (limit1 - limit0)),
    )
    return jnp.clip(highest, s.u1 - limit1, s.u1 + limit1)


def _top(q0: jax.Array, q1: jax.Array, slope0: jax.Array, slope1: jax.Array) -> jax.Array:
    """Largest value after the start of a segment; where the slope falls through zero, the top of a parabola.

    From the left and from the right end the parabola's top is not quite the same: they are blended so that the value
    and its derivative are continuous when the top moves past a sample.
    """
    turns = (slope0 > 0) & (slope1 < 0)
    share = slope0 / jnp.where(turns, slope0 - slope1, 1.0)
    left, right = q0 + slope0 * share / 2, q1 - slope1 * (1 - share) / 2
    blend = share**2 * (3 - 2 * share)
    return jnp.where(turns, (1 - blend) * left + blend * right, q1)


def _between_samples(segments: _Segment, ratio: jax.Array, slider: jax.Array) -> jax.Array:
    """(n_time,) what the tangential path holds beyond its chords, at the samples it is shared between."""
    where = _corner_numbers(_has_corner(*jax.lax.stop_gradient((segments, ratio, slider))))
    s = segments.at(where)
    w0, w1 = (value.at[where].get(mode="fill", fill_value=0.0) for value in (slider, _next(slider)))
    closing, opening = s.closing_and_opening()
    limit0, force0, force1 = ratio * jnp.maximum(s.p0, 0.0), s.u0 - w0, s.u1 - w1
    up = _corner(force0 - limit0, _beyond_limit(s, ratio, w0), opening)
    down = _corner(-force0 - limit0, _beyond_limit(s.turned(-1.0), ratio, -w0), opening)
    integral = up[0] - down[0] - (1 - opening) * force0 / 2 - closing * force1 / 2
    moment = up[1] - down[1] - (1 - opening**2) * force0 / 6 - closing * (1 + closing) * force1 / 6
    return _distributed(len(slider), where, integral, moment)


def _has_corner(s: _Segment, ratio: jax.Array, slider: jax.Array) -> jax.Array:
    starts = [
        (_beyond_limit(s.turned(sign), ratio, sign * slider) > 0)
        & (sign * (s.u0 - slider) < (1 - _AT_LIMIT) * ratio * s.p0)
        for sign in (1.0, -1.0)
    ]
    return starts[0] | starts[1] | ((s.p0 > 0) != (s.p1 > 0))


def _beyond_limit(s: _Segment, ratio: jax.Array, slider: jax.Array) -> jax.Array:
    """By how much the force would pass the upper limit at the end of the segment, or where it opens, if it stuck."""
    _, opening = s.closing_and_opening()
    return jnp.where(opening < 1, s.u0 + opening * (s.u1 - s.u0), _push(s, ratio)) - slider


def _corner(before: jax.Array, over: jax.Array, end: jax.Array) -> tuple[jax.Array, jax.Array]:
    """Integral and first moment of the triangle between path and chord.

    before: trial force beyond the limit at the start of the segment, <= 0; over: at its end, or where it opens
    """
    slips = over > 0
    height = jnp.where(slips, over, 0.0)
    share = -before / jnp.where(slips, height - before, 1.0)
    return end * height * share / 2, end**2 * height * share * (1 + share) / 6


def _between_contacts(segments: _Segment) -> jax.Array:
    """As `_between_samples`, for the normal force."""
    where = _corner_numbers((segments.p0 > 0) != (segments.p1 > 0))
    s = segments.at(where)
    (closing, opening), force0, force1 = s.closing_and_opening(), jnp.maximum(s.p0, 0.0), jnp.maximum(s.p1, 0.0)
    integral = -(1 - opening) * force0 / 2 - closing * force1 / 2
    moment = -(1 - opening**2) * force0 / 6 - closing * (1 + closing) * force1 / 6
    return _distributed(len(segments.p0), where, integral, moment)


def _distributed(n_time: int, where: jax.Array, integral: jax.Array, moment: jax.Array) -> jax.Array:
    end = jnp.where(where < n_time, (where + 1) % n_time, n_time)
    return jnp.zeros(n_time).at[where].add(integral - moment, mode="drop").at[end].add(moment, mode="drop")


def _corner_numbers(corners: jax.Array) -> jax.Array:
    """(most_corners,) numbers of the segments with a corner, beyond the last one where there are fewer."""
    return jnp.nonzero(corners, size=most_corners(len(corners)), fill_value=len(corners))[0]


def most_corners(n_time: int) -> int:
    """Corners that are followed in each direction of each contact; any beyond are taken at the samples.

    A period of a few harmonics has up to a dozen; with many harmonics go many samples.
    """
    return max(16, n_time // 8)


def _next(value: jax.Array) -> jax.Array:
    return jnp.roll(value, -1, axis=0)


def _slope(value: jax.Array) -> jax.Array:
    """Derivative with respect to the number of the sample, of fourth order."""
    near = jnp.roll(value, -1, axis=0) - jnp.roll(value, 1, axis=0)
    far = jnp.roll(value, -2, axis=0) - jnp.roll(value, 2, axis=0)
    return (8 * near - far) / 12
