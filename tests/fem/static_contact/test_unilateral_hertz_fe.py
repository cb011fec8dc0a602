"""Hertz's cylinder on a flat with the compliance of 20-node hexahedra: plane strain, one element deep."""

import numpy as np
import pytest
from scipy.sparse.linalg import splu
from skfem import Basis, ElementHexS2, ElementVector, FacetBasis, LinearForm, MeshHex
from skfem.models.elasticity import lame_parameters, linear_elasticity

from updamp.fem.static_contact.contact_problem import ContactProblem, ContactStatus
from updamp.fem.static_contact.unilateral_contact import solve_unilateral_contact

E, NU, P, RADIUS = 200e9, 0.3, 1e5, 0.1  # P [N/m]
HERTZ = np.sqrt(4 * P * RADIUS * (1 - NU**2) / (np.pi * E))  # half-width on a rigid cylinder, 1/E* = (1 - nu^2)/E
BLOCK = 40 * HERTZ
ZONE = 2 * HERTZ


def block_with(patches: int) -> MeshHex:
    """Half-space as a block, equal elements along the zone of contact, then growing by two fifths each."""
    step = 2 * ZONE / patches
    growing = step * np.cumsum(1.4 ** np.arange(1, 100))
    outer = growing[: np.searchsorted(growing, BLOCK) + 1]
    x = np.concatenate([-ZONE - outer[::-1], np.linspace(-ZONE, ZONE, patches + 1), ZONE + outer])
    y = -np.concatenate([[0], step * np.arange(1, 3), 2 * step + outer])[::-1]
    return MeshHex.init_tensor(x, y, np.array([0, step]))


def fe_flexibility(mesh: MeshHex) -> tuple[np.ndarray, np.ndarray, float]:
    """Patch averages of u_y per unit force on the patch, one patch a face of the zone: x, flexibility, depth."""
    basis = Basis(mesh, ElementVector(ElementHexS2()), intorder=4)
    K = linear_elasticity(*lame_parameters(E, NU)).assemble(basis).tocsc()
    at = basis.doflocs
    depth = at[2].max()
    components = np.empty(basis.N, dtype=int)
    for dofs in (basis.nodal_dofs, basis.edge_dofs):
        for component in range(3):
            components[dofs[component]] = component
    clamped = np.isclose(at[1], at[1].min()) | (components == 2)
    free = np.flatnonzero(~clamped)
    top = mesh.facets_satisfying(lambda x: np.isclose(x[1], 0) & (np.abs(x[0]) < ZONE), boundaries_only=True)
    middle = mesh.p[0, mesh.facets[:, top]].mean(axis=0)
    top = top[np.argsort(middle)]
    width = 2 * ZONE / len(top)
    load = LinearForm(lambda v, _: v[1] / (width * depth))
    loads = np.column_stack(
        [load.assemble(FacetBasis(mesh, basis.elem, facets=np.array([f]), intorder=4)) for f in top]
    )[free]
    return np.sort(middle), loads.T @ splu(K[free][:, free]).solve(loads), float(depth)


def solved_pressure(patches: int) -> tuple[np.ndarray, np.ndarray, int]:
    """Middles of the patches, pressure, number closed; frictionless, rigid cylinder loaded through its motion in y."""
    x, normal_flexibility, depth = fe_flexibility(block_with(patches))
    width = x[1] - x[0]
    n = len(x)
    C = np.eye(3 * n) * np.mean(np.diag(normal_flexibility))  # tangential entries play no part without friction
    C[2::3, 2::3] = normal_flexibility
    R = np.zeros((3 * n, 1))
    R[2::3] = 1
    gap = (x**2 + width**2 / 12) / (2 * RADIUS)
    solution = solve_unilateral_contact(ContactProblem(C, R, gap, np.zeros(n)), np.array([[P * depth]]))
    assert solution.status is ContactStatus.CONVERGED
    assert solution.residuals[0] < 1e-11
    state = solution.value[0]
    return x, state.force[:, 2] / (width * depth), int(state.closed.sum())


@pytest.mark.long
def test_cylinder_on_finite_elements_meets_hertz_and_converges() -> None:
    peak = 2 * P / (np.pi * HERTZ)
    width_errors, profile_errors, sizes = [], [], (10, 20, 40)
    for patches in sizes:
        x, pressure, closed = solved_pressure(patches)
        width = x[1] - x[0]
        edges = np.clip(np.stack([x - width / 2, x + width / 2]) / HERTZ, -1, 1)
        theory = P / np.pi / width * np.diff(edges * np.sqrt(1 - edges**2) + np.arcsin(edges), axis=0)[0]
        profile_errors.append(np.abs(pressure - theory).sum() * width / P)
        second_moment = np.sum(pressure * (x**2 + width**2 / 12)) / pressure.sum()
        width_errors.append(abs(2 * np.sqrt(second_moment) / HERTZ - 1))
        assert abs(closed * width / 2 - HERTZ) <= width
    orders = [-np.polyfit(np.log(sizes), np.log(errors), 1)[0] for errors in (width_errors, profile_errors)]
    assert pressure.max() == pytest.approx(peak, rel=5e-3)
    assert width_errors[-1] < 2e-3
    assert profile_errors[-1] < 5e-3
    assert min(orders) > 1.0
