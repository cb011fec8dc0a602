"""How a solved point moves with parameters of any kind, without a derivative being written for any of them.

The residual and the observed motion of the changed models are evaluated where the point stands, which needs neither
tangents nor iterations; the Jacobian that solved the point turns their differences into derivatives.
"""

from collections.abc import Sequence
from dataclasses import dataclass, field
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from updamp.effects.reading import Reading
from updamp.hbm.continuation.branch import BranchPoint
from updamp.hbm.newton.many_right_sides import solve_many
from updamp.hbm.newton.tangent import apply_tangent
from updamp.hbm.problem.receptance_along import ReceptanceAlong
from updamp.hbm.problem.system import Excitation, NonlinearSystem

Floats = NDArray[np.float64]
Integers = NDArray[np.int64]

# Of the equations for the derivatives: next to a turning point, where the Jacobian is nearly singular, no more is
# to be had, and a fit does not need more.
_TOLERANCE = 1e-5
_ALL = slice(None)


@dataclass(frozen=True, eq=False)
class Change:
    """A parameter's change by a finite difference, to one side unless there is an opposite.

    system: the changed one; step: of the parameter, from where the point stands
    opposite: that changed by the negative step. The structure's response is as curved as its resonance is narrow: a
        difference to one side would be off by half of step over loss factor, squared
    reading: of the changed model; a point's motion has no part in it
    contacts_alone: whether the linear structure is that of the point
    added: points of elements that the changed system has in addition, which exert nothing where the point stands but
        for the step
    """

    system: NonlinearSystem
    step: float
    contacts_alone: bool = False
    added: tuple[str, ...] = ()
    opposite: NonlinearSystem | None = None
    reading: Reading = field(default_factory=Reading)


@dataclass(frozen=True, eq=False)
class Derivatives:
    """value: (n_rows, n_coefficients) observed motion [m]

    along: its derivative (and w_along that of the angular frequency) by length along the branch
    by_parameter: (n_parameters, n_rows, n_coefficients) with the place along the branch held (`_held`); w_by_parameter
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


@dataclass(frozen=True, eq=False)
class Moves:
    """How observed motion and relative displacements move, at held frequency and force unless stated otherwise.

    value: (n_rows, n_coefficients) observed motion [m]
    dy: (n_rows, n_coefficients, n + 3) of the observed motion: by the n parameters, by the logarithm of the force, by
        the angular frequency, and along the branch at held force; dx: (n_relative, n_coefficients, n + 3) likewise
    """

    value: Floats
    dy: Floats
    dx: Floats


def moves(
    points: Sequence[BranchPoint], row: int, forces: Floats, changes: Sequence[Change], rows: Integers
) -> list[Moves]:
    """At solved points of one system, all together: most of it takes hardly longer for many than for one.

    row, forces: of the excitation, (n_points,) [N]; rows: observed
    raises: RuntimeError where the Jacobian is singular and no correction helps
    """
    here = _Points.of(points, row, forces, rows)
    n, by_w = here.x.shape[0], here.by_frequency()
    residual, observed = here.differences(changes)
    of_force, of_w = -here.lift[:n, ..., None], -by_w[:n, ..., None]
    dr = np.concatenate([residual, of_force, of_w, 0 * of_w], axis=3)
    dx, acting = np.zeros_like(dr), np.zeros_like(dr)
    for i, point in enumerate(points):
        equation = point.solution.equation
        # That of the solution carries the state before the last Newton step, in which a contact may have been stuck.
        dx[:, :, i, :-1] = solve_many(equation.factorised(), equation.departure, -dr[:, :, i, :-1], _TOLERANCE)
        dx[:, :, i, -1] = point.tangent_x
        acting[:, :, i] = apply_tangent(here.receptance.system, equation.departure, dx[:, :, i])
    dy = -here.receptance.apply(acting, rows)
    dy[..., : len(changes)] += observed
    dy[..., -3] += here.lift[rows]
    dy[..., -2] += by_w[rows]
    dy[..., -1] += by_w[rows] * np.array([point.tangent_w for point in points])
    value = here.motion[rows]
    return [Moves(value[:, :, i], dy[:, :, i], dx[:, :, i]) for i in range(len(points))]


def derivatives(
    points: Sequence[BranchPoint], excitation: Excitation, changes: Sequence[Change], rows: Integers
) -> list[Derivatives]:
    """At solved points of one system; raises as `moves`"""
    forces = np.full(len(points), excitation.force)
    found = moves(points, excitation.row, forces, changes, rows)
    return [_with_place_held(point, of_point) for point, of_point in zip(points, found, strict=True)]


def _with_place_held(point: BranchPoint, found: Moves) -> Derivatives:
    dx, dy = found.dx, found.dy
    dw = _held(found.value, dy, point.tangent_w, point.w)
    total = dy[..., :-2] + dy[..., -2:-1] * dw
    return Derivatives(
        value=found.value,
        along=dy[..., -1],
        w_along=point.tangent_w,
        by_parameter=total[..., :-1].transpose(2, 0, 1),
        w_by_parameter=dw[:-1],
        x_by_parameter=(dx[..., :-3] + dx[..., -2:-1] * dw[:-1]).transpose(2, 0, 1),
        by_force=total[..., -1],
        w_by_force=float(dw[-1]),
    )


def _held(observed: Floats, dy: Floats, w_along: float, w: float) -> Floats:
    """(n,) changes of the angular frequency that go with the first n = columns - 2 of dy, for the place to be held.

    dy: (n_rows, n_coefficients, columns) at held frequency, then by the frequency, then along the branch

    The place is held where the observed motion changes least, relative to each row's size: a resonance that shifts
    keeps its amplitudes and phases, so that a shift by more than its width still is one of the frequency alone.
    """
    size = np.maximum(np.linalg.norm(observed, axis=1), np.finfo(float).tiny)
    relative = (dy / size[:, None, None]).reshape(-1, dy.shape[2])
    by_parameter, by_w, along = relative[:, :-2], relative[:, -2] * w, relative[:, -1]
    along, shift = np.append(along, w_along / w), np.append(by_w, 1.0)
    return np.asarray(-w * (along[:-1] @ by_parameter) / (along @ shift))


@dataclass(frozen=True, eq=False)
class _Points:
    """Solved points, along the third axis of all arrays.

    x: (n_relative, n_coefficients, n_points); departure: of their elements, like x; departure_rate: its derivative by
        the angular frequency; row, forces: of the excitation; rows: observed
    """

    receptance: ReceptanceAlong
    x: Floats
    departure: Floats
    departure_rate: Floats
    row: int
    forces: Floats
    rows: Integers

    @staticmethod
    def of(points: Sequence[BranchPoint], row: int, forces: Floats, rows: Integers) -> "_Points":
        equations = [point.solution.equation for point in points]
        receptance = ReceptanceAlong(equations[0].receptance.system, np.array([e.receptance.w for e in equations]))
        x = np.stack([point.x for point in points], axis=2)
        departure = np.stack([e.departure.value for e in equations], axis=2)
        rate = np.stack([e.departure.frequency_derivative for e in equations], axis=2)
        return _Points(receptance, x, departure, rate, row, forces, rows)

    @cached_property
    def lift(self) -> Floats:
        """(n_rows, n_coefficients, n_points) motion of all rows under the excitation alone, all elements stuck"""
        return self.receptance.excitation(self.row, self.forces, _ALL)

    @cached_property
    def motion(self) -> Floats:
        """Likewise, as the structure answers the elements' forces"""
        return self.lift - self.receptance.apply(self.departure, _ALL)

    def by_frequency(self) -> Floats:
        """Likewise, of the motion at held relative displacements"""
        rate = self.receptance.motion_rate(self.row, self.forces, self.departure, _ALL)
        return rate - self.receptance.apply(self.departure_rate, _ALL) if self.departure_rate.any() else rate

    def differences(self, changes: Sequence[Change]) -> tuple[Floats, Floats]:
        """Of the residual (n_relative, n_coefficients, n_points, n_changes) and of the observed motion (n_rows, ...) at
        the same x, over the steps"""
        of_contacts = [j for j, change in enumerate(changes) if change.contacts_alone]
        residual = np.zeros((*self.x.shape, len(changes)))
        observed = np.zeros((len(self.rows), *residual.shape[1:]))
        if of_contacts:
            found = self._of_contacts([changes[j] for j in of_contacts])
            residual[..., of_contacts], observed[..., of_contacts] = found
        for j, change in enumerate(changes):
            if not change.contacts_alone:
                residual[..., j], observed[..., j] = self._of_structure(change)
        return residual, observed

    def _of_contacts(self, changes: Sequence[Change]) -> tuple[Floats, Floats]:
        """The residual as the points' own system has it: with its springs the structure stays the same."""
        forces = np.empty((*self.x.shape, len(changes)))
        for j, change in enumerate(changes):
            stiffer = change.system.reference_stiffness - self.receptance.system.reference_stiffness
            g = change.system.departure_values(self.x, self.receptance.w, self._known)
            forces[..., j] = (g - self.departure + stiffer[:, None, None] * self.x) / change.step
        moved = self.receptance.apply(forces, _ALL)
        return moved[: len(self.x)], -moved[self.rows]

    def _of_structure(self, change: Change) -> tuple[Floats, Floats]:
        if change.opposite is None:
            return self._to_one_side(change.system, change)
        ahead, behind = (self._to_one_side(system, change) for system in (change.system, change.opposite))
        return (ahead[0] - behind[0]) / 2, (ahead[1] - behind[1]) / 2

    def _to_one_side(self, system: NonlinearSystem, change: Change) -> tuple[Floats, Floats]:
        n, rows, further = len(self.x), self.rows, len(change.added)
        receptance = ReceptanceAlong(system, self.receptance.w)
        x = np.concatenate([self.x, self._motion_of(change.added)]) if further else self.x
        g = system.departure_values(x, receptance.w, self._known)
        motion = receptance.motion(self.row + further, self.forces, g, _ALL)
        return (self.motion[:n] - motion[:n]) / change.step, (motion[rows + further] - self.motion[rows]) / change.step

    def _motion_of(self, points: Sequence[str]) -> Floats:
        """(n, n_coefficients, n_points) of named points"""
        return self.motion[[self.receptance.system.free.row(point) for point in points]]

    @property
    def _known(self) -> tuple[NonlinearSystem, Floats]:
        return self.receptance.system, self.departure
