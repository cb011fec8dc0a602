"""The model's branch for one test, as a curve in what is observed, with its derivatives by the parameters.

Observed at every place along the branch: the logarithm of the frequency, then for every sensor and harmonic the
logarithm of the amplitude and the phase. Along the branch these are smooth where the response at a fixed frequency is
not, at turning points, and where it changes by multiples, at resonance. The patterns of numerical error join the
parameters (`with_patterns`); after a fit they are given the sizes that it has found (`at_sizes`).
"""

from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np
from numpy.typing import NDArray
from scipy.interpolate import CubicHermiteSpline, PchipInterpolator, PPoly

from updamp.comparison.prediction.held_branch import pairs
from updamp.comparison.prediction.numerical_error import NumericalError
from updamp.comparison.prediction.run_condition import RunCondition
from updamp.hbm.continuation.branch import BranchPoint

Floats = NDArray[np.float64]

# Straight lines that the branch is taken as between two neighbouring points, to find where to look for what was
# measured: a cubic is off a quarter of its chord by a sixteenth of what it is off the whole one.
_BETWEEN = 4
# Distance of places that stand for the whole branch: half of the longest step of a continuation (`StepLengths`).
_APART = 0.1
# Arrays of a branch with one row for each of its points.
_OF_POINTS = ("place", "state", "along", "slopes", "w_by_parameter", "visited")
# Amplitude that is as good as none [m]
NO_AMPLITUDE = 1e-20


@dataclass(frozen=True, eq=False)
class PredictedBranch:
    """Interpolated between its points in the logarithm of the frequency and the complex amplitudes, which are smooth
    at resonances and at antiresonances.

    u: (p,) parameters; points: without their matrices (`observed_point.py`); place: (n,) length along the branch
    state: (n, m) logarithm of the frequency, then real and imaginary part of every sensor's amplitude [m], m = 1 + 2
        n_sensors; along: its derivative by place; slopes: (n, p + 1, m) by the parameters and by the logarithm of the
        force, across the branch. Where the response was held: amplitudes over the force that it takes, times the
        condition's, and the last slope by the logarithm of the level held (`held_branch.py`)
    x_by_parameter: for each point (p, n_relative, n_coefficients); w_by_parameter: (n, p)
    visited: (n,) whether a slow sweep in the test's direction sees it
    stopped: why the branch ends inside the window, "" if it does not
    rough: (n, 1 + 2 n_sensors) standard deviations of the numerical error from place to place, None where not known
    proportional: whether amplitudes grow as the force does, as those of a linear model: then their slopes by the force
        hold the frequency, and are exact however far the measured force is from the condition's
    """

    condition: RunCondition
    u: Floats
    points: tuple[BranchPoint, ...]
    place: Floats
    state: Floats
    along: Floats
    slopes: Floats
    x_by_parameter: tuple[Floats, ...]
    w_by_parameter: Floats
    visited: NDArray[np.bool_]
    stopped: str
    proportional: bool
    rough: Floats | None = None

    @cached_property
    def curves(self) -> tuple[PPoly, PPoly]:
        """The state and the slopes along the branch."""
        return CubicHermiteSpline(self.place, self.state, self.along), PchipInterpolator(self.place, self.slopes)

    @cached_property
    def observed(self) -> "Observed":
        """At its points"""
        return self.at(self.place)

    @property
    def covers_window(self) -> bool:
        """Whether it shows all frequencies that were measured, or ends within them since it could not be followed."""
        return self.covers(self.condition.window)

    def covers(self, window: tuple[float, float]) -> bool:
        """Likewise the frequencies of a window [Hz]"""
        (low, high), ends = window, np.exp(self.state[[0, -1], 0])
        return bool(self.stopped) or bool(ends.min() <= low and high <= ends.max())

    @cached_property
    def followed(self) -> NDArray[np.bool_]:
        """(n - 1,) whether the branch was followed from a point to the next, not after a gap"""
        return np.array([not point.after_gap for point in self.points[1:]], dtype=bool)

    @cached_property
    def even_places(self) -> Floats:
        """As far apart as steps of a continuation usually are: what is taken of a branch as a whole must not depend on
        where it has its points."""
        return np.linspace(0.0, self.place[-1], max(int(np.ceil(self.place[-1] / _APART)), 4) + 1)

    @cached_property
    def evenly(self) -> "Observed":
        """At these places, but for gaps."""
        following = np.clip(np.searchsorted(self.place, self.even_places, side="right"), 1, len(self.place) - 1)
        return self.at(self.even_places[self.followed[following - 1]])

    @cached_property
    def evenly_squared(self) -> Floats:
        """(n_places, p + 1, m) squares of the slopes at these places, in gaps too: what is no gap stays as it is"""
        return np.square(self.at(self.even_places).slopes)

    def spread_out(self, apart: float = _APART) -> list[int]:
        """Numbers of some of its points: the first and the last one, both sides of gaps, and others no closer to the
        one before than that, by default than places that stand for the whole branch."""
        chosen, last = [0], len(self.points) - 1
        for i in range(1, last + 1):
            at_gap = self.points[i].after_gap or (i < last and self.points[i + 1].after_gap)
            if i == last or at_gap or self.place[i] - self.place[chosen[-1]] >= apart:
                chosen.append(i)
        return chosen

    def thinned(self, apart: float = _APART) -> "PredictedBranch":
        """With those points alone, to be moved from, or for a first guess."""
        some = self.spread_out(apart)
        each = {name: getattr(self, name)[some] for name in _OF_POINTS}
        rough = None if self.rough is None else self.rough[some]
        points, by_parameter = tuple(self.points[i] for i in some), tuple(self.x_by_parameter[i] for i in some)
        return replace(self, points=points, x_by_parameter=by_parameter, rough=rough, **each)

    def at(self, place: Floats) -> "Observed":
        """What is observed at places along the branch."""
        curve, slopes_at = self.curves
        changes = np.concatenate([curve(place, 1)[..., None, :], slopes_at(place)], axis=-2)
        value, change = logarithms(curve(place), changes)
        if self.proportional:
            change[..., -1, :] = of_force(change.shape[-1])
        return Observed(value, change[..., 0, :], change[..., 1:, :])

    @cached_property
    def pieces(self) -> tuple[Floats, NDArray[np.bool_]]:
        """(k + 1,) places of its points and between them, so close that it is all but straight from one to the next;
        (k,) whether it was followed there."""
        ends = self.place[:-1, None] + np.diff(self.place)[:, None] * np.arange(_BETWEEN) / _BETWEEN
        return np.append(ends.ravel(), self.place[-1]), np.repeat(self.followed, _BETWEEN)

    def rough_at(self, place: Floats) -> Floats:
        """(..., 1 + 2 n_sensors)"""
        if self.rough is None:
            return np.zeros((*np.shape(place), self.state.shape[1]))
        return np.stack([np.interp(place, self.place, column) for column in self.rough.T], axis=-1)

    @cached_property
    def seen(self) -> NDArray[np.bool_]:
        """(n - 1,) whether a sweep sees what lies between a point and the next; not where the branch was not followed
        from one to the other: what is measured there is compared with the branch beside it."""
        return np.asarray(self.visited[:-1] & self.visited[1:] & self.followed)

    def seen_from(self, first: float, last: float) -> bool:
        """Whether a sweep sees all of the branch between two places, the first before the last."""
        return bool(self.seen[(self.place[1:] > first) & (self.place[:-1] < last)].all())

    def seen_places(self, n: int) -> Floats:
        """(k,) those of n evenly spaced places that a sweep sees."""
        place = np.linspace(self.place[0], self.place[-1], n)
        near = np.clip(np.searchsorted(self.place, place, side="right") - 1, 0, len(self.place) - 2)
        return np.asarray(place[self.seen[near]])

    @property
    def frequency(self) -> Floats:
        """(n,) [Hz]"""
        return np.exp(self.state[:, 0])

    @property
    def amplitude(self) -> NDArray[np.complex128]:
        """(n, n_sensors) [m]"""
        return self.state[:, 1::2] + 1j * self.state[:, 2::2]


def logarithms(state: Floats, change: Floats) -> tuple[Floats, Floats]:
    """Of states (..., m) what is observed, and of changes (..., k, m) of the states how that changes."""
    amplitude = _amplitudes(state)
    # as long as all contacts stick there is no higher harmonic at all
    amplitude[np.abs(amplitude) < NO_AMPLITUDE] = NO_AMPLITUDE
    ratio = _amplitudes(change) / amplitude[..., None, :]
    return _joined(state[..., 0], np.log(amplitude)), _joined(change[..., 0], ratio)


def length_of(change: Floats, state: Floats, condition: RunCondition) -> Floats:
    """(n,) of changes of the state: amplitudes relative to all of them, and the whole window in frequency as much as
    half a turn of phase."""
    of_frequency = np.pi * change[:, 0] / np.log(condition.wider[1] / condition.wider[0])
    of_amplitude = np.linalg.norm(change[:, 1:], axis=1) / np.linalg.norm(state[:, 1:], axis=1)
    return np.asarray(np.hypot(of_frequency, of_amplitude))


def _amplitudes(state: Floats) -> NDArray[np.complex128]:
    """(..., m) -> (..., n_sensors), a copy"""
    return state[..., 1:].copy().view(np.complex128)


def _joined(first: Floats, amplitudes: NDArray[np.complex128]) -> Floats:
    """(...) and (..., n_sensors) -> (..., m)"""
    values = np.empty((*first.shape, 1 + 2 * amplitudes.shape[-1]))
    values[..., 0], values[..., 1:] = first, amplitudes.view(np.float64)
    return values


def of_force(m: int) -> Floats:
    """(m,) what a unit of the force's logarithm does where amplitudes are proportional to the force."""
    return np.append(0.0, np.tile([1.0, 0.0], (m - 1) // 2))


@dataclass(frozen=True, eq=False)
class Observed:
    """At places along a branch. value: (..., m) logarithm of frequency, then of every amplitude and its phase;
    along: (..., m) its derivative by place; slopes: (..., p + 1, m) by the parameters and by the force's logarithm"""

    value: Floats
    along: Floats
    slopes: Floats


def with_patterns(branch: PredictedBranch, numerics: NumericalError) -> PredictedBranch:
    """The branch with the expected numerical error added, and with its patterns as further parameters, at 0; it has
    none yet."""
    condition = branch.condition
    found = numerics.at(condition.name, branch.observed.value, condition.wider, branch.u)
    moved = displaced(branch, found.expected) if numerics.names else branch
    of_model, columns = moved.slopes[:, :-1].copy(), of_state(found.patterns, moved.state)
    of_model[:, : found.by_parameter.shape[1]] += of_state(found.by_parameter, moved.state)
    slopes = np.concatenate([of_model, columns, moved.slopes[:, -1:]], axis=1)
    u = np.append(branch.u, np.zeros(columns.shape[1]))
    return replace(moved, u=u, slopes=slopes, rough=found.rough)


def displaced(branch: PredictedBranch, change: Floats) -> PredictedBranch:
    """The branch with changes (n, m) of its observations at its points, such as those that finer numerics make."""
    turn = np.exp(change[:, 1::2] + 1j * change[:, 2::2])
    state, along = branch.state.copy(), _turned(branch.along, turn)
    state[:, 0] += change[:, 0]
    state[:, 1:] = pairs((branch.state[:, 1::2] + 1j * branch.state[:, 2::2]) * turn)
    along += of_state(np.gradient(change, branch.place, axis=0)[:, None], state)[:, 0]
    return replace(branch, state=state, along=along, slopes=_turned(branch.slopes, turn[:, None]))


def _turned(change: Floats, turn: NDArray[np.complex128]) -> Floats:
    """Changes of the state whose amplitudes are multiplied by `turn`."""
    amplitude = (change[..., 1::2] + 1j * change[..., 2::2]) * turn
    return np.concatenate([change[..., :1], pairs(amplitude)], axis=-1)


def of_state(patterns: Floats, state: Floats) -> Floats:
    """Changes of the logarithms (n, k, m) as those of the state."""
    amplitude = state[:, None, 1::2] + 1j * state[:, None, 2::2]
    change = (patterns[..., 1::2] + 1j * patterns[..., 2::2]) * amplitude
    return np.concatenate([patterns[..., :1], pairs(change)], axis=-1)


def at_sizes(branch: PredictedBranch, u: Floats) -> PredictedBranch:
    """A branch with the patterns of numerical error as large as u has them.

    branch: solved at u, with patterns as its last parameters, at sizes of its own (`with_patterns`: 0)
    """
    apart = u - branch.u
    apart[: len(branch.w_by_parameter[0])] = 0.0  # the model's own parameters: it was solved there
    if not apart.any():
        return branch
    change = np.einsum("npm,p->nm", branch.observed.slopes[:, :-1], apart)
    return replace(displaced(branch, change), u=branch.u + apart)
