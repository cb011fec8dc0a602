"""Two models of half the size say what the whole component says; where they would not, they are not made."""

from dataclasses import replace

import numpy as np
import pytest
from scipy import sparse
from scipy.linalg import eigh

from updamp.fem import modes as modes_module
from updamp.fem.assembly import assemble, clamp
from updamp.fem.component import component, factorised
from updamp.fem.coupling import patch
from updamp.fem.half_models import Subspace, half_models
from updamp.fem.interface import Interface
from updamp.fem.modes import normal_modes
from updamp.fem.quadratic_mesh import quadratic_mesh
from updamp.fem.rig_components import assemble_blade
from updamp.fem.solvers.pardiso import pardiso


def clamped(mesh, material):
    mesh = quadratic_mesh(mesh)
    matrices = clamp(assemble(mesh, material), np.unique(mesh.faces["root"]))
    return component(mesh, matrices, Interface(sparse.csc_array((matrices.n_dofs, 0)), ()), free=False)


def halves_of(part) -> tuple[Subspace, ...]:
    return half_models(part.mesh.nodes[part.matrices.free_nodes], part.matrices)


@pytest.fixture(scope="module")
def blade(tiny_mesh, reference_rig):
    return assemble_blade(tiny_mesh, reference_rig.material, patch)


def test_the_halves_are_the_stiffness_on_their_motions(blade) -> None:
    """basis^T K basis on the columns that are motions, nothing between them and the others, nor between the halves."""
    alike, opposite = halves_of(blade)
    whole = blade.matrices.stiffness.toarray()
    for half in (alike, opposite):
        basis = half.basis.toarray()
        moves = np.linalg.norm(basis, axis=0) > 0
        np.testing.assert_allclose(basis[:, moves].T @ basis[:, moves], np.eye(moves.sum()), atol=1e-15)
        own = half.stiffness.toarray()
        np.testing.assert_allclose(
            own[np.ix_(moves, moves)], (basis.T @ whole @ basis)[np.ix_(moves, moves)], atol=1e-3
        )
        assert not own[np.ix_(moves, ~moves)].any()
        assert own[~moves, ~moves].min() > 0
    between = alike.basis.T @ whole @ opposite.basis.toarray()
    assert np.abs(between).max() < 1e-13 * np.abs(whole).max()
    motions = sum(int((abs(half.basis).sum(axis=0) > 0).sum()) for half in (alike, opposite))
    assert motions == blade.matrices.n_dofs


def test_a_load_gives_the_displacement_of_the_whole(blade) -> None:
    load = np.random.default_rng(3).standard_normal((blade.matrices.n_dofs, 2))
    exact = np.linalg.solve(blade.matrices.stiffness.toarray(), load)
    with factorised(blade, pardiso) as part:
        assert len(part.factors) == 2
        for given, expected in ((load, exact), (load[:, 0], exact[:, 0])):
            np.testing.assert_allclose(part.solve(given), expected, atol=1e-9 * np.abs(exact).max())


@pytest.mark.parametrize(("width", "expected"), [(0.002, [7, 7, 10, 10]), (0.02, [7, 7])])
def test_modes_are_the_lowest_of_both_halves(box, steel, width, expected, monkeypatch) -> None:
    """Of a strip that is thin across its width nearly all of the lowest are opposite on both sides: above its share.

    Of its first frequency, 1e-5 of the highest, a dense solver knows 6 digits.
    """
    part = clamped(box((2, 8, 2), (0.02, 0.15, width)), steel)
    asked = []
    own = modes_module._lowest_modes
    monkeypatch.setattr(modes_module, "_lowest_modes", lambda *given: asked.append(given[-1]) or own(*given))
    with factorised(part, pardiso) as solved:
        found = normal_modes(solved, 10)
    dense = eigh(part.matrices.stiffness.toarray(), part.matrices.mass.toarray(), eigvals_only=True)[:10]
    np.testing.assert_allclose(found.omega, np.sqrt(dense), rtol=1e-6)
    np.testing.assert_allclose(found.phi.T @ part.matrices.mass @ found.phi, np.eye(10), atol=1e-9)
    assert asked == expected


def test_an_element_on_both_sides_of_the_plane_leaves_the_component_whole(box, steel) -> None:
    assert len(halves_of(clamped(box((2, 4, 3), (0.02, 0.1, 0.03)), steel))) == 1
    assert len(halves_of(clamped(box((2, 4, 4), (0.02, 0.1, 0.03)), steel))) == 2


def test_what_is_not_its_own_mirror_image_stays_whole(box, steel) -> None:
    """A node out of place, and nodes in place with another stiffness between them."""
    mesh = box((2, 4, 2), (0.02, 0.1, 0.03))
    corner = mesh.vertices.copy()
    corner[mesh.points["corner"], 0] += 1e-4
    assert len(halves_of(clamped(replace(mesh, vertices=corner), steel))) == 1

    part = clamped(mesh, steel)
    stiffness = part.matrices.stiffness.copy()
    stiffness.data[0] += 1e6 * np.eye(3)  # between the first node and the ground
    uneven = replace(part.matrices, stiffness=stiffness)
    assert len(half_models(part.mesh.nodes[uneven.free_nodes], uneven)) == 1
    assert len(halves_of(part)) == 2
