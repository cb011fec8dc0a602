"""Contact elements and points read off finite element fields, and the loads that go with them."""

from dataclasses import replace

import numpy as np
import pytest

from updamp.fem.assembly import assemble
from updamp.fem.coupling import coupling_named, face_average, nearest_node, patch
from updamp.fem.interface import BLADE_POINTS, DAMPER_POINTS, blade_interface, damper_interface, local_columns, on_face
from updamp.fem.quadratic_mesh import quadratic_mesh
from updamp.geometry.contact_elements import RIGHT


@pytest.fixture(scope="module")
def blade(tiny_mesh):
    return quadratic_mesh(tiny_mesh.blade)


@pytest.fixture(scope="module")
def contacts(tiny_mesh):
    return on_face(tiny_mesh.contacts, RIGHT)


@pytest.mark.parametrize("coupling", [patch, nearest_node])
def test_uniform_motion_is_reproduced(blade, contacts, coupling) -> None:
    motion = np.array([0.3, -1.2, 0.7])
    columns = local_columns(coupling(blade.nodes, blade.faces["contact"], contacts), contacts)
    read = (columns.T @ np.tile(motion, len(blade.nodes))).reshape(-1, 3)
    np.testing.assert_allclose(read, contacts.axes @ motion, atol=1e-13)


def test_patch_at_the_centroids_averages_quadratic_fields_exactly(blade, contacts) -> None:
    """The 8-node facets hold all quadratics; on a triangle their mean is that over the mid-side points."""
    plain = replace(contacts, point=contacts.triangle.mean(axis=1))
    weights = patch(blade.nodes, blade.faces["contact"], plain)

    def field(points: np.ndarray) -> np.ndarray:
        x, y, z = points.T
        return 1 + 40 * x - 30 * z + 900 * z**2 + 700 * y * z + 2000 * y**2

    corners = contacts.triangle
    middles = (corners + np.roll(corners, 1, axis=1)) / 2
    mean = field(middles.reshape(-1, 3)).reshape(-1, 3).mean(axis=1)
    np.testing.assert_allclose(weights @ field(blade.nodes), mean, rtol=1e-12)
    assert np.ptp(mean) > 0.01 * np.abs(mean).max()  # they differ from patch to patch


def test_uniform_traction_has_its_resultant_and_moment(blade, contacts) -> None:
    columns = local_columns(patch(blade.nodes, blade.faces["contact"], contacts), contacts)
    traction = np.array([0.2, -0.5, 1.0])
    forces = (columns @ (contacts.area[:, None] * traction).ravel()).reshape(-1, 3)
    direction = traction @ contacts.axes[0]
    np.testing.assert_allclose(forces.sum(axis=0), contacts.area.sum() * direction, rtol=1e-12)
    moment = np.cross(blade.nodes, forces).sum(axis=0)
    expected = np.cross(contacts.area @ contacts.point, direction)
    np.testing.assert_allclose(moment, expected, atol=1e-12 * np.linalg.norm(expected))


def test_linear_fields_are_read_at_the_points(blade, contacts) -> None:
    gradient = np.array([[3.0, -1.0, 2.0], [0.5, 4.0, -2.0], [1.0, 1.0, 5.0]])
    weights = patch(blade.nodes, blade.faces["contact"], contacts)
    np.testing.assert_allclose(weights @ (blade.nodes @ gradient), contacts.point @ gradient, atol=1e-14)


def test_a_rigid_face_is_as_stiff_on_its_elements_as_on_a_bed_of_springs(blade, contacts) -> None:
    """One stiffness per area in all directions, the face moved as a rigid body: the whole stiffness matrix (6, 6)."""
    middle = (contacts.triangle.min(axis=(0, 1)) + contacts.triangle.max(axis=(0, 1))) / 2
    axes = contacts.axes[0]
    columns = local_columns(patch(blade.nodes, blade.faces["contact"], contacts), contacts)
    arms = blade.nodes - middle
    rigid = np.stack(
        [np.broadcast_to(a, arms.shape) for a in axes] + [np.cross(a, arms) for a in axes], axis=-1
    ).reshape(-1, 6)
    read = (columns.T @ rigid).reshape(-1, 3, 6)
    stiffness = np.einsum("n,nda,ndb->ab", contacts.area, read, read)
    extent = np.ptp(np.einsum("ncx,dx->ncd", contacts.triangle, axes), axis=(0, 1))
    length, width = extent[:2]
    about = np.array([width**2, length**2, length**2 + width**2]) / 12
    np.testing.assert_allclose(stiffness, contacts.area.sum() * np.diag([1, 1, 1, *about]), atol=1e-18)


def test_uniform_traction_at_the_centroids_is_the_consistent_load_of_the_face(blade, contacts) -> None:
    """Patches tile the face: together they give the integral of each shape function over it, negative at corners."""
    plain = replace(contacts, point=contacts.triangle.mean(axis=1))
    weights = patch(blade.nodes, blade.faces["contact"], plain)
    whole = contacts.area.sum() * face_average(blade.nodes, blade.faces["contact"])
    np.testing.assert_allclose(contacts.area @ weights, whole, atol=1e-13 * whole.max())
    corner = blade.faces["contact"][:, :4]
    assert whole[corner].min() < 0 < whole[blade.faces["contact"][:, 4:]].min()


def test_nearest_node_is_the_nearest(blade, contacts) -> None:
    weights = nearest_node(blade.nodes, blade.faces["contact"], contacts).toarray()
    chosen = weights.argmax(axis=1)
    on_the_face = np.unique(blade.faces["contact"])
    assert np.isin(chosen, on_the_face).all()
    for centroid, node in zip(contacts.triangle.mean(axis=1), chosen, strict=True):
        distance = np.linalg.norm(blade.nodes[on_the_face] - centroid, axis=1)
        assert np.linalg.norm(blade.nodes[node] - centroid) == pytest.approx(distance.min(), abs=1e-15)


def test_points_of_blade_and_damper(tiny_mesh, reference_rig) -> None:
    """A linear field is read exactly at each point; a wire reads its end face's average."""
    gradient = np.random.default_rng(4).standard_normal((3, 3))
    for component, build, names in (
        (tiny_mesh.blade, blade_interface, BLADE_POINTS),
        (tiny_mesh.damper, damper_interface, DAMPER_POINTS),
    ):
        mesh = quadratic_mesh(component)
        interface = build(mesh, assemble(mesh, reference_rig.material), tiny_mesh.contacts, patch)
        assert interface.points == names
        read = dict(zip(names, (interface.operator.T @ (mesh.nodes @ gradient.T).ravel())[-len(names) :], strict=True))
        for name, value in read.items():
            point, axis = name.split(".")
            if point.startswith("wire"):
                quads = component.vertices[component.faces[point.replace("wire", "end")]]
                size = np.linalg.norm(np.cross(quads[:, 2] - quads[:, 0], quads[:, 3] - quads[:, 1]), axis=1)
                place = centroid_of(quads, size)
            else:
                place = component.vertices[component.points[point]]
            assert value == pytest.approx((gradient @ place)["xyz".index(axis)], rel=1e-10)


def centroid_of(quads: np.ndarray, size: np.ndarray) -> np.ndarray:
    """Of plane quadrilaterals, each cut into two triangles."""
    halves = [quads[:, [0, 1, 2]], quads[:, [0, 2, 3]]]
    areas = [np.linalg.norm(np.cross(t[:, 1] - t[:, 0], t[:, 2] - t[:, 0]), axis=1) for t in halves]
    assert np.allclose(sum(areas), size)
    return sum(area @ t.mean(axis=1) for area, t in zip(areas, halves, strict=True)) / size.sum()


def test_unknown_coupling_is_refused() -> None:
    with pytest.raises(ValueError, match=r"contact.coupling = 'glue' is unknown; choose one of patch, nearest_node"):
        coupling_named("glue")
