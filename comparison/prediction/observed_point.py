"""Solved points of a branch as the sensors see them, without the matrices of the point, and with these again.

An interpolated branch is made of `ObservedPoint`s: what the sensors show, and its derivatives. Matrices are 1 to 5 MB a
point. A branch in a fit is compared with runs, moved and kept; only what differentiates it by something new, or puts
measured motion into its equations, needs the matrices, and then one evaluation a point makes them.
"""

from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from typing import Any

import numpy as np
from numpy.typing import NDArray

from updamp.comparison.prediction.derivatives import Change, Derivatives, derivatives
from updamp.comparison.prediction.held_branch import force_at, pairs
from updamp.comparison.prediction.model_at import ModelAt
from updamp.comparison.prediction.run_condition import RunCondition
from updamp.hbm.continuation.branch import BranchPoint
from updamp.hbm.newton.equation import evaluate
from updamp.hbm.problem.system import Excitation

Floats = NDArray[np.float64]
_NOTHING: Any = None


def light(points: Sequence[BranchPoint]) -> tuple[BranchPoint, ...]:
    """Without equation and factors."""
    return tuple(
        replace(p, solution=replace(p.solution, equation=_NOTHING, jacobian=None, by_frequency=None)) for p in points
    )


def with_matrices(there: ModelAt, condition: RunCondition, points: Sequence[BranchPoint]) -> tuple[BranchPoint, ...]:
    """With the equation at each point, without its factors; there: what they were solved for."""
    found = []
    for point in points:
        equation = evaluate(there.system, there.excited_by(force_at(point, condition)), point.x, point.w)
        found.append(replace(point, solution=replace(point.solution, equation=equation)))
    return tuple(found)


@dataclass(frozen=True, eq=False)
class ObservedPoint:
    """point: without its matrices; state: (m,), along: (m,) by length of arc, slopes: (p + 1, m), x_by_parameter: (p,
    n_relative, n_coefficients) and w_by_parameter: (p,) as those of a `PredictedBranch`"""

    point: BranchPoint
    state: Floats
    along: Floats
    slopes: Floats
    x_by_parameter: Floats
    w_by_parameter: Floats

    def after_gap(self) -> "ObservedPoint":
        """As the first one beyond a piece of the branch that is left out."""
        return replace(self, point=replace(self.point, after_gap=True))

    def turned(self, step: float, after_gap: bool) -> "ObservedPoint":
        """As one of the branch followed the other way; step, after_gap: from the point that is the one before then."""
        point = replace(self.point.turned(), step=step, after_gap=after_gap)
        return replace(self, point=point, along=-self.along)


def turned_round(points: Sequence[ObservedPoint]) -> list[ObservedPoint]:
    """The same piece of a branch from its other end."""
    steps = [(0.0, False), *((o.point.step, o.point.after_gap) for o in reversed(points[1:]))]
    return [o.turned(step, gap) for o, (step, gap) in zip(reversed(points), steps, strict=True)]


# Points that are differentiated together, at most: arrays of so many points by all parameters take some 10 MB.
TOGETHER = 32


@dataclass(frozen=True, eq=False)
class Observer:
    """What the sensors of a run show at solved points.

    further: changes by parameters that the model does not have yet, after its own
    """

    there: ModelAt
    condition: RunCondition
    further: Sequence[Change] = ()

    def __call__(self, points: Sequence[BranchPoint]) -> list[ObservedPoint]:
        """raises: RuntimeError where the Jacobian is singular and no correction helps"""
        parts = [points[start : start + TOGETHER] for start in range(0, len(points), TOGETHER)]
        return [seen for part in parts for seen in self._together(part)]

    def _together(self, points: Sequence[BranchPoint]) -> list[ObservedPoint]:
        changes = (*self.there.changes, *self.further)
        found = derivatives(points, self._excitation, changes, self._rows)
        return [self._seen(point, d) for point, d in zip(points, found, strict=True)]

    def _seen(self, point: BranchPoint, d: Derivatives) -> ObservedPoint:
        state, along, slopes = self._state(d, point.w)
        # laid out as after a way between processes: sums over arrays laid out otherwise have other last digits
        kept = replace(
            light([point])[0], x=np.ascontiguousarray(point.x), tangent_x=np.ascontiguousarray(point.tangent_x)
        )
        return ObservedPoint(kept, state, along, slopes, np.ascontiguousarray(d.x_by_parameter), d.w_by_parameter)

    @cached_property
    def _excitation(self) -> Excitation:
        return self.there.excited_by(self.condition.force)

    @cached_property
    def _rows(self) -> NDArray[np.int64]:
        return np.array([self.there.system.free.row(point) for point, _ in self.condition.sensors])

    def _state(self, d: Derivatives, w: float) -> tuple[Floats, Floats, Floats]:
        """State, its derivative along the branch, and by the parameters and the force."""
        harmonics, orders = self.there.system.harmonics, [k for _, k in self.condition.sensors]

        def amplitudes(values: Floats) -> Floats:
            each = [harmonics.amplitude(values[..., i, :], k) for i, k in enumerate(orders)]
            return pairs(np.stack(each, axis=-1))

        slopes = amplitudes(np.concatenate([d.by_parameter, d.by_force[None]]))
        by_w = np.append(d.w_by_parameter, d.w_by_force) / w
        return (
            np.append(np.log(w / (2 * np.pi)), amplitudes(d.value)),
            np.append(d.w_along / w, amplitudes(d.along)),
            np.column_stack([by_w, slopes]),
        )
