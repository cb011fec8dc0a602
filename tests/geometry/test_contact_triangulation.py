from math import cos, sin

import numpy as np
import pytest
from scipy.spatial import cKDTree

from updamp.geometry.contact_elements import LEFT, RIGHT
from updamp.geometry.contact_triangulation import _strip, contact_elements, triangulate_rectangle
from updamp.geometry.points_of_force import barycentric
from updamp.geometry.rig_mesh import GeometryError, mirrored_mesh


def with_contacts(rig, n, strips=None):
    return rig.mesh["small"].model_copy(update={"contact_elements": n, "contact_strips": strips})


def signed_area(triangles):
    a, b = triangles[:, 1] - triangles[:, 0], triangles[:, 2] - triangles[:, 0]
    return (a[:, 0] * b[:, 1] - a[:, 1] * b[:, 0]) / 2


@pytest.mark.parametrize("n", [4, 6, 8, 10, 36, 38, 60, 100, 146, 148, 300, 1000])
def test_counts_and_areas(rig, n):
    contacts = contact_elements(rig, with_contacts(rig, n))
    assert len(contacts) == n
    np.testing.assert_array_equal(contacts.face, [LEFT] * (n // 2) + [RIGHT] * (n // 2))
    for side in (LEFT, RIGHT):
        np.testing.assert_allclose(contacts.area[contacts.face == side].sum(), rig.face_area, rtol=1e-13)
    assert contacts.area.min() > 0.5 * contacts.area.mean()


@pytest.mark.parametrize("n", [5, 3, 2, 0, 147])
def test_impossible_counts(rig, n):
    with pytest.raises(GeometryError, match=f"contact_elements = {n}: an even number of at least 4"):
        contact_elements(rig, with_contacts(rig, n))


@pytest.mark.parametrize("strips", [1, 2, 4, 6, 9])
def test_as_many_strips_as_stated(rig, strips):
    """Of equal height, with elements of which none is more than twice as large as another."""
    contacts = contact_elements(rig, with_contacts(rig, 4 * strips + 16, strips))
    right = contacts.face == RIGHT
    assert right.sum() == 2 * strips + 8
    up = contacts.triangle[right] @ contacts.tangent1[right][0]
    assert len(np.unique(np.round(1e9 * up))) == strips + 1
    np.testing.assert_allclose(contacts.area[right].sum(), rig.face_area, rtol=1e-13)
    assert contacts.area.max() < 2.001 * contacts.area.min()


def test_more_strips_than_there_are_elements_for(rig):
    with pytest.raises(GeometryError, match="contact_strips = 10: 36 contact elements make at most 9 on either face"):
        contact_elements(rig, with_contacts(rig, 36, 10))


@pytest.mark.parametrize(("height", "length"), [(8.0, 60.0), (4.0, 60.0), (16.0, 60.0), (20.0, 20.0), (60.0, 8.0)])
@pytest.mark.parametrize("n", [18, 73, 150])
def test_triangulation_is_conforming_and_well_shaped(height, length, n):
    triangles = triangulate_rectangle(height, length, n)
    assert triangles.shape == (n, 3, 2)
    assert (signed_area(triangles) < 0).all()  # one orientation: no triangle is folded over another
    np.testing.assert_allclose(-signed_area(triangles).sum(), height * length, rtol=1e-13)
    points, corner = np.unique(np.round(triangles.reshape(-1, 2), 9), axis=0, return_inverse=True)
    corner = corner.reshape(-1, 3)
    edges, count = np.unique(np.sort(corner[:, [[0, 1], [1, 2], [2, 0]]].reshape(-1, 2)), axis=0, return_counts=True)
    ends = points[edges[count == 1]]
    boundary = [np.isclose(ends[..., d], bound).all(axis=1) for d in (0, 1) for bound in (0, (height, length)[d])]
    assert np.any(boundary, axis=0).all()  # an edge of only one triangle lies on the rectangle's rim
    sides = np.linalg.norm(triangles - np.roll(triangles, 1, axis=1), axis=2)
    shape = 4 * np.sqrt(3) * -signed_area(triangles) / (sides**2).sum(axis=1)
    assert shape.mean() > 0.8
    assert shape.min() > 0.6


@pytest.mark.parametrize("n", [36, 146, 100])
def test_faces_are_symmetric_about_mid_length(rig, n):
    contacts = contact_elements(rig, with_contacts(rig, n))
    right = contacts.point[contacts.face == RIGHT]
    turned = right * [1, 1, -1]
    distance = np.linalg.norm(right[:, None] - turned[None], axis=2).min(axis=1)
    assert distance.max() < 1e-15


@pytest.mark.parametrize(("p", "q"), [(4, 4), (2, 6), (18, 19), (8, 10), (1, 2)])
def test_a_strip_is_its_own_mirror_image(p, q):
    strip = _strip(p, q)
    assert len(strip) == p + q
    turned = np.array([0, 1]) + strip * np.array([1, -1])
    corners, other = ({frozenset(map(tuple, np.round(t, 9) + 0.0)) for t in side} for side in (strip, turned))
    assert corners == other


def test_triangles_lie_on_the_faces(rig, small):
    contacts, a, d = small.contacts, rig.platform.underside_angle, rig.damper
    x, y, z = np.moveaxis(contacts.triangle, -1, 0)
    x = np.where((contacts.face == LEFT)[:, None], -x, x)
    s = (x - rig.platform.gap / 2) / cos(a)
    np.testing.assert_allclose(y, rig.platform.top - rig.platform.edge_thickness - s * sin(a), atol=1e-15)
    np.testing.assert_allclose([s.min(), s.max()], [d.face_start, d.face_start + d.face_length], atol=1e-15)
    np.testing.assert_allclose([z.min(), z.max()], [-rig.blade.width / 2, rig.blade.width / 2], atol=1e-15)
    off_plane = np.einsum("nx,nx->n", contacts.point - contacts.triangle[:, 0], contacts.normal)
    np.testing.assert_allclose(off_plane, 0, atol=1e-16)
    assert barycentric(contacts.triangle, contacts.point).min() > 0


def test_axes(rig, small):
    contacts, a = small.contacts, rig.platform.underside_angle
    axes = contacts.axes
    np.testing.assert_allclose(axes @ axes.transpose(0, 2, 1), np.tile(np.eye(3), (len(contacts), 1, 1)), atol=1e-15)
    np.testing.assert_allclose(np.linalg.det(axes), np.where(contacts.face == RIGHT, 1, -1), atol=1e-14)
    right, left = axes[contacts.face == RIGHT], axes[contacts.face == LEFT]
    np.testing.assert_allclose(right[0], [[-cos(a), sin(a), 0], [0, 0, 1], [sin(a), cos(a), 0]], atol=1e-15)
    np.testing.assert_allclose(left, right * [-1, 1, 1], atol=1e-15)
    corners = contacts.triangle
    turn = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0]) / (2 * contacts.area[:, None])
    np.testing.assert_allclose(turn, contacts.normal * np.where(contacts.face == RIGHT, 1, -1)[:, None], atol=1e-12)


def test_normal_points_out_of_the_damper_into_the_platform(small):
    contacts = small.contacts
    damper_middle = small.damper.vertices.mean(axis=0)
    outward = np.einsum("id,id->i", contacts.normal, contacts.point - damper_middle)
    assert outward.min() > 0
    for side, blade in ((RIGHT, small.blade), (LEFT, mirrored_mesh(small.blade))):
        cells = blade.vertices[blade.hexahedra].mean(axis=1)
        of_side = contacts.face == side
        _, nearest = cKDTree(cells).query(contacts.point[of_side])
        inward = np.einsum("id,id->i", contacts.normal[of_side], cells[nearest] - contacts.point[of_side])
        assert inward.min() > 0
