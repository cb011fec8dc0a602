"""Solved points of one test as a branch in what is observed: followed by continuation, or given."""

from collections.abc import Iterable, Sequence
from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from updamp.comparison.prediction.derivatives import Change
from updamp.comparison.prediction.held_branch import HeldPoint, held_states, trace_held
from updamp.comparison.prediction.model_at import ModelAt, model_at
from updamp.comparison.prediction.observed_point import ObservedPoint, Observer, light, turned_round
from updamp.comparison.prediction.parameters import Parametrisation
from updamp.comparison.prediction.predicted_branch import PredictedBranch, length_of, with_patterns
from updamp.comparison.prediction.readings import as_read
from updamp.comparison.prediction.refined import Between, points_between, refined
from updamp.comparison.prediction.run_condition import RunCondition
from updamp.comparison.prediction.swept_points import BranchFromFarEnd, swept_points
from updamp.hbm.continuation.branch import BranchPoint
from updamp.hbm.continuation.continuation import ContinuationOptions, continue_branch
from updamp.hbm.continuation.sweeps import sweep

Floats = NDArray[np.float64]

# To what share of the largest amplitude a response has to be proportional to the force.
_LINEAR = 1e-6


def trace_branch(
    parametrisation: Parametrisation, u: Floats, condition: RunCondition, options: ContinuationOptions | None = None
) -> PredictedBranch:
    """Follow the branch through the measured window by continuation, and keep what the test's sweep sees of it.

    raises: BranchStoppedError where not even its first point is found
    """
    return trace_sweeps(parametrisation, u, (condition,), options)[0]


def trace_sweeps(
    parametrisation: Parametrisation,
    u: Floats,
    conditions: Sequence[RunCondition],
    options: ContinuationOptions | None = None,
) -> tuple[PredictedBranch, ...]:
    """Likewise, of tests that sweep the same branch, which is followed once.

    raises: BranchStoppedError where not even its first point is found
    """
    condition = solved_in(parametrisation, u, conditions)
    there = model_at(parametrisation, u, condition)
    if condition.control is not None:
        return (observe(there, conditions[0], *trace_held(there, condition)),)
    system, excitation = there.system, there.excited_by(condition.force)
    low, high = condition.wider
    # A test may be recorded inside a hysteresis alone, which the curve of the rig file's window shows whole.
    outer = there.model.windows.get(condition.mode, condition.wider)

    def follow(upwards: bool) -> Iterable[BranchPoint]:
        begin = outer[0] if upwards else outer[1]
        return continue_branch(system, excitation, (low, high), options, upwards, from_outside=begin)

    far_end = BranchFromFarEnd(lambda: follow(not condition.upwards), 2 * np.pi * (high - low))
    found = observe_sweeps(there, conditions, follow(condition.upwards), far_end=far_end)
    if not found[0].stopped:
        return found
    # where it stops is no end that a sweep from the other side begins at
    others = (trace_sweeps(parametrisation, u, (other,), options)[0] for other in conditions[1:])
    return found[0], *others


def solved_in(parametrisation: Parametrisation, u: Floats, conditions: Sequence[RunCondition]) -> RunCondition:
    """The tests as one, in the window that their branch is to be solved in at parameters u."""
    window_of = parametrisation.numerics.solved_window
    windows = [w for c in conditions for w in (window_of(c.name, c.window, u), c.solved) if w is not None]
    low, high = zip(*windows, strict=True)
    return replace(conditions[0].along_with(conditions[1:]), window=(min(low), max(high)))


def observe_sweeps(
    there: ModelAt,
    conditions: Sequence[RunCondition],
    points: Iterable[BranchPoint],
    stopped: str = "",
    far_end: BranchFromFarEnd | None = None,
) -> tuple[PredictedBranch, ...]:
    """What sweeps of the same branch see of solved points, with margins. A sweep in the other direction sees the same:
    the parts on either side of a hysteresis, each up to its fold.

    points: in the direction of the first of the conditions; stopped: why they end inside the window, if known
        beforehand; far_end: where to look for what a sweep jumps to

    raises: BranchStoppedError where the points end with it before there are enough of them
    """
    condition = solved_in(there.parametrisation, there.u, conditions)
    look = Observer(there, condition)
    observed, reason = swept_points(points, condition.upwards, look, far_end)
    seen = refined(observed, condition, _half_way(there, condition, look))
    return tuple(
        _of_observed(there, c, seen if c.upwards == condition.upwards else turned_round(seen), stopped or reason)
        for c in conditions
    )


def _half_way(there: ModelAt, condition: RunCondition, look: Observer) -> Between:
    """What is solved, and seen, between two points each."""
    system, excitation = there.system, there.excited_by(condition.force)

    def between(pairs: Sequence[tuple[ObservedPoint, ObservedPoint]]) -> list[ObservedPoint | None]:
        points = points_between(system, excitation, [(a.point, b.point) for a, b in pairs])
        seen = iter(look([point for point in points if point is not None]))
        return [None if point is None else next(seen) for point in points]

    return between


def observe(
    there: ModelAt, condition: RunCondition, points: Sequence[BranchPoint], stopped: str, further: Sequence[Change] = ()
) -> PredictedBranch:
    """Solved points as a branch; further: changes by parameters that the model does not have yet, after its own."""
    if condition.control is not None:
        return _observe_held(there, condition, points, stopped, further)
    look = Observer(there, condition, further)
    return _of_observed(there, condition, look(points), stopped, further)


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
    each = held_states(there, condition, [p for p in points if isinstance(p, HeldPoint)], further)
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
    length = length_of(along, state, condition)
    chords = length_of(np.diff(state, axis=0), (state[1:] + state[:-1]) / 2, condition)
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


def _is_proportional(state: Floats, along: Floats, by_force: Floats) -> bool:
    """Whether the slopes by the force's logarithm, moved along the branch to the same frequency, are the amplitudes."""
    if np.any(along[:, 0] == 0):
        return False
    held = by_force - by_force[:, :1] / along[:, :1] * along
    return bool(np.allclose(held[:, 1:], state[:, 1:], rtol=0, atol=_LINEAR * np.abs(state[:, 1:]).max()))
