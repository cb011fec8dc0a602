"""The branch of a response-controlled test: the response held at its level, the force as it comes.

The state is that of a branch at the condition's force (`predicted_branch.py`) with every amplitude over the force that
it takes, times the condition's force: where nothing depends on the amplitude the two are the same. Its last slope is by
the logarithm of the level held, for the little that a controller is off it.
"""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from updamp.comparison.prediction.derivatives import Change, Moves, moves
from updamp.comparison.prediction.model_at import ModelAt
from updamp.comparison.prediction.run_condition import HeldResponse, RunCondition
from updamp.hbm.continuation.branch import BranchPoint, point_at
from updamp.hbm.continuation.continuation import BranchStoppedError
from updamp.hbm.harmonics import Harmonics
from updamp.hbm.newton.held_response import HeldAmplitude, HeldSolution, linear_start, solve_held
from updamp.hbm.problem.system import Excitation, NonlinearSystem

Floats = NDArray[np.float64]
Complex = NDArray[np.complex128]

# So many of the last points tell where the next one is: with two, Newton needs 3.5 evaluations a point, not 2.9.
_KNOWN = 4
# Steps in frequency, as shares of the window; and the change of phase and of amplitude from point to point.
_FIRST, _LARGEST, _SMALLEST = 1e-3, 0.03, 1e-6
_LONGEST = 0.2


@dataclass(frozen=True, eq=False)
class HeldPoint(BranchPoint):
    """force: that holds the response there [N]"""

    force: float = 0.0


def force_at(point: BranchPoint, condition: RunCondition) -> float:
    """[N] that a solved point of the condition's branch was solved with"""
    return point.force if isinstance(point, HeldPoint) else condition.force


def trace_held(there: ModelAt, condition: RunCondition) -> tuple[list[HeldPoint], str]:
    """Points through the measured window, and why they end inside it ("" where they do not): where something else than
    what is held is nonlinear, such as an absorber on it, the branch may turn back in frequency, and is not followed on.

    raises: BranchStoppedError where not even the first few are found
    """
    assert condition.control is not None, "asked for where the response was held"
    points: list[HeldPoint] = []
    try:
        for point in _points(there.system, there.model.excitation, condition, condition.control):
            points.append(point)
    except BranchStoppedError as stop:
        if len(points) < 4:
            raise
        return points, (
            f"the branch of the held response is followed to {stop.frequency:.6g} Hz: it turns back in frequency "
            f"there, where a controlled sweep jumps, or is lost ({stop.status.value}); what lies beyond is not known"
        )
    return points, ""


def _points(
    system: NonlinearSystem, excitation: str, condition: RunCondition, control: HeldResponse
) -> Iterator[HeldPoint]:
    """In the direction of the test, closer to each other where the response turns faster."""
    excited, row = system.free.row(excitation), system.free.row(control.point)
    low, high = (2 * np.pi * f for f in condition.wider)
    towards, width = (1.0, high - low) if condition.upwards else (-1.0, low - high)
    w, end = (low, high) if condition.upwards else (high, low)
    last = solve_held(
        system, (held := HeldAmplitude(excited, row, control.amplitude(w))), linear_start(system, held, w), w
    )
    if not last.converged:
        raise BranchStoppedError(w / (2 * np.pi), last.solution.errors[-1], last.solution.status)
    scale = abs(width)
    yield _point(last, excited, scale, towards, 0.0)
    step, known = _FIRST, [last]
    while w != end:
        following = w + step * width
        following = end if towards * (following - end) > 0 else following
        held = HeldAmplitude(excited, row, control.amplitude(following))
        found = solve_held(system, held, _ahead(known, following), following)
        turned = _turned(known[-1], found)
        if found.converged and turned < _LONGEST:
            yield _point(found, excited, scale, towards, abs(following - w))
            w, known = following, [*known, found][-_KNOWN:]
            step = min(step * min(2.0, 0.6 * _LONGEST / max(turned, 1e-12)), _LARGEST)
        elif step < _SMALLEST:
            raise BranchStoppedError(following / (2 * np.pi), found.solution.errors[-1], found.solution.status)
        else:
            step /= 2


def _ahead(known: Sequence[HeldSolution], w: float) -> tuple[Floats, float]:
    """Displacements and force there, on the polynomial through the last points (Lagrange's)."""
    places = np.array([s.solution.w for s in known])
    apart = places[:, None] - places + np.eye(len(known))
    factors = np.where(np.eye(len(known), dtype=bool), 1.0, (w - places) / apart)
    weights = factors.prod(axis=1)
    x = np.tensordot(weights, np.array([s.solution.x for s in known]), axes=1)
    return x, float(np.exp(weights @ np.log([s.force for s in known])))


def _turned(last: HeldSolution, found: HeldSolution) -> float:
    """How far the displacements over the force have moved, relative to what they are."""
    before, after = (s.solution.x / s.force for s in (last, found))
    return float(np.linalg.norm(after - before) / max(np.linalg.norm(before), np.finfo(float).tiny))


def _point(found: HeldSolution, excited: int, scale_w: float, towards: float, step: float) -> HeldPoint:
    solution = found.solution
    p = point_at(solution, Excitation(excited, found.force), scale_w, (0 * solution.x, towards), step)
    return HeldPoint(p.x, p.w, p.tangent_x, p.tangent_w, p.metric, p.step, p.after_gap, p.solution, force=found.force)


@dataclass(frozen=True, eq=False)
class HeldState:
    """At one point. state: (m,); along: (m,) by the frequency; slopes: (p + 1, m) by the parameters and by the
    logarithm of the level, as `PredictedBranch` has them"""

    state: Floats
    along: Floats
    slopes: Floats


def held_states(
    there: ModelAt, condition: RunCondition, points: Sequence[HeldPoint], further: Sequence[Change]
) -> list[HeldState]:
    """raises: RuntimeError where a Jacobian is singular and no correction helps"""
    assert condition.control is not None, "asked for where the response was held"
    system = there.system
    rows = np.array([system.free.row(p) for p, _ in (*condition.sensors, (condition.control.point, 1))])
    excited, forces = system.free.row(there.model.excitation), np.array([point.force for point in points])
    found = moves(points, excited, forces, (*there.changes, *further), rows)
    return [
        _held_state(system.harmonics, condition, condition.control, point, of_point)
        for point, of_point in zip(points, found, strict=True)
    ]


def _held_state(
    harmonics: Harmonics, condition: RunCondition, control: HeldResponse, point: HeldPoint, found: Moves
) -> HeldState:
    w, orders = point.w, [*(k for _, k in condition.sensors), 1]
    value: Complex = np.array([harmonics.amplitude(found.value[i], k) for i, k in enumerate(orders)], dtype=complex)
    # by the parameters, the logarithm of the force and the angular frequency; that along at held force is not wanted
    moved = [harmonics.amplitude(found.dy[i].T, k) for i, k in enumerate(orders)]
    by: Complex = np.array(moved, dtype=complex)[:, :-1]
    of_held = (by[-1] / value[-1]).real
    # what the force has to do for the level to be held
    wanted = np.zeros(by.shape[1])
    wanted[-1] = -control.derivatives / w
    log_force = (wanted - of_held) / of_held[-2]
    log_force[-2] = 1 / of_held[-2]
    change = by + by[:, -2:-1] * log_force
    change[:, -2] = by[:, -2] * log_force[-2]
    change -= value[:, None] * log_force
    scale = complex(condition.force / point.force)
    return _with_place_held(scale * value[:-1], scale * change[:-1], w)


def _with_place_held(value: Complex, change: Complex, w: float) -> HeldState:
    """The place is held where the motion changes least, as on branches at held force (`derivatives.py`).

    value: (n_sensors,); change: (n_sensors, p + 2), last by the angular frequency
    """
    relative = change / np.maximum(np.abs(value), np.finfo(float).tiny)[:, None]
    parts = np.concatenate([relative.real, relative.imag])
    shift = np.append(parts[:, -1] * w, 1.0)
    log_w = -(shift[:-1] @ parts[:, :-1]) / (shift @ shift)
    moved = change[:, :-1] + change[:, -1:] * w * log_w
    state = np.append(np.log(w / (2 * np.pi)), pairs(value))
    along = np.append(1 / w, pairs(change[:, -1]))
    return HeldState(state, along, np.column_stack([log_w, pairs(moved.T)]))


def pairs(values: Complex) -> Floats:
    """Real and imaginary parts side by side: (..., n) -> (..., 2 n)"""
    return np.stack([values.real, values.imag], axis=-1).reshape(*values.shape[:-1], 2 * values.shape[-1])
