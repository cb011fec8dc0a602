"""Nonlinear least squares on targets with tolerances: how a rig is identified from published or measured numbers.

The residuals are (response - target) / tolerance. The designs of a finite-difference Jacobian are solved together.
"""

from collections.abc import Sequence
from typing import Annotated, Any

import numpy as np
from numpy.typing import NDArray
from pydantic import Field
from scipy.optimize import least_squares

from updamp.design.goals import Objective, Target
from updamp.design.methods.method import Evaluate, Method, MethodResult, Problem, method
from updamp.design.records import Record
from updamp.design.variables import Variable

Floats = NDArray[np.float64]

_INSIDE = 1e-3  # of the range: a fit does not begin on a bound
_REFUSED = 10.0  # times the largest residual so far, where a response is not known: the step is shortened


@method("least_squares")
class LeastSquares(Method):
    """step: of the finite differences, as a share of each variable's range; accuracy: relative change of the misfit or
    of the variables at which it ends; rounds: Jacobians at most"""

    step: Annotated[float, Field(gt=0, lt=0.5)] = 0.01
    accuracy: Annotated[float, Field(gt=0, lt=0.1)] = 1e-4
    rounds: Annotated[int, Field(strict=True, ge=1)] = 20

    def problem(self, variables: Sequence[Variable], objectives: Sequence[Objective]) -> str:
        return only_targets(variables, objectives)

    def run(self, problem: Problem, evaluate: Evaluate) -> MethodResult:
        """raises: ValueError where a response is not known at the start, or on both sides of a design"""
        misfit = _Misfit(problem, evaluate, self.step)
        start = np.array([one.share(one.initial) for one in problem.variables])
        found = least_squares(
            misfit, np.clip(start, _INSIDE, 1 - _INSIDE), misfit.jacobian, bounds=(0, 1), x_scale="jac",
            xtol=self.accuracy, ftol=self.accuracy, max_nfev=self.rounds,
        )  # fmt: skip
        return _result(problem, found, misfit)


def only_targets(variables: Sequence[Variable], objectives: Sequence[Objective]) -> str:
    """Why a method that meets targets by derivatives cannot be used, "" where it can."""
    if not objectives:
        return 'targets are missing; add [[objectives]] with goal = "target", target and tolerance'
    other = next((one for one in objectives if not isinstance(one.goal, Target)), None)
    if other is not None:
        return f'the objective "{other.response}" is to be {other.goal.words}d; give all of them goal = "target"'
    whole = next((one.name for one in variables if one.whole), None)
    return f'the variable "{whole}" is an integer, which has no derivative; take it out' if whole else ""


class _Misfit:
    """Residuals and their derivatives by the variables' shares of their ranges, 0 to 1."""

    def __init__(self, problem: Problem, evaluate: Evaluate, step: float) -> None:
        self.problem, self.evaluate, self.step = problem, evaluate, step
        self.largest = 0.0
        self.solved: Record | None = None  # at the last x

    def __call__(self, x: Floats) -> Floats:
        (record,) = self.evaluate([self.problem.values(x)])
        residuals = self._residuals(record)
        if residuals is not None:
            self.largest, self.solved = max(self.largest, float(np.abs(residuals).max())), record
            return residuals
        if self.solved is None:
            raise ValueError(f"a response is not known at the initial values: {record.reason}; begin elsewhere")
        return np.full(len(self.problem.objectives), _REFUSED * (1 + self.largest))

    def jacobian(self, x: Floats) -> Floats:
        """(n_objectives, n_variables)"""
        steps = np.where(x + self.step <= 1, self.step, -self.step)
        here, *moved = self.evaluate([self.problem.values(p) for p in (x, *(x + np.diag(steps)))])
        columns = []
        for i, record in enumerate(moved):
            other = float(np.clip(x[i] - steps[i], 0, 1) - x[i])  # shorter beside a bound, where variables end
            if self._residuals(record) is None and other:
                steps[i] = other
                (record,) = self.evaluate([self.problem.values(x + other * np.eye(len(x))[i])])
            columns.append(self._difference(here, record) / steps[i])
        return np.array(columns).T

    def _difference(self, here: Record, there: Record) -> Floats:
        a, b = self._residuals(here), self._residuals(there)
        if a is None or b is None:
            raise ValueError(
                f"design {there.number}: a response is not known on either side of design {here.number}: "
                f"{there.reason}; narrow the bounds, or take out what is not known"
            )
        return b - a

    def _residuals(self, record: Record) -> Floats | None:
        values = [record.responses.get(one.response) for one in self.problem.objectives]
        if any(value is None for value in values):
            return None
        goals = [one.goal for one in self.problem.objectives]
        return np.array(
            [
                g.residual(float(v))
                for g, v in zip(goals, values, strict=True)
                if isinstance(g, Target) and v is not None
            ]
        )


def _result(problem: Problem, found: Any, misfit: _Misfit) -> MethodResult:
    """Deviations are those that the tolerances, taken as standard deviations, leave the variables; None where the
    targets do not determine them."""
    J = np.asarray(found.jac)
    determined = np.linalg.matrix_rank(J, tol=1e-8 * max(float(np.linalg.norm(J, 2)), 1e-300)) == J.shape[1]
    spread = np.sqrt(np.diag(np.linalg.inv(J.T @ J))) if determined else np.full(J.shape[1], np.nan)
    (record,) = misfit.evaluate([problem.values(found.x)])
    fitted = {
        one.name: {
            "value": record.values[one.name],
            "deviation": float(deviation) * _per_share(one, float(share)) if determined else None,
            "unit": one.unit,
            "at_bound": bool(min(share, 1 - share) < _INSIDE / 10),
            "open": not deviation < 1,  # a share of its range: as wide as that, no target tells it
        }
        for one, share, deviation in zip(problem.variables, found.x, spread, strict=True)
    }
    residuals = dict(zip([one.response for one in problem.objectives], np.asarray(found.fun).tolist(), strict=True))
    summary = {
        "design": record.number, "fitted": fitted, "residuals_in_tolerances": residuals,
        "mean_square": float(np.mean(np.square(found.fun))), "ended": found.message,
    }  # fmt: skip
    return MethodResult(summary=summary, notes=tuple(_notes(record, fitted, determined, found.status > 0)))


def _per_share(one: Variable, share: float) -> float:
    """Derivative of the value by its share of the range."""
    low, high = max(share - 1e-4, 0.0), min(share + 1e-4, 1.0)
    return abs(one.at(high) - one.at(low)) / (high - low)


def _notes(record: Record, fitted: dict[str, Any], determined: bool, settled: bool) -> list[str]:
    values = []
    for name, one in fitted.items():
        deviation = f" +- {one['deviation']:.2g}" if determined else ""
        values.append(f"{name} = {one['value']:.5g}{deviation} {one['unit']}".rstrip())
    notes = [f"design {record.number} fits best: {', '.join(values)}"]
    if not determined:
        notes.append("the targets do not determine all variables: fix some of them, or state further targets")
    open_ = [name for name, one in fitted.items() if one["open"]]
    if determined and open_:
        notes.append(f"the targets do not tell {', '.join(open_)}: its deviation is wider than its bounds")
    bound = [name for name, one in fitted.items() if one["at_bound"] and not one["open"]]
    notes += [f"{name} stands at a bound: widen it" for name in bound]
    return notes if settled else [*notes, "the rounds were used up before it settled: raise `rounds`"]
