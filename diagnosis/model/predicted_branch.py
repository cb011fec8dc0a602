"""The model's branch for one test, as a curve in what is observed, with its derivatives by the parameters.

Observed at every place along the branch: the logarithm of the frequency, then for every sensor and harmonic the
logarithm of the amplitude and the phase. Along the branch these are smooth where the response at a fixed frequency is
not, at turning points, and where it changes by multiples, at resonance.
"""

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numpy.typing import NDArray
from scipy.interpolate import CubicHermiteSpline, PchipInterpolator

from updamp.diagnosis.model.derivatives import Change, Derivatives, derivatives
from updamp.diagnosis.model.parameters import Parametrisation
from updamp.hbm.branch import BranchPoint, point_at
from updamp.hbm.continuation import BranchStoppedError, ContinuationOptions, continue_branch
from updamp.hbm.newton import Arc, NewtonOptions, solve
from updamp.hbm.sweeps import sweep
from updamp.hbm.system import Excitation, NonlinearSystem

Floats = NDArray[np.float64]
Integers = NDArray[np.int64]

# The branch is followed beyond the measured frequencies by this share of their range.
_BEYOND = 0.15
_STEP = 1e-4  # of a parameter, for differences


@dataclass(frozen=True)
class Condition:
    """A test as the model sees it: one run without its repeats.

    force: amplitude [N]; window: measured frequencies [Hz]
    sensors: (point of the model, harmonic), in the order of the observations
    """

    name: str
    mode: str
    force: float
    upwards: bool
    window: tuple[float, float]
    sensors: tuple[tuple[str, int], ...]

    @property
    def wider(self) -> tuple[float, float]:
        low, high = self.window
        return low - _BEYOND * (high - low), high + _BEYOND * (high - low)


@dataclass(frozen=True, eq=False)
class PredictedBranch:
    """place: (n,) length along the branch in the metric of observations
    observed: (n, 1 + 2 n_sensors); along: its derivative by place
    by_parameter: (n, n_parameters, 1 + 2 n_sensors); by_force: (n, 1 + 2 n_sensors) by the logarithm of the force
    visited: (n,) whether a slow sweep in the test's direction sees it
    stopped: why the branch ends inside the window, "" if it does not
    """

    condition: Condition
    points: tuple[BranchPoint, ...]
    place: Floats
    observed: Floats
    along: Floats
    by_parameter: Floats
    by_force: Floats
    visited: NDArray[np.bool_]
    stopped: str

    @cached_property
    def curve(self) -> CubicHermiteSpline:
        return CubicHermiteSpline(self.place, self.observed, self.along)

    @cached_property
    def slopes(self) -> PchipInterpolator:
        """(n_parameters + 1, 1 + 2 n_sensors) at a place: by the parameters, then by the force."""
        return PchipInterpolator(self.place, np.concatenate([self.by_parameter, self.by_force[:, None]], axis=1))

    @property
    def frequency(self) -> Floats:
        """(n,) [Hz]"""
        return np.exp(self.observed[:, 0])


def trace_branch(
    parametrisation: Parametrisation, u: Floats, condition: Condition, options: ContinuationOptions | None = None
) -> PredictedBranch:
    """Follow the branch through the measured window by continuation.

    raises: BranchStoppedError where not even its first point is found
    """
    model = parametrisation.model(u)
    excitation, points, stopped = model.excited_by(condition.force), [], ""
    try:
        for point in continue_branch(model.system, excitation, condition.wider, options, condition.upwards):
            points.append(point)
    except BranchStoppedError as stop:
        if len(points) < 4:
            raise
        stopped = str(stop)
    return _observe(parametrisation, u, condition, points, stopped)


def move_branch(
    parametrisation: Parametrisation, u: Floats, before: PredictedBranch, guess: Sequence[Floats] | None = None
) -> PredictedBranch | None:
    """The branch at other parameters, each point corrected across the branch; None where one does not converge.

    guess: displacements to start from, by default those of the points themselves
    """
    model = parametrisation.model(u)
    excitation = model.excited_by(before.condition.force)
    moved: list[BranchPoint] = []
    for i, point in enumerate(before.points):
        x = point.x if guess is None else guess[i]
        arc = Arc(point.x, point.w, point.tangent, point.metric)
        solution = solve(model.system, excitation, x, point.w, NewtonOptions(), arc)
        if not solution.converged:
            return None
        after = point_at(solution, excitation, point.metric.scale_w, point.tangent, point.step, point.after_gap)
        moved.append(after)
    return _observe(parametrisation, u, before.condition, moved, before.stopped)


def changes(parametrisation: Parametrisation, u: Floats) -> tuple[Change, ...]:
    """Differences for every parameter: central, or to one side where a bound is near."""
    found = []
    for j in range(len(parametrisation)):
        step = np.zeros(len(u))
        step[j] = _STEP
        low = u - step if u[j] - _STEP >= parametrisation.lower[j] else u
        high = u + step if u[j] + _STEP <= parametrisation.upper[j] else u
        below, above = parametrisation.model(low).system, parametrisation.model(high).system
        found.append(Change(below, above, float(high[j] - low[j])))
    return tuple(found)


def _observe(
    parametrisation: Parametrisation,
    u: Floats,
    condition: Condition,
    points: Sequence[BranchPoint],
    stopped: str,
) -> PredictedBranch:
    model = parametrisation.model(u)
    system, excitation = model.system, model.excited_by(condition.force)
    rows = np.array([system.free.row(point) for point, _ in condition.sensors])
    by_differences = changes(parametrisation, u)
    found = [derivatives(p, excitation, by_differences, rows) for p in points]
    each = [_in_logarithms(d, p.w, system, condition) for d, p in zip(found, points, strict=True)]
    observed = np.array([e[0] for e in each])
    observed[:, 2::2] = np.unwrap(observed[:, 2::2], axis=0)
    along = np.array([e[1] for e in each])
    slopes = np.array([e[2] for e in each])
    frequency = np.exp(observed[:, 0])
    visited = np.zeros(len(points), dtype=bool)
    visited[sweep(frequency, condition.upwards).visited] = True
    weights = _weights(observed, condition)
    length = np.linalg.norm(weights * along, axis=1)
    along = along / length[:, None]
    place = np.concatenate([[0.0], np.cumsum(np.linalg.norm(weights * np.diff(observed, axis=0), axis=1))])
    return PredictedBranch(
        condition, tuple(points), place, observed, along, slopes[:, :-1], slopes[:, -1], visited, stopped
    )


def _weights(observed: Floats, condition: Condition) -> Floats:
    """Amplitude and phase count as they are, and the whole window in frequency as much as half a turn of phase."""
    weights = np.ones(observed.shape[1]) / np.sqrt(len(condition.sensors))
    weights[0] = np.pi / np.log(condition.wider[1] / condition.wider[0])
    return weights


def _in_logarithms(
    d: Derivatives, w: float, system: NonlinearSystem, condition: Condition
) -> tuple[Floats, Floats, Floats]:
    """Observations, their derivative along the branch, and by the parameters and the force (last)."""
    orders = [k for _, k in condition.sensors]
    pick = range(len(orders))
    amplitude = np.array([system.harmonics.amplitude(d.value[i], k) for i, k in zip(pick, orders, strict=True)])
    along = np.array([system.harmonics.amplitude(d.along[i], k) for i, k in zip(pick, orders, strict=True)])
    all_parameters = np.concatenate([d.by_parameter, d.by_force[None]])
    slopes = np.stack(
        [system.harmonics.amplitude(all_parameters[:, i], k) for i, k in zip(pick, orders, strict=True)], axis=1
    )
    observed = np.concatenate([[np.log(w / (2 * np.pi))], _pairs(np.log(amplitude))])
    rates = np.concatenate([[d.w_along / w], _pairs(along / amplitude)])
    w_slopes = np.append(d.w_by_parameter, d.w_by_force) / w
    return observed, rates, np.column_stack([w_slopes, _pairs(slopes / amplitude)])


def _pairs(values: NDArray[np.complex128]) -> Floats:
    """Real and imaginary parts side by side: (..., n) -> (..., 2 n)"""
    return np.stack([values.real, values.imag], axis=-1).reshape(*values.shape[:-1], -1)


def excitation_of(parametrisation: Parametrisation, u: Floats, condition: Condition) -> Excitation:
    return parametrisation.model(u).excited_by(condition.force)
