"""The model's branch for one test, as a curve in what is observed, with its derivatives by the parameters.

Observed at every place along the branch: the logarithm of the frequency, then for every sensor and harmonic the
logarithm of the amplitude and the phase. Along the branch these are smooth where the response at a fixed frequency is
not, at turning points, and where it changes by multiples, at resonance. The patterns of numerical error join the
parameters (`with_patterns`); after a fit they are given the sizes that it has found (`at_sizes`).
"""

from collections.abc import Iterable, Sequence
from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np
from numpy.typing import NDArray
from scipy.interpolate import CubicHermiteSpline, PchipInterpolator

from updamp.comparison.prediction.derivatives import Change
from updamp.comparison.prediction.held_branch import HeldPoint, held_state, pairs, trace_held
from updamp.comparison.prediction.model_at import ModelAt, model_at
from updamp.comparison.prediction.numerical_error import NumericalError
from updamp.comparison.prediction.observed_point import ObservedPoint, Observer, light
from updamp.comparison.prediction.parameters import Parametrisation
from updamp.comparison.prediction.readings import as_read
from updamp.comparison.prediction.run_condition import RunCondition
from updamp.comparison.prediction.swept_points import BranchFromFarEnd, swept_points
from updamp.hbm.continuation.branch import BranchPoint
from updamp.hbm.continuation.continuation import ContinuationOptions, continue_branch
from updamp.hbm.continuation.sweeps import sweep

Floats = NDArray[np.float64]

# To what share of the largest amplitude a response has to be proportional to the force.
_LINEAR = 1e-6
# Amplitude that is as good as none [m]
_NONE = 1e-20


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
    def _curve(self) -> CubicHermiteSpline:
        return CubicHermiteSpline(self.place, self.state, self.along)

    @cached_property
    def _slopes(self) -> PchipInterpolator:
        return PchipInterpolator(self.place, self.slopes)

    @cached_property
    def observed(self) -> "Observed":
        """At its points"""
        return self.at(self.place)

    def at(self, place: Floats) -> "Observed":
        """What is observed at places along the branch."""
        state, along = self._curve(place), self._curve(place, 1)
        amplitude = state[..., 1::2] + 1j * state[..., 2::2]
        # as long as all contacts stick there is no higher harmonic at all
        amplitude = np.where(np.abs(amplitude) < _NONE, _NONE, amplitude)

        def relative(change: Floats) -> Floats:
            """Of the logarithms of frequency and amplitudes."""
            ratio = (change[..., 1::2] + 1j * change[..., 2::2]) / amplitude[..., None, :]
            return np.concatenate([change[..., :1], pairs(np.asarray(ratio))], axis=-1)

        value = np.concatenate([state[..., :1], pairs(np.log(amplitude))], axis=-1)
        slopes = relative(self._slopes(place))
        if self.proportional:
            slopes[..., -1, :] = np.append(0.0, np.tile([1.0, 0.0], amplitude.shape[-1]))
        return Observed(value, relative(along[..., None, :])[..., 0, :], slopes)

    def rough_at(self, place: Floats) -> Floats:
        """(..., 1 + 2 n_sensors)"""
        if self.rough is None:
            return np.zeros((*np.shape(place), self.state.shape[1]))
        return np.stack([np.interp(place, self.place, column) for column in self.rough.T], axis=-1)

    @cached_property
    def seen(self) -> NDArray[np.bool_]:
        """(n - 1,) whether a sweep sees what lies between a point and the next; not where the branch was not followed
        from one to the other: what is measured there is compared with the branch beside it."""
        followed = np.array([not point.after_gap for point in self.points[1:]], dtype=bool)
        return np.asarray(self.visited[:-1] & self.visited[1:] & followed)

    @property
    def frequency(self) -> Floats:
        """(n,) [Hz]"""
        return np.exp(self.state[:, 0])

    @property
    def amplitude(self) -> NDArray[np.complex128]:
        """(n, n_sensors) [m]"""
        return self.state[:, 1::2] + 1j * self.state[:, 2::2]


@dataclass(frozen=True, eq=False)
class Observed:
    """At places along a branch. value: (..., m) logarithm of frequency, then of every amplitude and its phase;
    along: (..., m) its derivative by place; slopes: (..., p + 1, m) by the parameters and by the force's logarithm"""

    value: Floats
    along: Floats
    slopes: Floats


def trace_branch(
    parametrisation: Parametrisation, u: Floats, condition: RunCondition, options: ContinuationOptions | None = None
) -> PredictedBranch:
    """Follow the branch through the measured window by continuation, and keep what the test's sweep sees of it.

    raises: BranchStoppedError where not even its first point is found
    """
    there = model_at(parametrisation, u)
    if condition.control is not None:
        return observe(there, condition, *trace_held(there, condition))
    system, excitation = there.model.system, there.model.excited_by(condition.force)
    low, high = condition.wider

    def follow(upwards: bool) -> Iterable[BranchPoint]:
        return continue_branch(system, excitation, (low, high), options, upwards)

    far_end = BranchFromFarEnd(lambda: follow(not condition.upwards), 2 * np.pi * (high - low))
    return observe_swept(there, condition, follow(condition.upwards), far_end=far_end)


def observe_swept(
    there: ModelAt,
    condition: RunCondition,
    points: Iterable[BranchPoint],
    stopped: str = "",
    far_end: BranchFromFarEnd | None = None,
) -> PredictedBranch:
    """What a sweep sees of solved points, with margins.

    stopped: why they end inside the window, if known beforehand; far_end: where to look for what a sweep jumps to

    raises: BranchStoppedError where the points end with it before there are enough of them
    """
    observed, reason = swept_points(points, condition.upwards, Observer(there, condition), far_end)
    return _of_observed(there, condition, observed, stopped or reason)


def observe(
    there: ModelAt, condition: RunCondition, points: Sequence[BranchPoint], stopped: str, further: Sequence[Change] = ()
) -> PredictedBranch:
    """Solved points as a branch; further: changes by parameters that the model does not have yet, after its own."""
    if condition.control is not None:
        return _observe_held(there, condition, points, stopped, further)
    look = Observer(there, condition, further)
    return _of_observed(there, condition, [look(point) for point in points], stopped, further)


def _of_observed(
    there: ModelAt,
    condition: RunCondition,
    observed: Sequence[ObservedPoint],
    stopped: str,
    further: Sequence[Change] = (),
) -> PredictedBranch:
    state, along, slopes = (np.array([getattr(o, part) for o in observed]) for part in ("state", "along", "slopes"))
    by_parameter = tuple(o.x_by_parameter for o in observed), np.array([o.w_by_parameter for o in observed])
    proportional = _is_proportional(state, along, slopes[:, -1])
    points = [o.point for o in observed]
    return _branch(there, condition, points, stopped, (state, along, slopes), by_parameter, proportional, further)


def _observe_held(
    there: ModelAt, condition: RunCondition, points: Sequence[BranchPoint], stopped: str, further: Sequence[Change]
) -> PredictedBranch:
    each = [held_state(there, condition, p, further) for p in points if isinstance(p, HeldPoint)]
    direction = 1.0 if condition.upwards else -1.0
    state, slopes = np.array([s.state for s in each]), np.array([s.slopes for s in each])
    along = direction * np.array([s.along for s in each])
    nothing = tuple(np.zeros(0) for _ in points), np.zeros((len(points), 0))
    return _branch(there, condition, light(points), stopped, (state, along, slopes), nothing, False, further)


def _branch(
    there: ModelAt,
    condition: RunCondition,
    points: Sequence[BranchPoint],
    stopped: str,
    observed: tuple[Floats, Floats, Floats],
    by_parameter: tuple[tuple[Floats, ...], Floats],
    proportional: bool,
    further: Sequence[Change],
) -> PredictedBranch:
    """observed: state, its derivative along the branch, and slopes; further: changes by parameters that are new"""
    state, along, slopes = as_read(observed, there.model.reading, (*there.changes, *further), condition)
    length = _length(along, state, condition)
    chords = _length(np.diff(state, axis=0), (state[1:] + state[:-1]) / 2, condition)
    visited = np.zeros(len(points), dtype=bool)
    visited[sweep(np.exp(state[:, 0]), condition.upwards).visited] = True
    place = np.concatenate([[0.0], np.cumsum(chords)])
    branch = PredictedBranch(
        condition,
        np.append(there.u[: there.parametrisation.n_of_model], np.zeros(len(further))),
        tuple(points),
        place,
        state,
        along / length[:, None],
        slopes,
        *by_parameter,
        visited,
        stopped,
        proportional,
    )
    return with_patterns(branch, there.parametrisation.numerics)


def with_patterns(branch: PredictedBranch, numerics: NumericalError) -> PredictedBranch:
    """The branch with the expected numerical error added, and with its patterns as further parameters, at 0; it has
    none yet."""
    condition = branch.condition
    expected, patterns, rough = numerics.at(condition.name, branch.observed.value, condition.wider)
    moved = displaced(branch, expected) if numerics.names else branch
    columns = of_state(patterns, moved.state)
    slopes = np.concatenate([moved.slopes[:, :-1], columns, moved.slopes[:, -1:]], axis=1)
    u = np.append(branch.u, np.zeros(patterns.shape[1]))
    return replace(moved, u=u, slopes=slopes, rough=rough)


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


def _is_proportional(state: Floats, along: Floats, by_force: Floats) -> bool:
    """Whether the slopes by the force's logarithm, moved along the branch to the same frequency, are the amplitudes."""
    if np.any(along[:, 0] == 0):
        return False
    held = by_force - by_force[:, :1] / along[:, :1] * along
    return bool(np.allclose(held[:, 1:], state[:, 1:], rtol=0, atol=_LINEAR * np.abs(state[:, 1:]).max()))


def of_state(patterns: Floats, state: Floats) -> Floats:
    """Changes of the logarithms (n, k, m) as those of the state."""
    amplitude = state[:, None, 1::2] + 1j * state[:, None, 2::2]
    change = (patterns[..., 1::2] + 1j * patterns[..., 2::2]) * amplitude
    return np.concatenate([patterns[..., :1], pairs(change)], axis=-1)


def _length(change: Floats, state: Floats, condition: RunCondition) -> Floats:
    """(n,) of changes of the state: amplitudes relative to all of them, and the whole window in frequency as much as
    half a turn of phase."""
    of_frequency = np.pi * change[:, 0] / np.log(condition.wider[1] / condition.wider[0])
    of_amplitude = np.linalg.norm(change[:, 1:], axis=1) / np.linalg.norm(state[:, 1:], axis=1)
    return np.asarray(np.hypot(of_frequency, of_amplitude))


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
