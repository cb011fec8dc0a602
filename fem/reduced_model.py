"""What the reduction hands on: modes plus exact static residual flexibility at the interface."""

from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray

from updamp.geometry.contact_elements import LEFT, RIGHT, ContactElements

Floats = NDArray[np.float64]


@dataclass(frozen=True, eq=False)
class ReducedComponent:
    """Receptance at the interface degrees of freedom of one component, undamped:

    H(w) = phi (omega^2 - w^2)^-1 phi^T + residual

    The first 3 n_contacts interface degrees of freedom are the patch averages of the displacement in the
    local axes (t1, t2, n) of the component's contact elements, contact by contact; those named in
    `points` follow.

    omega: (n_modes,) [rad/s], rigid-body modes exactly 0
    phi: (n_interface, n_modes) mass-normalised [kg^-1/2]
    residual: (n_interface, n_interface) symmetric [m/N]
    points: names of the further degrees of freedom, such as "tip.x"
    momentum_about_clamp: (n_modes,) phi^T M R of a clamped one [kg^1/2 m], with R a unit rotation about the clamp's z
        axis; none of a free one
    """

    name: str
    omega: Floats
    phi: Floats
    residual: Floats
    points: tuple[str, ...]
    momentum_about_clamp: Floats = field(default_factory=lambda: np.zeros(0))

    @property
    def n_contact_dofs(self) -> int:
        return len(self.residual) - len(self.points)


@dataclass(frozen=True, eq=False)
class ReducedModel:
    """The three components of the rig.

    blade_left, blade_right: contact elements of their own face only; points "excitation.x", "tip.x",
        "platform.x", "platform.y" (global directions, so the left blade's x entries change sign)
    damper: contact elements of both faces, left then right; points "corner_left.x", "corner_left.y",
        "corner_right.x", "corner_right.y", "wire_back.x", ".y", ".z", "wire_front.x", ".y", ".z"
        (averages over the damper's end faces)
    """

    blade_left: ReducedComponent
    blade_right: ReducedComponent
    damper: ReducedComponent
    contacts: ContactElements
    max_relative_residual: float

    @property
    def components(self) -> tuple[ReducedComponent, ReducedComponent, ReducedComponent]:
        return (self.blade_left, self.blade_right, self.damper)

    def contact_sign(self) -> tuple[int, int, int]:
        """Sign with which each component enters the relative displacement: damper minus platform."""
        return (-1, -1, 1)

    def contact_rows(self) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        """For each component, the rows of the relative displacement its contact DOFs belong to."""
        dofs = np.arange(3 * len(self.contacts)).reshape(-1, 3)
        left, right = (dofs[self.contacts.face == side].ravel() for side in (LEFT, RIGHT))
        return left, right, dofs.ravel()
