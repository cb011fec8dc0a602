import numpy as np
import pytest

from updamp.geometry.contact_elements import LEFT, RIGHT
from updamp.geometry.patch_overlap import patch_overlap
from updamp.geometry.rig_mesh import GeometryError, mirrored_mesh

MONOMIALS = [(i, j) for i in range(5) for j in range(5 - i)]


def faces(mesh):
    """(triangles, facets) of blade and damper on both sides."""
    contacts = mesh.contacts
    for side, blade, name in ((RIGHT, mesh.blade, "contact_right"), (LEFT, mirrored_mesh(mesh.blade), "contact_left")):
        triangles = contacts.triangle[contacts.face == side]
        yield triangles, blade.vertices[blade.faces["contact"]]
        yield triangles, mesh.damper.vertices[mesh.damper.faces[name]]


def physical(overlap, facets):
    corners, (xi, eta) = facets[overlap.facet], overlap.reference.T[:, :, None]
    return (
        corners[:, 0] * (1 - xi) * (1 - eta)
        + corners[:, 1] * xi * (1 - eta)
        + corners[:, 2] * xi * eta
        + corners[:, 3] * (1 - xi) * eta
    )


def barycentric(triangle, points):
    """Coordinates in the triangle and distance from its plane [m]."""
    a, b = triangle[:, 1] - triangle[:, 0], triangle[:, 2] - triangle[:, 0]
    normal = np.cross(a, b)
    normal /= np.linalg.norm(normal, axis=1, keepdims=True)
    edges = np.stack([a, b, normal], axis=-1)
    u, v, off = np.linalg.solve(edges, (points - triangle[:, 0])[..., None])[..., 0].T
    return np.stack([1 - u - v, u, v], axis=-1), off


def areas(corners):
    """Of the parallelograms spanned at corner 0 by its two neighbours."""
    return np.linalg.norm(np.cross(corners[:, 1] - corners[:, 0], corners[:, -1] - corners[:, 0]), axis=1)


def triangle_integral(triangle, function):
    """Of a function of points, by 8 x 8 Gauss points on the collapsed square."""
    x, w = np.polynomial.legendre.leggauss(8)
    u, v = ((grid.ravel() + 1) / 2 for grid in np.meshgrid(x, x))
    weight = np.outer(w, w).ravel() / 4 * u
    points = np.stack([1 - u, u * (1 - v), u * v], axis=-1) @ triangle
    return np.linalg.norm(np.cross(triangle[1] - triangle[0], triangle[2] - triangle[0])) * weight @ function(points)


@pytest.mark.parametrize("preset", ["small", "full"])
def test_weights_sum_to_patch_and_facet_areas(request, preset):
    for triangles, facets in faces(request.getfixturevalue(preset)):
        overlap = patch_overlap(triangles, facets)
        np.testing.assert_allclose(np.bincount(overlap.triangle, overlap.weight), areas(triangles) / 2, rtol=1e-12)
        np.testing.assert_allclose(np.bincount(overlap.facet, overlap.weight), areas(facets), rtol=1e-12)
        assert overlap.weight.min() > 0


def test_points_lie_in_their_facet_and_triangle(full):
    for triangles, facets in faces(full):
        overlap = patch_overlap(triangles, facets)
        assert overlap.reference.min() > -1e-12
        assert overlap.reference.max() < 1 + 1e-12
        coordinates, off = barycentric(triangles[overlap.triangle], physical(overlap, facets))
        assert coordinates.min() > -1e-10
        assert np.abs(off).max() < 1e-15


@pytest.mark.parametrize("powers", MONOMIALS)
def test_monomials_over_patches_and_over_facets(small, powers):
    i, j = powers
    for triangles, facets in faces(small):
        overlap = patch_overlap(triangles, facets)
        origin, size = triangles[:, 0].mean(axis=0), 0.02

        def monomial(points, origin=origin, size=size):
            local = (points - origin) / size
            return local[:, 0] ** i * local[:, 2] ** j

        got = np.bincount(overlap.triangle, overlap.weight * monomial(physical(overlap, facets)))
        expected = np.array([triangle_integral(triangle, monomial) for triangle in triangles])
        np.testing.assert_allclose(got, expected, rtol=1e-11, atol=1e-12 * np.abs(expected).max())
        xi, eta = overlap.reference.T
        got = np.bincount(overlap.facet, overlap.weight * xi**i * eta**j)
        np.testing.assert_allclose(got, areas(facets) / ((i + 1) * (j + 1)), rtol=1e-11)


def test_any_order_of_a_facets_corners(small):
    triangles, facets = next(faces(small))
    plain = patch_overlap(triangles, facets)
    random = np.random.default_rng(7)
    shuffled = np.array([np.roll(f if random.random() < 0.5 else f[::-1], random.integers(4), axis=0) for f in facets])
    other = patch_overlap(triangles, shuffled)
    moments = [
        np.array([np.bincount(o.triangle, o.weight * physical(o, f)[:, d] ** 2) for d in range(3)])
        for o, f in ((plain, facets), (other, shuffled))
    ]
    np.testing.assert_allclose(moments[1], moments[0], rtol=1e-11)


def test_errors(small):
    triangles, facets = next(faces(small))
    with pytest.raises(GeometryError, match=r"patch \d+ covered to .* must cover every contact patch"):
        patch_overlap(triangles, facets[1:])
    with pytest.raises(GeometryError, match=r"covered to 200 %"):
        patch_overlap(triangles, np.concatenate([facets, facets]))
    with pytest.raises(ValueError, match="must lie in one plane"):
        patch_overlap(triangles + np.array([0, 1e-6, 0]), facets)
    crooked = facets.copy()
    crooked[3, 2] += 0.1 * (crooked[3, 2] - crooked[3, 1])
    with pytest.raises(ValueError, match="must be parallelograms"):
        patch_overlap(triangles, crooked)
