"""What the contact solver takes and gives: bodies by their flexibility, states of the contacts, named outcomes."""

from dataclasses import dataclass
from enum import Enum

import numpy as np
from numpy.typing import NDArray

Floats = NDArray[np.float64]
Integers = NDArray[np.int64]
Bools = NDArray[np.bool_]


class ContactStatus(Enum):
    """Outcome of the contact problem; the value says what to try."""

    CONVERGED = "converged: every contact keeps its conditions"
    CYCLING = (
        "no set of open, stuck and slipping contacts was found that keeps all conditions within the iterations "
        "allowed; check that the contacts can carry the load at all, then try more load steps, a smaller friction "
        "coefficient, or more iterations"
    )
    NO_EQUILIBRIUM = (
        "the contacts cannot carry the load: a rigid-body motion is left that pulls the faces apart or that friction "
        "cannot hold; check the direction of the load, where it acts, and the friction coefficient"
    )
    SINGULAR = (
        "the equations of the closed contacts are singular; check that no contact is given twice, that the flexibility "
        "has no zero rows, and try a smaller friction coefficient"
    )


@dataclass(frozen=True, eq=False)
class ContactProblem:
    """Elastic bodies in contact, reduced to the contacts; local directions (t1, t2, n), contact by contact.

    flexibility: (3 n, 3 n) symmetric positive definite up to rigid-body modes [m/N], of both bodies together
    rigid_modes: (3 n, m) relative displacement at the contacts by the rigid-body modes of the floating body
    gap: (n,) initial opening [m]; friction: (n,) coefficient, 0 for none
    """

    flexibility: Floats
    rigid_modes: Floats
    gap: Floats
    friction: Floats

    def __post_init__(self) -> None:
        n = len(self.gap)
        shapes = {
            "flexibility": (self.flexibility.shape, (3 * n, 3 * n)),
            "rigid_modes": (self.rigid_modes.shape, (3 * n, self.rigid_modes.shape[-1])),
            "friction": (self.friction.shape, (n,)),
        }
        for name, (got, wanted) in shapes.items():
            if got != wanted:
                raise ValueError(f"{name} has shape {got}, but {n} gaps ask for {wanted}")
        for name in ("flexibility", "rigid_modes", "gap", "friction"):
            if not np.all(np.isfinite(getattr(self, name))):
                raise ValueError(f"{name} has entries that are not finite")
        if np.any(self.friction < 0):
            raise ValueError(f"friction has the negative value {self.friction.min()}; it must be 0 or more")


@dataclass(frozen=True, eq=False)
class StaticContactState:
    """One state of the contacts.

    force: (n, 3) [N], exactly zero where a contact is open; pressing and opposing the slip positive
    displacement: (n, 3) [m] relative, closing positive; opening: (n,) [m], exactly zero where closed
    rigid: (m,) rigid-body amplitudes
    slip: (n, 2) -1, 0 (stuck) or 1, the sense of slip; 0 where open
    """

    force: Floats
    displacement: Floats
    opening: Floats
    rigid: Floats
    closed: Bools
    slip: Integers


@dataclass(frozen=True, eq=False)
class ContactSolution:
    """Solution(value, status, iterations, residuals): `value` has one state a load step that was solved.

    iterations: (k,) a load step; residuals: (k,) largest violation of any contact condition and of equilibrium,
    relative to the largest force or to the elastic displacement of the step
    """

    value: tuple[StaticContactState, ...]
    status: ContactStatus
    iterations: Integers
    residuals: Floats


@dataclass(frozen=True)
class ContactOptions:
    """How long the active set is sought.

    max_iterations: of a symmetric problem (no friction, or given friction limits), a load step
    direct_iterations: of Coulomb's problem itself, from one starting set
    friction_cycles: updates of the friction limits, a load step
    tolerance: relative, of signs and of equilibrium
    block_trials: iterations that may fail to lower the number of violations before single pivots are made
    """

    max_iterations: int = 2000
    direct_iterations: int = 40
    friction_cycles: int = 100
    tolerance: float = 1e-11
    block_trials: int = 10

    def __post_init__(self) -> None:
        for name in ("max_iterations", "direct_iterations", "friction_cycles", "block_trials"):
            if getattr(self, name) < 1:
                raise ValueError(f"{name} is {getattr(self, name)}; it must be at least 1")
        if not 0 < self.tolerance < 1e-3:
            raise ValueError(f"tolerance is {self.tolerance}; it must be between 0 and 1e-3")
