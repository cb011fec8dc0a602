"""Solved points of a branch without their matrices, which are 1 to 5 MB each, and with them again.

A branch in a fit is compared with runs, moved and kept; only what differentiates it by something new, or puts measured
motion into its equations, needs the matrices, and then one evaluation a point makes them.
"""

from collections.abc import Sequence
from dataclasses import replace
from typing import Any

from updamp.diagnosis.model.condition import Condition
from updamp.diagnosis.model.held_branch import force_at
from updamp.diagnosis.model.rig_model import RigModel
from updamp.hbm.branch import BranchPoint
from updamp.hbm.newton import evaluate

_NOTHING: Any = None


def light(points: Sequence[BranchPoint]) -> tuple[BranchPoint, ...]:
    """Without equation and factors."""
    return tuple(
        replace(p, solution=replace(p.solution, equation=_NOTHING, jacobian=None, by_frequency=None)) for p in points
    )


def with_matrices(model: RigModel, condition: Condition, points: Sequence[BranchPoint]) -> tuple[BranchPoint, ...]:
    """With the equation at each point, without its factors; model: that they were solved for."""
    found = []
    for point in points:
        equation = evaluate(model.system, model.excited_by(force_at(point, condition)), point.x, point.w)
        found.append(replace(point, solution=replace(point.solution, equation=equation)))
    return tuple(found)
