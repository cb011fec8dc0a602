"""The exact Jacobian J = I + G T of the residual, and the ways to solve with it.

With S the rows where the tangent T is not zero: J^-1 r = r - G y with y + T G y = T r and y zero outside S. How y is
found depends on how many rows are active: directly for few, by Krylov iteration for many, and where factors of a point
nearby are at hand (measurements: benchmarks/harmonic_balance/NOTES.md). Only where the structure has no residual
flexibility are its modes the smaller system.
"""

from dataclasses import dataclass
from typing import Protocol

import numpy as np
import scipy.linalg
from numpy.typing import NDArray

from updamp.hbm.newton.active_forces import DirectForces, KrylovForces, ModalForces
from updamp.hbm.newton.tangent import active_rows, apply_tangent
from updamp.hbm.problem.receptance import Receptance
from updamp.hbm.problem.system import Departure, NonlinearSystem

Floats = NDArray[np.float64]
Integers = NDArray[np.int64]

# Unknowns (active rows times coefficients) above which Krylov iteration beats a factorisation, one thread: with the
# reference springs for a preconditioner, and with factors of a point nearby.
DIRECT_UP_TO = 800
DIRECT_BESIDE_FACTORS = 250


class ForceSolver(Protocol):
    """Solves y + T G y = b for forces y on the active rows."""

    def __call__(self, b: Floats, start: Floats | None = None) -> Floats:
        """(n_relative, n_coefficients) -> same; start: a first guess, for those that iterate"""
        ...

    def solve(self, right: Floats) -> Floats:
        """Many at once, on the active rows alone, to 1e-9 at least: (n_active, n_coefficients, n) -> same"""
        ...

    @property
    def determinant_sign(self) -> float:
        """Of the Jacobian: 1, -1, or 0 where it is singular."""
        ...

    @property
    def factors(self) -> DirectForces | None:
        """Those that equations nearby may be preconditioned by."""
        ...


@dataclass(frozen=True, eq=False)
class Jacobian:
    """rows: (n_active,) relative rows that depart from stuck; forces: how the equations on them are solved"""

    receptance: Receptance
    departure: Departure
    rows: Integers
    forces: ForceSolver | None

    @property
    def n_active(self) -> int:
        return len(self.rows)

    @property
    def determinant_sign(self) -> float:
        """1, -1, or 0 where singular"""
        return 1.0 if self.forces is None else self.forces.determinant_sign

    @property
    def sign_is_cheap(self) -> bool:
        """Whether the sign of the determinant is at hand, or costs no more than a factorisation of moderate size."""
        n_coefficients = self.receptance.system.harmonics.n_coefficients
        return not isinstance(self.forces, KrylovForces) or self.n_active * n_coefficients <= DIRECT_UP_TO

    @property
    def factors(self) -> DirectForces | None:
        """Those that equations nearby may be preconditioned by."""
        return None if self.forces is None else self.forces.factors

    def solve(self, right: Floats) -> Floats:
        """J^-1 right: (n_relative, n_coefficients) -> same"""
        return self.solve_from(right, None)[0]

    def solve_from(self, right: Floats, start: Floats | None) -> tuple[Floats, Floats | None]:
        """J^-1 right and the forces y it came by; start: those of a similar right-hand side, or None."""
        if self.forces is None:
            return right, None
        b = apply_tangent(self.receptance.system, self.departure, right)
        y = self.forces(b, start)
        return right - self.receptance.apply(y), y


def factorise(receptance: Receptance, departure: Departure, near: DirectForces | None = None) -> Jacobian:
    """near: factors at a similar point, to solve by iteration with them in place of new ones

    raises: scipy.linalg.LinAlgError where a tangent is not finite
    """
    if not all(np.isfinite(tangent).all() for tangent in departure.tangents):
        raise scipy.linalg.LinAlgError("the tangent of a contact element is not finite")
    rows = active_rows(receptance.system, departure)
    return Jacobian(receptance, departure, rows, _solver(receptance, departure, rows, near) if len(rows) else None)


def _solver(receptance: Receptance, departure: Departure, rows: Integers, near: DirectForces | None) -> ForceSolver:
    system = receptance.system
    unknowns = len(rows) * system.harmonics.n_coefficients
    if unknowns > DIRECT_UP_TO and near is not None and near.unknowns <= DIRECT_UP_TO:
        near = None  # the reference springs serve so many better; factors of so many are there where they did not
    if unknowns <= (DIRECT_UP_TO if near is None else DIRECT_BESIDE_FACTORS):
        return DirectForces(receptance, departure, rows)
    if _without_residual(system) and len(system.stuck.omega_squared) < len(rows):
        return ModalForces(receptance, departure, rows)
    return KrylovForces(receptance, departure, rows, near)


def _without_residual(system: NonlinearSystem) -> bool:
    return not system.stuck.has_residual
