"""From one component's finite elements to its receptance at the interface: modes plus exact static residual."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy import sparse

from updamp.fem.component import Component, FactorisedComponent
from updamp.fem.modes import Modes, normal_modes
from updamp.fem.reduced_model import ReducedComponent
from updamp.fem.solvers import Factorisation

Floats = NDArray[np.float64]

# Right-hand sides solved at once: the fastest number per right-hand side that stays small beside the factor.
BLOCK = 73


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
    return normal_modes(part, options.modes)


def reduce_component(part: FactorisedComponent, modes: Modes, options: ReductionOptions) -> ReducedComponent:
    """Modes and residual flexibility at the interface. raises: SolverFailedError"""
    own = part.component
    phi = own.interface.operator.T @ modes.phi
    residual = residual_flexibility(part, modes) if options.residual else np.zeros((len(phi), len(phi)))
    return ReducedComponent(own.name, modes.omega, phi, residual, own.interface.points)


def momentum_about_clamp(clamped: Component, modes: Modes, axis: float) -> Floats:
    """(n_modes,) as `ReducedComponent.momentum_about_clamp`; axis: x of the clamp's axis, at y = 0 [m]"""
    nodes = clamped.mesh.nodes[clamped.matrices.free_nodes]
    rotation = np.column_stack([-nodes[:, 1], nodes[:, 0] - axis, np.zeros(len(nodes))]).ravel()
    return np.asarray(modes.phi.T @ (clamped.matrices.mass @ rotation))


def residual_flexibility(part: FactorisedComponent, modes: Modes) -> Floats:
    """Static flexibility (n_interface, n_interface) of all modes that are not kept, exact to round-off [m/N].

    B^T X with K X = (I - M Phi Phi^T) B, X mass-orthogonal to the kept modes Phi. The loads are in equilibrium, since
    rigid-body modes are kept: inertia relief, for which the isostatic support of a free component carries nothing.

    raises: ValueError where a rigid-body mode is not among the kept ones
    """
    if modes.n_rigid != part.component.rigid.shape[1]:
        raise ValueError(f"the {part.component.name}'s rigid-body modes must all be kept; {modes.n_rigid} are")
    operator, phi = part.component.interface.operator, modes.phi
    mass_phi = part.component.matrices.mass @ phi
    residual = np.zeros((operator.shape[1], operator.shape[1]))
    for subspace, factor in part.factors:
        loads, combined = independent_loads(subspace.within(operator))
        own = _flexibility_at(loads, factor, subspace.within(phi), subspace.within(mass_phi))
        residual += combined.T @ own @ combined
    return (residual + residual.T) / 2


def _flexibility_at(loads: sparse.csc_array, factor: Factorisation, phi: Floats, mass_phi: Floats) -> Floats:
    """Of one subspace, at these loads (n, r): (r, r)."""
    flexibility = np.empty((loads.shape[1], loads.shape[1]))
    at_modes = loads.T @ phi
    for start in range(0, loads.shape[1], BLOCK):
        columns = slice(start, start + BLOCK)
        load = loads[:, columns].toarray(order="F")
        load -= mass_phi @ (phi.T @ load)
        motion = factor.solve(load)
        # What follows is B^T (I - Phi Phi^T M) X, without another array of the size of X.
        flexibility[:, columns] = loads.T @ motion - at_modes @ (mass_phi.T @ motion)
    return flexibility


def independent_loads(loads: sparse.csc_array) -> tuple[sparse.csc_array, Floats]:
    """As few loads as give all of them, to round-off: in half of a component, those at a contact element and at its
    mirror image are one.

    loads: (n, m). returns: (n, r), and (r, m) with loads = independent @ combined
    """
    rows = np.unique(loads.indices)
    left, size, combined = np.linalg.svd(loads.tocsr()[rows].toarray(), full_matrices=False)
    kept = size > len(rows) * np.finfo(float).eps * size[0]
    scattered = sparse.csr_array((np.ones(len(rows)), (rows, np.arange(len(rows)))), shape=(loads.shape[0], len(rows)))
    return sparse.csc_array(scattered @ sparse.csc_array(left[:, kept])), size[kept, None] * combined[kept]


def mirrored_component(blade: ReducedComponent, name: str) -> ReducedComponent:
    """The mirror image x -> -x: contact coordinates stay, as local axes are mirrored too; x of points flips, and the
    sense of a rotation."""
    sign = np.ones(len(blade.residual))
    sign[blade.n_contact_dofs :] = [-1.0 if point.endswith(".x") else 1.0 for point in blade.points]
    phi, residual = sign[:, None] * blade.phi, sign[:, None] * blade.residual * sign
    return ReducedComponent(name, blade.omega, phi, residual, blade.points, -blade.momentum_about_clamp)
