"""From one component's finite elements to its receptance at the interface: modes plus exact static residual."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from updamp.fem.component import Component, FactorisedComponent
from updamp.fem.modes import Modes, normal_modes
from updamp.fem.reduced_model import ReducedComponent
from updamp.fem.solvers import Factorisation, SolverFailedError

Floats = NDArray[np.float64]

# Right-hand sides solved at once: the fastest number per right-hand side that stays small beside the factor.
BLOCK = 73
MAX_STEPS = 40


@dataclass(frozen=True)
class ReductionOptions:
    """modes: of each component, rigid-body modes included. residual: off only to show what is lost without it."""

    modes: int = 24
    residual: bool = True

    def __post_init__(self) -> None:
        if self.modes < 1:
            raise ValueError(f"reduction.modes = {self.modes} must be at least 1")


def component_modes(part: FactorisedComponent, options: ReductionOptions) -> Modes:
    """The kept modes of one component. raises: InaccurateModesError, ValueError"""
    own = part.component
    return normal_modes(own.matrices, part.shifted, own.shift, own.rigid, options.modes)


def reduce_component(part: FactorisedComponent, modes: Modes, options: ReductionOptions) -> ReducedComponent:
    """Modes and residual flexibility at the interface. raises: SolverFailedError"""
    own = part.component
    phi = own.interface.operator.T @ modes.phi
    residual = residual_flexibility(own, part.shifted, modes) if options.residual else np.zeros((len(phi), len(phi)))
    return ReducedComponent(own.name, modes.omega, phi, residual, own.interface.points)


def residual_flexibility(own: Component, shifted: Factorisation, modes: Modes) -> Floats:
    """Static flexibility (n_interface, n_interface) of all modes that are not kept, exact to round-off [m/N].

    B^T X with K X = (I - M Phi Phi^T) B, X orthogonal to the kept modes Phi. The loads are in equilibrium, since
    rigid-body modes are kept, so that a free component has its solution too.
    """
    operator = own.interface.operator
    mass_phi = own.matrices.mass @ modes.phi
    residual = np.empty((own.interface.n_interface, own.interface.n_interface))
    for columns in own.interface.blocks(BLOCK):
        load = operator[:, columns].toarray(order="F")
        load -= mass_phi @ (modes.phi.T @ load)
        motion = _flexible_motion(own, shifted, modes.phi, mass_phi, load)
        residual[:, columns] = operator.T @ motion
    return (residual + residual.T) / 2


def _flexible_motion(own: Component, shifted: Factorisation, phi: Floats, mass_phi: Floats, load: Floats) -> Floats:
    """K^-1 load on what is mass-orthogonal to phi, from a factorisation of K + s M.

    X <- (K + s M)^-1 (load + s M X) contracts by s / (omega^2 + s), omega that of the first mode left out.
    """

    def off_kept_modes(fields: Floats) -> Floats:
        return fields - phi @ (mass_phi.T @ fields)

    motion = step = off_kept_modes(shifted.solve(load))
    if own.shift == 0:
        return motion
    for _ in range(MAX_STEPS):
        step = off_kept_modes(shifted.solve(own.shift * (own.matrices.mass @ step)))
        motion = motion + step
        if np.linalg.norm(step) <= 1e-15 * np.linalg.norm(motion):
            return motion
    raise SolverFailedError(
        f"static flexibility of the {own.name}: not converged in {MAX_STEPS} steps; its first mode left out is too low "
        "beside the shift of 2000 Hz; keep more modes (reduction.modes)"
    )


def mirrored(blade: ReducedComponent, name: str) -> ReducedComponent:
    """The mirror image x -> -x: contact coordinates are the same, for local axes are mirrored too; x of points flips."""
    sign = np.ones(len(blade.residual))
    sign[blade.n_contact_dofs :] = [-1.0 if point.endswith(".x") else 1.0 for point in blade.points]
    return ReducedComponent(
        name, blade.omega, sign[:, None] * blade.phi, sign[:, None] * blade.residual * sign, blade.points
    )
