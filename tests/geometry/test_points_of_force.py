"""Points of force: a quadrature rule of order 2 over the rectangle that the triangles tile."""

import numpy as np
import pytest

from updamp.geometry.contact_triangulation import triangulate_rectangle
from updamp.geometry.points_of_force import barycentric, points_of_force


def areas(triangles):
    a, b = triangles[:, 1] - triangles[:, 0], triangles[:, 2] - triangles[:, 0]
    return np.abs(a[:, 0] * b[:, 1] - a[:, 1] * b[:, 0]) / 2


@pytest.mark.parametrize(("height", "length"), [(8.0, 60.0), (5.2, 15.0), (20.0, 20.0), (60.0, 8.0)])
@pytest.mark.parametrize("n", [2, 4, 7, 18, 32, 73, 150])
def test_polynomials_of_order_two_are_integrated_exactly(height, length, n):
    triangles = triangulate_rectangle(height, length, n)
    area, (s, z) = areas(triangles), points_of_force(triangles).T
    s, z = s - height / 2, z - length / 2
    size = height * length
    for integrand, exact in (
        (s, 0), (z, 0), (s**2, height**2 / 12), (z**2, length**2 / 12),
    ):  # fmt: skip
        assert area @ integrand / size == pytest.approx(exact, rel=1e-12, abs=1e-12)


@pytest.mark.parametrize(("height", "length", "n"), [(8.2, 20, 18), (8.2, 20, 32), (5.2, 15, 73), (5.2, 15, 36)])
def test_a_force_presses_everywhere_in_its_triangle(height, length, n):
    """The traction of a pressing force, 12 l - 3 at the corners, l the barycentric coordinates, pulls nowhere where
    there are two strips or more."""
    triangles = triangulate_rectangle(height, length, n)
    lifted = np.pad(triangles, ((0, 0), (0, 0), (0, 1)))
    coordinates = barycentric(lifted, np.pad(points_of_force(triangles), ((0, 0), (0, 1))))
    np.testing.assert_allclose(coordinates.sum(axis=1), 1, rtol=1e-13)
    assert coordinates.min() >= 0.25 - 1e-12


def test_points_draw_nearer_to_the_centroids_with_the_square_of_the_size():
    numbers = [18, 72, 288, 1152]
    away = []
    for n in numbers:
        triangles = triangulate_rectangle(8.0, 20.0, n)
        away.append(np.abs(points_of_force(triangles) - triangles.mean(axis=1)).max())
    order = np.polyfit(np.log(np.sqrt(numbers)), np.log(away), 1)[0]
    assert order == pytest.approx(-2, abs=0.3)
