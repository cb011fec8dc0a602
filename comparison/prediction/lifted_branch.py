"""A branch as that of the model with further effects, which may bring elements of their own, harmonics, or take a
symmetry away. From there its points are moved: elements that are new move as the structure does where they are put in,
and exert nothing yet; of harmonics that are new there is nothing yet.

That is far from the solution where a mean position is new that nothing but soft wires holds, and still Newton's method
takes two to seven steps from there, all points of a branch together, where to trace it anew takes ten times as long."""

from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from updamp.comparison.prediction.model_at import ModelAt, added_points
from updamp.comparison.prediction.numerical_error import NumericalError
from updamp.comparison.prediction.parameters import Parametrisation
from updamp.comparison.prediction.predicted_branch import PredictedBranch
from updamp.hbm.continuation.branch import BranchPoint
from updamp.hbm.newton.metric import Metric
from updamp.hbm.problem.receptance_along import ReceptanceAlong

Floats = NDArray[np.float64]


def lifted(before: PredictedBranch, there: ModelAt) -> PredictedBranch | None:
    """The same points on the rows and with the harmonics of the model with all effects; None where the branch was
    solved with other ones than the model without them has.

    there: with the effects that the branch was solved with, and further ones after these
    """
    known = before.w_by_parameter.shape[1]
    parametrisation = _with_parameters(there.parametrisation, known)
    without = ModelAt(parametrisation, before.u[:known], there.place)
    solved = without.system.free.n_relative, without.system.harmonics.n_coefficients
    own, wider = without.model.harmonics.orders, there.model.harmonics.orders
    if before.points[0].x.shape != solved or not set(own) <= set(wider):
        return None
    rows = _Rows(without, there)
    points = [
        rows.of_point(point, np.ascontiguousarray(x))
        for point, x in zip(before.points, np.moveaxis(rows.of_motion(before), 2, 0), strict=True)
    ]
    changes = tuple(rows.of_change(change) for change in before.x_by_parameter)
    return replace(before, points=tuple(points), x_by_parameter=changes)


def _with_parameters(parametrisation: Parametrisation, number: int) -> Parametrisation:
    """With the first effects alone, so many parameters in all"""
    found = replace(parametrisation, numerics=NumericalError())
    while len(found) > number:
        found = replace(found, effects=found.effects[:-1])
    return found


@dataclass(frozen=True, eq=False)
class _Rows:
    """From what was solved without the further effects to what is to be solved with them."""

    without: ModelAt
    there: ModelAt

    @property
    def _added(self) -> tuple[str, ...]:
        """Points of further elements, in their order"""
        return added_points(self.without.model, self.there.model)

    def of_point(self, point: BranchPoint, x: Floats) -> BranchPoint:
        """x: (n_relative, n_coefficients) of it [m], with what is new"""
        changed = replace(point, x=x, tangent_x=self.of_change(point.tangent_x))
        if self.without.model.harmonics == self.there.model.harmonics:
            return changed
        return replace(changed, metric=Metric.at(x, self.there.model.harmonics, point.metric.scale_w))

    def of_motion(self, before: PredictedBranch) -> Floats:
        """(n_relative, n_coefficients, n_points) relative displacements [m] at the points of a branch"""
        model = self.without.model
        x = np.stack([self.without.whole(point.x) for point in before.points], axis=2)
        along = ReceptanceAlong(model.system, np.array([point.w for point in before.points]))
        departure = model.system.departure_values(x, along.w)
        forces = np.full(len(along.w), before.condition.force)
        rows = np.array([model.free.row(point) for point in self._added], dtype=np.int64)
        added = along.motion(model.free.row(model.excitation), forces, departure, rows)
        return np.moveaxis(self._solved(np.moveaxis(np.concatenate([x, added]), 2, 0)), 0, 2)

    def of_change(self, change: Floats) -> Floats:
        """Of relative displacements (..., n_relative, n_coefficients); that of further elements is not known"""
        whole = self.without.whole(change)
        added = np.zeros((*whole.shape[:-2], len(self._added), whole.shape[-1]))
        return self._solved(np.concatenate([whole, added], axis=-2))

    def _solved(self, x: Floats) -> Floats:
        """What is solved with all effects, of relative displacements (..., n_relative, n_coefficients) of the whole
        model in the harmonics without the further ones"""
        own, wider = self.without.model.harmonics, self.there.model.harmonics
        return self.there.solved(own.among(wider, x))
