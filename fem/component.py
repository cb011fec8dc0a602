"""One component ready for everything that needs solves: matrices, factorisation, interface."""

from collections.abc import Iterator
from contextlib import closing, contextmanager
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from updamp.fem.assembly import SystemMatrices
from updamp.fem.interface import Interface
from updamp.fem.quadratic_mesh import QuadraticMesh
from updamp.fem.rigid_body import rigid_body_fields, rigid_body_modes
from updamp.fem.solvers import Factorisation, LinearSolver

Floats = NDArray[np.float64]

# Makes a free component's K + shift M positive definite; far below its first elastic mode.
FREE_SHIFT = (2 * np.pi * 2000.0) ** 2


@dataclass(frozen=True, eq=False)
class Component:
    """Matrices and interface of one component.

    rigid: (n_dofs, n_rigid) mass-orthonormal rigid-body modes, none where it is clamped
    shift: [rad^2/s^2] such that stiffness + shift mass is positive definite, 0 where it is clamped
    """

    name: str
    mesh: QuadraticMesh
    matrices: SystemMatrices
    interface: Interface
    rigid: Floats
    shift: float


@dataclass(frozen=True, eq=False)
class FactorisedComponent:
    """A component, and the factorisation of its stiffness + shift mass."""

    component: Component
    shifted: Factorisation


def component(mesh: QuadraticMesh, matrices: SystemMatrices, interface: Interface, *, free: bool) -> Component:
    """free: whether it floats, as the damper does"""
    nodes = mesh.nodes[matrices.free_nodes]
    rigid = rigid_body_modes(nodes, matrices.mass) if free else np.zeros((matrices.n_dofs, 0))
    return Component(mesh.name, mesh, matrices, interface, rigid, FREE_SHIFT if free else 0.0)


@contextmanager
def factorised(part: Component, solver: LinearSolver) -> Iterator[FactorisedComponent]:
    """Factorise for the length of a `with` block: the factor is the largest thing in memory."""
    matrices = part.matrices
    matrix = matrices.stiffness + part.shift * matrices.mass.tobsr((3, 3)) if part.shift else matrices.stiffness
    near_null_space = rigid_body_fields(part.mesh.nodes[matrices.free_nodes])
    with closing(solver(matrix, near_null_space)) as shifted:
        yield FactorisedComponent(part, shifted)
