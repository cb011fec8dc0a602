"""Modes against beam theory and a published benchmark, and how fast they converge."""

import numpy as np
import pytest
from scipy.linalg import eigh, expm
from scipy.optimize import brentq
from scipy.sparse.linalg import LinearOperator, eigsh

from updamp.fem.assembly import assemble, clamp
from updamp.fem.quadratic_mesh import quadratic_mesh
from updamp.fem.solvers.pardiso import pardiso


def timoshenko_cantilever(length: float, depth: float, breadth: float, material, n: int) -> np.ndarray:
    """(n,) bending frequencies [Hz] of Timoshenko's beam, by the transfer matrix of (w, rotation, moment, shear).

    Shear coefficient of a rectangle without lateral contraction: 5/6 (Cowper 1966 at Poisson's ratio 0).
    """
    area, second = breadth * depth, breadth * depth**3 / 12
    bending = material.youngs_modulus * second
    shear = 5 / 6 * material.youngs_modulus / 2 * area

    def condition(frequency: float) -> float:
        """Determinant of (moment, shear) at the tip over (moment, shear) at the root"""
        inertia = material.density * (2 * np.pi * frequency) ** 2
        system = np.array(
            [[0, 1, 0, 1 / shear], [0, 0, 1 / bending, 0], [0, -inertia * second, 0, -1], [-inertia * area, 0, 0, 0]]
        )
        scale = np.array([length, 1, bending / length, bending / length**2])
        transfer = expm(length * system * scale / scale[:, None])
        return np.linalg.det(transfer[2:, 2:])

    slender = np.sqrt(bending / (material.density * area)) / (2 * np.pi * length**2)
    grid = np.linspace(slender, 25 * n**1.5 * slender, 2000)
    values = np.array([condition(f) for f in grid])
    changes = np.flatnonzero(values[:-1] * values[1:] < 0)[:n]
    return np.array([brentq(condition, grid[i], grid[i + 1], rtol=1e-12) for i in changes])


def clamped_frequencies(component, material, n: int) -> np.ndarray:
    """(n,) [Hz], clamped at "root"."""
    mesh = quadratic_mesh(component)
    matrices = clamp(assemble(mesh, material), np.unique(mesh.faces["root"]))
    factor = pardiso(matrices.stiffness, np.zeros((matrices.n_dofs, 6)))
    size = (matrices.n_dofs, matrices.n_dofs)
    inverse = LinearOperator(size, matvec=factor.solve, dtype=np.float64)
    start = np.random.default_rng(1).standard_normal(matrices.n_dofs)
    values = eigsh(matrices.stiffness, n, matrices.mass, sigma=0, OPinv=inverse, v0=start, return_eigenvectors=False)
    factor.close()
    return np.sqrt(np.sort(values)) / (2 * np.pi)


def test_bending_of_a_cantilever(box, elastic) -> None:
    """Without lateral contraction the clamped root is the beam's; thin in x, so x-bending comes first."""
    material = elastic(poissons_ratio=0.0)
    length, depth, breadth = 0.15, 0.0075, 0.012
    found = clamped_frequencies(box((4, 32, 4), (depth, length, breadth)), material, 4)
    in_x = timoshenko_cantilever(length, depth, breadth, material, 2)
    in_z = timoshenko_cantilever(length, breadth, depth, material, 2)
    np.testing.assert_allclose(found, np.sort(np.concatenate([in_x, in_z])), rtol=2e-4)


def test_frequencies_converge_at_the_order_of_quadratic_elements(box, elastic) -> None:
    """Error of an eigenvalue as h^(2p) = h^4 where the solution is smooth: a root without lateral contraction."""
    material = elastic(poissons_ratio=0.0)
    first = [clamped_frequencies(box((n, 4 * n, n), (0.1, 0.4, 0.15)), material, 1)[0] for n in (1, 2, 4, 8)]
    error = np.array(first[:3]) / first[3] - 1
    orders = np.log2(error[:-1] / error[1:])
    assert np.all(error > 0)  # Rayleigh: from above
    np.testing.assert_allclose(orders, 4, atol=0.6)


def test_nafems_fv52_thick_square_plate(box, elastic) -> None:
    """NAFEMS FV52: 10 x 10 x 1 m, the lower edges held upwards (Abbassian, Dawswell, Knowles 1987).

    4 x 4 x 1 elements; the values are those of 20-node elements with 27 integration points on this mesh.
    """
    material = elastic(youngs_modulus=200e9, density=8000.0)
    mesh = quadratic_mesh(box((4, 1, 4), (10.0, 1.0, 10.0)))
    matrices = assemble(mesh, material)
    x, y, z = mesh.nodes.T
    edge = (y == 0) & ((x == 0) | (x == 10) | (z == 0) | (z == 10))
    free = np.setdiff1d(np.arange(mesh.n_dofs), 3 * np.flatnonzero(edge) + 1)
    K, M = (matrix.toarray()[np.ix_(free, free)] for matrix in (matrices.stiffness, matrices.mass))
    values = eigh(K, M, eigvals_only=True, subset_by_index=[0, 9])
    assert np.all(np.abs(values[:3]) < 1e-6 * values[3])  # rigid motion in the plane
    found = np.sqrt(values[3:]) / (2 * np.pi)
    np.testing.assert_allclose(found[[0, 1, 3, 4, 5]], [44.796, 110.543, 169.095, 193.925, 206.638], atol=6e-4)
    assert found[1] == pytest.approx(found[2], rel=1e-9)
