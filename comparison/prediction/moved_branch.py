"""A branch at other parameters from the points that it had before: a fraction of the work of tracing it."""

from collections.abc import Sequence
from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from updamp.comparison.prediction.lifted_branch import lifted
from updamp.comparison.prediction.model_at import ModelAt, model_at
from updamp.comparison.prediction.parameters import Parametrisation
from updamp.comparison.prediction.predicted_branch import PredictedBranch
from updamp.comparison.prediction.refined import NEWTON, points_between
from updamp.comparison.prediction.run_condition import RunCondition
from updamp.comparison.prediction.traced_branch import observe_sweeps, solved_in
from updamp.hbm.continuation.branch import BranchPoint, other_way_round, point_at
from updamp.hbm.continuation.continuation import BranchStoppedError, ContinuationOptions, continue_branch
from updamp.hbm.newton.newton import Arc, Solution, solve_together
from updamp.hbm.problem.system import Excitation, NonlinearSystem

Floats = NDArray[np.float64]
Points = Sequence[BranchPoint]

# A branch moved by changes of the parameters has to reach beyond them by this much still.
_SPARE = 0.04
# Longest step between points, over the longest of a trace: beyond it an interpolation would not follow.
_STRETCHED = 1.5
# Share of the points that may be lost on the way.
_LOST = 0.25


def move_branch(
    parametrisation: Parametrisation, u: Floats, before: PredictedBranch, options: ContinuationOptions | None = None
) -> PredictedBranch | None:
    """As `move_sweeps`, of the branch's own test."""
    found = move_sweeps(parametrisation, u, before, (before.condition,), options)
    return None if found is None else found[0]


def move_sweeps(
    parametrisation: Parametrisation,
    u: Floats,
    before: PredictedBranch,
    conditions: Sequence[RunCondition],
    options: ContinuationOptions | None = None,
) -> tuple[PredictedBranch, ...] | None:
    """Points that stand for the branch, each corrected across it from where its derivatives put it; where that leaves
    gaps, or an interpolation is off by more than the noise, points are put between; where it no longer covers the
    measured window the branch is followed further. None where that fails.

    Not all of its points: they lie close where contacts begin to slip, and that moves with the parameters. To move all
    takes half as long again and ends no closer to a traced branch (benchmarks/hidden_effects/NOTES.md).

    The branch's parameters may be fewer than those now: its derivatives are of the first ones. A branch with
    the response held is not moved: it is soon traced.

    conditions: tests that sweep the branch, the first of them in its direction
    """
    condition = solved_in(parametrisation, u, conditions)
    if condition.control is not None:
        return None
    there = model_at(parametrisation, u, condition)
    system, excitation = there.system, there.excited_by(condition.force)
    begin = _on_rows_of(there, before.thinned())
    if begin is None:
        return None
    before = begin
    moved = _moved(there, before, excitation)
    if len(moved) < (1 - _LOST) * len(before.points):
        return None
    steps = options or ContinuationOptions()
    filled = _filled(system, excitation, moved, _STRETCHED * steps.largest_step)
    if filled is None:
        return None
    covering = filled if before.stopped else _covering(system, excitation, filled, condition, steps)
    if covering is None:
        return None
    found = observe_sweeps(there, conditions, covering, before.stopped)
    return found if _visible_gaps(found[0]) <= _visible_gaps(before) else None


def _on_rows_of(there: ModelAt, before: PredictedBranch) -> PredictedBranch | None:
    """The branch on the rows that are solved, where an effect has brought elements of its own or harmonics, or taken a
    symmetry; None where it was solved with other ones."""
    system = there.system
    same = before.points[0].x.shape == (system.free.n_relative, system.harmonics.n_coefficients)
    return before if same else lifted(before, there)


def _visible_gaps(branch: PredictedBranch) -> int:
    """How many gaps the sweep sees an edge of: of what was left out because it does not see it, it is not to."""
    return sum(bool(branch.visited[i - 1 : i + 1].any()) for i, p in enumerate(branch.points) if i and p.after_gap)


def _moved(there: ModelAt, before: PredictedBranch, excitation: Excitation) -> list[BranchPoint]:
    """Without those that do not converge, or come to lie behind the one that they were ahead of: points on either side
    of where a contact begins to slip move by different amounts."""
    moved: list[BranchPoint] = []
    last, gap = before.points[0], False
    solutions = _solved(there.system, excitation, _predicted(there, before))
    for point, solution in zip(before.points, solutions, strict=True):
        gap = gap or point.after_gap
        if not solution.converged:
            continue
        if moved and not gap and _ahead(last, point) and not _ahead(moved[-1], solution):
            continue
        moved.append(point_at(solution, excitation, point.metric.scale_w, point.tangent, point.step, gap))
        last, gap = point, False
    return moved


def _solved(system: NonlinearSystem, excitation: Excitation, arcs: Sequence[Arc]) -> list[Solution]:
    """Those that are not found from where they were put are tried once more from what the nearest ones that were found
    were corrected by."""
    solutions = solve_together(system, excitation, arcs, NEWTON)
    found = np.flatnonzero([s.converged for s in solutions])
    lost = np.setdiff1d(np.arange(len(arcs)), found)
    if not (len(found) and len(lost)):
        return solutions
    again = []
    for i in lost:
        beside = found[np.unique(np.clip(np.searchsorted(found, i) - [1, 0], 0, len(found) - 1))]
        share = 1 / np.abs(beside - i)
        dx = np.average([solutions[j].x - arcs[j].x0 for j in beside], axis=0, weights=share)
        dw = np.average([solutions[j].w - arcs[j].w0 for j in beside], weights=share)
        again.append(replace(arcs[i], x0=arcs[i].x0 + dx, w0=arcs[i].w0 + float(dw)))
    for i, solution in zip(lost, solve_together(system, excitation, again, NEWTON), strict=True):
        solutions[i] = solution
    return solutions


def _predicted(there: ModelAt, before: PredictedBranch) -> list[Arc]:
    """Across the branch, from where each point's derivatives put it"""
    arcs = []
    for i, point in enumerate(before.points):
        known = len(before.w_by_parameter[i])
        du = there.u[:known] - before.u[:known]
        x = point.x + np.tensordot(du, before.x_by_parameter[i], axes=1)
        arcs.append(Arc(x, point.w + float(before.w_by_parameter[i] @ du), point.tangent, point.metric))
    return arcs


def _ahead(point: BranchPoint, other: BranchPoint | Solution) -> bool:
    return point.metric.product(point.move_to(other), point.tangent) > 0


def _filled(
    system: NonlinearSystem, excitation: Excitation, points: Points, longest: float
) -> list[BranchPoint] | None:
    """With points between those that are too far apart; None where none is found there."""
    filled = list(points[:1])
    for point in points[1:]:
        waiting = [point]
        while waiting:
            last, following = filled[-1], waiting[-1]
            if following.after_gap or last.distance(following) <= longest:
                filled.append(waiting.pop())
                continue
            (middle,) = points_between(system, excitation, [(last, following)])
            if middle is None:
                return None
            waiting.append(middle)
    return filled


def _covering(
    system: NonlinearSystem, excitation: Excitation, points: Points, condition: RunCondition, steps: ContinuationOptions
) -> list[BranchPoint] | None:
    """Followed beyond the measured window, with something to spare for shifts to first order, at both ends."""
    low, high = condition.window
    spare = _SPARE * (high - low)

    def outside(point: BranchPoint) -> bool:
        return not low - spare < point.frequency < high + spare

    try:
        found = list(points)
        for _ in range(2):
            if not outside(found[-1]):
                # the direction follows from the points before
                found += continue_branch(system, excitation, condition.wider, steps, resume_from=found)
            found = other_way_round(_trimmed(found, condition))
    except BranchStoppedError:
        return None
    return found


def _trimmed(points: list[BranchPoint], condition: RunCondition) -> list[BranchPoint]:
    """Without those at the end that lie further outside than the first one beyond the wider window."""
    low, high = condition.wider
    last = len(points)
    while last > 2 and all(not low <= point.frequency <= high for point in points[last - 2 : last]):
        last -= 1
    return points[:last]
