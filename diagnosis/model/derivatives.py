"""How a solved point moves with parameters of any kind, without a derivative being written for any of them.

The residual and the observed motion of the changed models are evaluated where the point stands, which needs neither
tangents nor iterations; the Jacobian that solved the point turns their differences into derivatives.
"""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from updamp.hbm.branch import BranchPoint
from updamp.hbm.jacobian import factorise
from updamp.hbm.many_right_sides import apply_tangents, solve_many
from updamp.hbm.structure_response import Loads, respond
from updamp.hbm.system import Excitation, NonlinearSystem, Receptance

Floats = NDArray[np.float64]
Integers = NDArray[np.int64]

# Of the equations for the derivatives: next to a turning point, where the Jacobian is nearly singular, no more is
# to be had, and a fit does not need more.
_TOLERANCE = 1e-5
# Relative step of the frequency for the explicit dependence of the observed motion on it.
_STEP_W = 1e-6


@dataclass(frozen=True, eq=False)
class Change:
    """A parameter's change by finite differences: systems at both sides, or at one and the middle.

    step: between them
    """

    below: NonlinearSystem
    above: NonlinearSystem
    step: float


@dataclass(frozen=True, eq=False)
class Derivatives:
    """value: (n_rows, n_coefficients) observed motion [m]

    along: its derivative (and w_along that of the angular frequency) by length along the branch
    by_parameter: (n_parameters, n_rows, n_coefficients) with the place along the branch held; w_by_parameter
    x_by_parameter: (n_parameters, n_relative, n_coefficients) likewise, of the relative displacements [m]
    by_force: by the logarithm of the force; w_by_force
    """

    value: Floats
    along: Floats
    w_along: float
    by_parameter: Floats
    w_by_parameter: Floats
    x_by_parameter: Floats
    by_force: Floats
    w_by_force: float


def derivatives(point: BranchPoint, excitation: Excitation, changes: Sequence[Change], rows: Integers) -> Derivatives:
    """raises: RuntimeError where the Jacobian is singular and no correction helps"""
    equation = point.solution.equation
    receptance, x, w = equation.receptance, point.x, point.w
    # That of the solution carries the state before the last Newton step, in which a contact may have been stuck.
    jacobian = factorise(receptance, equation.departure)
    system = receptance.system
    known = _Known(system, equation.departure.value)
    differences = [_difference(change, excitation, x, w, rows, known) for change in changes]
    lift = receptance.excitation(excitation)
    dr = np.stack([*(d[0] for d in differences), -lift, equation.frequency_derivative(excitation), 0 * x], axis=2)
    dx = np.zeros_like(dr)
    dx[..., :-1] = solve_many(jacobian, equation.departure, -dr[..., :-1], _TOLERANCE)
    dx[..., -1] = point.tangent_x
    forces = Loads.none(receptance, dx.shape[2])
    forces.forces[: len(x)] = -apply_tangents(system, equation.departure, dx)
    dy = respond(receptance, forces).at(rows)
    by_w = _by_frequency(system, excitation, x, w, rows, known)
    for j, difference in enumerate(differences):
        dy[..., j] += difference[1]
    dy[..., -3] += receptance.excitation(excitation, rows)
    dy[..., -2] += by_w
    dy[..., -1] += by_w * point.tangent_w
    # hold the place along the branch: the move has no part along its tangent
    metric, (tx, tw) = point.metric, point.tangent
    along = np.tensordot(metric.weights**2 * tx, dx[..., :-1], axes=2)
    of_frequency = along[-1] + tw / metric.scale_w**2
    dw = -along[:-1] / of_frequency
    total = dy[..., :-2] + dy[..., -2:-1] * dw
    return Derivatives(
        value=_observed(receptance, excitation, equation.departure.value, rows),
        along=dy[..., -1],
        w_along=tw,
        by_parameter=total[..., :-1].transpose(2, 0, 1),
        w_by_parameter=dw[:-1],
        x_by_parameter=(dx[..., :-3] + dx[..., -2:-1] * dw[:-1]).transpose(2, 0, 1),
        by_force=total[..., -1],
        w_by_force=float(dw[-1]),
    )


def _observed(receptance: Receptance, excitation: Excitation, departure: Floats, rows: Integers) -> Floats:
    return receptance.excitation(excitation, rows) - receptance.apply(departure, rows)


def _at(
    system: NonlinearSystem, excitation: Excitation, x: Floats, w: float, rows: Integers, known: "_Known | None" = None
) -> tuple[Floats, Floats]:
    """Residual and observed motion, without tangents."""
    receptance = Receptance(system, w)
    g = known.departure if known is not None and known.holds(system) else system.departure_value(x, w)
    return x - receptance.excitation(excitation) + receptance.apply(g), _observed(receptance, excitation, g, rows)


@dataclass(frozen=True, eq=False)
class _Known:
    """The elements' forces at the point: those of every system with the same elements."""

    system: NonlinearSystem
    departure: Floats

    def holds(self, other: NonlinearSystem) -> bool:
        same = len(other.groups) == len(self.system.groups) and other.harmonics == self.system.harmonics
        return same and all(a is b for a, b in zip(other.groups, self.system.groups, strict=True))


def _difference(
    change: Change, excitation: Excitation, x: Floats, w: float, rows: Integers, known: _Known
) -> tuple[Floats, Floats]:
    r1, y1 = _at(change.below, excitation, x, w, rows, known)
    r2, y2 = _at(change.above, excitation, x, w, rows, known)
    return (r2 - r1) / change.step, (y2 - y1) / change.step


def _by_frequency(
    system: NonlinearSystem, excitation: Excitation, x: Floats, w: float, rows: Integers, known: _Known
) -> Floats:
    """Of the observed motion at held relative displacements."""
    h = _STEP_W * w
    still = None if any(group.law.rate_dependent for group in system.groups) else known
    (_, below), (_, above) = (_at(system, excitation, x, w + sign * h, rows, still) for sign in (-1, 1))
    return (above - below) / (2 * h)
