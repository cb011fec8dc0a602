"""One component ready for everything that needs solves: matrices, factorisation, interface."""

from collections.abc import Iterator
from contextlib import ExitStack, closing, contextmanager
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy import sparse

from updamp.fem.assembly import SystemMatrices
from updamp.fem.half_models import Subspace, half_models
from updamp.fem.interface import Interface
from updamp.fem.quadratic_mesh import QuadraticMesh
from updamp.fem.rigid_body import Support, isostatic_support, rigid_body_fields, rigid_body_modes
from updamp.fem.solvers import Factorisation, LinearSolver

Floats = NDArray[np.float64]


@dataclass(frozen=True, eq=False)
class Component:
    """Matrices and interface of one component.

    rigid: (n_dofs, n_rigid) mass-orthonormal rigid-body modes, none where it is clamped
    support: springs that hold a free component isostatically, so that its stiffness can be factorised. Loads in
        equilibrium put no force on them: its static response to such loads, less any rigid motion, is exact.
    """

    name: str
    mesh: QuadraticMesh
    matrices: SystemMatrices
    interface: Interface
    rigid: Floats
    support: Support


@dataclass(frozen=True, eq=False)
class FactorisedComponent:
    """A component, and the factorisation of its supported stiffness: one for each of its subspaces."""

    component: Component
    factors: tuple[tuple[Subspace, Factorisation], ...]

    def solve(self, load: Floats) -> Floats:
        """(n_dofs,) or (n_dofs, m) -> the displacement, of the same shape. raises: SolverFailedError"""
        return sum(
            (subspace.outside(factor.solve(subspace.within(load))) for subspace, factor in self.factors),
            start=np.zeros(1),
        )


def component(mesh: QuadraticMesh, matrices: SystemMatrices, interface: Interface, *, free: bool) -> Component:
    """free: whether it floats, as the damper does"""
    if not free:
        nothing = np.zeros((matrices.n_dofs, 0))
        return Component(mesh.name, mesh, matrices, interface, nothing, Support(sparse.csc_array(nothing), np.zeros(0)))
    rigid = rigid_body_modes(mesh.nodes, matrices.mass)
    support = isostatic_support(mesh.nodes, matrices.stiffness.diagonal().mean())
    return Component(mesh.name, mesh, matrices, interface, rigid, support)


@contextmanager
def factorised(part: Component, solver: LinearSolver) -> Iterator[FactorisedComponent]:
    """Factorise for the length of a `with` block: the factors are the largest thing in memory."""
    matrices = part.matrices
    nodes = part.mesh.nodes[matrices.free_nodes]
    near_null_space = rigid_body_fields(nodes)
    if part.rigid.size:  # what floats is small, and its support is not its own mirror image
        subspaces: tuple[Subspace, ...] = (Subspace(part.support.added_to(matrices.stiffness)),)
    else:
        subspaces = half_models(nodes, matrices)
    with ExitStack() as held:
        factors = []
        for subspace in subspaces:
            fields = subspace.within(near_null_space)
            # Each field is alike on both sides or opposite: in the other subspace it is 0 but for round-off.
            own = fields[:, np.linalg.norm(fields, axis=0) > 1e-6 * np.linalg.norm(near_null_space, axis=0)]
            factors.append((subspace, held.enter_context(closing(solver(subspace.stiffness, own)))))
        yield FactorisedComponent(part, tuple(factors))
