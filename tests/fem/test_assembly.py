"""Stiffness and mass against scikit-fem's plain forms and against what any body must fulfil."""

import numpy as np
import pytest
import skfem
from skfem.helpers import dot
from skfem.io.meshio import INV_HEX_MAPPING
from skfem.models.elasticity import lame_parameters, linear_elasticity

from updamp.fem.assembly import assemble, clamp, distinct_shapes
from updamp.fem.quadratic_mesh import quadratic_mesh
from updamp.fem.rigid_body import rigid_body_fields
from updamp.geometry.rig_mesh import ComponentMesh


def distorted(mesh: ComponentMesh, amount: float) -> ComponentMesh:
    shift = amount * np.random.default_rng(3).uniform(-1, 1, mesh.vertices.shape)
    return ComponentMesh(mesh.name, mesh.vertices + shift, mesh.hexahedra, mesh.faces, mesh.points)


@skfem.BilinearForm
def inertia(u, v, _):
    return dot(u, v)


def plain_forms(component: ComponentMesh, material) -> tuple[np.ndarray, np.ndarray]:
    """K and M by scikit-fem's own forms on the vector element, in this project's numbering."""
    hexahedra = component.hexahedra[:, INV_HEX_MAPPING[:8]]
    mesh = skfem.MeshHex(np.ascontiguousarray(component.vertices.T), np.ascontiguousarray(hexahedra.T))
    basis = skfem.Basis(mesh, skfem.ElementVector(skfem.ElementHexS2()), intorder=4)
    first, second = lame_parameters(material.youngs_modulus, material.poissons_ratio)
    stiffness = linear_elasticity(first, second).assemble(basis).toarray()
    mass = material.density * inertia.assemble(basis).toarray()
    return stiffness, mass


@pytest.mark.parametrize("amount", [0.0, 0.08])
def test_equals_plain_forms(box, steel, amount: float) -> None:
    component = distorted(box((2, 3, 2), (1.0, 2.0, 1.5)), amount)
    ours = assemble(quadratic_mesh(component), steel)
    stiffness, mass = plain_forms(component, steel)
    np.testing.assert_allclose(ours.stiffness.toarray(), stiffness, atol=1e-13 * np.abs(stiffness).max(), rtol=0)
    np.testing.assert_allclose(ours.mass.toarray(), mass, atol=1e-13 * np.abs(mass).max(), rtol=0)


def test_identical_elements_are_computed_once(box) -> None:
    regular = quadratic_mesh(box((3, 4, 5), (0.3, 0.1, 0.7)))
    assert len(distinct_shapes(regular)[0]) == 1
    irregular = quadratic_mesh(distorted(box((3, 4, 5), (0.3, 0.1, 0.7)), 1e-4))
    assert len(distinct_shapes(irregular)[0]) == 60


def test_stiffness_is_symmetric_and_rigid_motion_costs_nothing(box, steel) -> None:
    mesh = quadratic_mesh(distorted(box((3, 3, 3), (0.3, 0.2, 0.4)), 0.01))
    matrices = assemble(mesh, steel)
    largest = np.abs(matrices.stiffness.data).max()
    assert np.abs((matrices.stiffness - matrices.stiffness.T).toarray()).max() < 1e-12 * largest
    forces = matrices.stiffness @ rigid_body_fields(mesh.nodes)
    assert np.abs(forces).max() < 1e-12 * largest


def test_mass_and_inertia_of_a_box(box, steel) -> None:
    size = np.array([0.3, 0.2, 0.4])
    mesh = quadratic_mesh(box((2, 3, 4), tuple(size)))
    rigid = rigid_body_fields(mesh.nodes)
    mass = steel.density * size.prod()
    inertia_moments = mass * (np.sum(size**2) - size**2) / 12
    expected = np.diag([mass] * 3 + list(inertia_moments))
    np.testing.assert_allclose(rigid.T @ assemble(mesh, steel).mass @ rigid, expected, atol=1e-12 * mass)


def test_damper_has_the_mass_and_inertia_of_its_section(reference_rig, tiny_mesh) -> None:
    """A prism: area, centroid and second moments of the polygon around the mesh's back end, in closed form."""
    material = reference_rig.material
    mesh = quadratic_mesh(tiny_mesh.damper)
    area, centroid, second = section_properties(tiny_mesh.damper)
    width = reference_rig.blade.width
    mass = material.density * area * width
    about_z = material.density * width * np.trace(second)
    arms = mesh.nodes - np.array([*centroid, 0.0])
    rotation = np.cross([0.0, 0.0, 1.0], arms).ravel()
    along_x = np.tile([1.0, 0.0, 0.0], len(mesh.nodes))
    M = assemble(mesh, material).mass
    assert along_x @ M @ along_x == pytest.approx(mass, rel=1e-12)
    assert along_x @ M @ rotation == pytest.approx(0, abs=1e-14 * mass)
    assert rotation @ M @ rotation == pytest.approx(about_z, rel=1e-12)


def section_properties(damper: ComponentMesh) -> tuple[float, np.ndarray, np.ndarray]:
    """Area, centroid (2,) and second moments about it (2, 2) of the end face, from its quadrilaterals' outlines."""
    quads = damper.vertices[damper.faces["end_back"]][:, :, :2]
    following = np.roll(quads, -1, axis=1)
    cross = quads[..., 0] * following[..., 1] - following[..., 0] * quads[..., 1]
    cross *= np.sign(cross.sum(axis=1))[:, None]
    area = cross.sum() / 2
    centroid = np.einsum("fe,fei->i", cross, quads + following) / (6 * area)
    pairs = np.einsum("fei,fej->feij", quads, quads) + np.einsum("fei,fej->feij", following, following)
    both = quads + following
    second = np.einsum("fe,feij->ij", cross, pairs + np.einsum("fei,fej->feij", both, both)) / 24
    return area, centroid, second - area * np.outer(centroid, centroid)


def test_clamping_keeps_the_rest(box, steel) -> None:
    mesh = quadratic_mesh(box((2, 2, 2), (1.0, 1.0, 1.0)))
    whole = assemble(mesh, steel)
    root = np.unique(mesh.faces["root"])
    held = clamp(whole, root)
    dofs = np.setdiff1d(np.arange(mesh.n_dofs), (3 * root[:, None] + np.arange(3)).ravel())
    np.testing.assert_array_equal(held.free_dofs, dofs)
    np.testing.assert_array_equal(held.stiffness.toarray(), whole.stiffness.toarray()[np.ix_(dofs, dofs)])
    np.testing.assert_array_equal(held.mass.toarray(), whole.mass.toarray()[np.ix_(dofs, dofs)])
    assert np.all(mesh.nodes[root, 1] == 0)
    assert len(root) == 21  # 9 vertices and 12 edges: mid-edge nodes are clamped too


def test_refuses_what_cannot_be_assembled(box, steel) -> None:
    mesh = box((1, 1, 1), (1.0, 1.0, 1.0))
    with pytest.raises(ValueError, match="no node to clamp"):
        clamp(assemble(quadratic_mesh(mesh), steel), np.array([], dtype=np.int64))
    bent = mesh.vertices.copy()
    bent[mesh.points["corner"]] = [-0.5, -0.5, -0.5]
    with pytest.raises(ValueError, match="turned inside out"):
        assemble(quadratic_mesh(ComponentMesh("bent", bent, mesh.hexahedra, {}, {})), steel)
    lonely = np.vstack([mesh.vertices, [2.0, 2.0, 2.0]])
    with pytest.raises(ValueError, match="belongs to no hexahedron"):
        quadratic_mesh(ComponentMesh("lonely", lonely, mesh.hexahedra, {}, {}))
    with pytest.raises(ValueError, match="is not a side of any hexahedron"):
        quadratic_mesh(ComponentMesh("box", mesh.vertices, mesh.hexahedra, {"cut": np.array([[0, 1, 2, 7]])}, {}))
