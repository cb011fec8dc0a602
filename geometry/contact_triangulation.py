"""Lay an exact number of near-equilateral triangles over the damper's contact faces."""

from collections.abc import Callable
from functools import cache, partial
from itertools import pairwise
from math import cos, floor, sin, sqrt

import numpy as np
from numpy.typing import NDArray

from updamp.geometry.contact_elements import LEFT, RIGHT, ContactElements
from updamp.geometry.points_of_force import areas, points_of_force
from updamp.geometry.rig_mesh import GeometryError
from updamp.rig.mesh_divisions import MeshDivisions
from updamp.rig.rig import Rig

Floats = NDArray[np.float64]
Integers = NDArray[np.int64]

_ASYMMETRIC = 1.0  # cost of a triangle in a strip that is not its own mirror image in z; a good one costs about 0.1

Cost = Callable[[int, int], float]  # of the triangles of a strip between rows of so many segments


def contact_elements(rig: Rig, divisions: MeshDivisions) -> ContactElements:
    """divisions.contact_elements triangles, half of them on each face, mirror images in x.

    On the right face a triangle's corners turn counterclockwise about its normal, on the left one clockwise.

    raises: GeometryError when the number is odd or below 4, or too small for divisions.contact_strips
    """
    n, strips = divisions.contact_elements, divisions.contact_strips
    if n < 4 or n % 2:
        raise GeometryError("contact_elements", str(n), "an even number of at least 4 is needed, half for each face")
    if strips and n < 4 * strips:
        raise GeometryError("contact_strips", str(strips), f"{n} contact elements make at most {n // 4} on either face")
    plane = triangulate_rectangle(rig.damper.face_length, rig.blade.width, n // 2, strips)
    right, point = _on_right_face(rig, plane), _on_right_face(rig, points_of_force(plane))
    mirror = np.array([-1.0, 1.0, 1.0])
    triangle = np.concatenate([right * mirror, right])
    face = np.repeat([LEFT, RIGHT], n // 2)
    flip = np.where((face == LEFT)[:, None], mirror, 1.0)
    a = rig.platform.underside_angle
    return ContactElements(
        face=face,
        point=np.concatenate([point * mirror, point]),
        area=np.linalg.norm(np.cross(triangle[:, 1] - triangle[:, 0], triangle[:, 2] - triangle[:, 0]), axis=1) / 2,
        tangent1=flip * np.array([-cos(a), sin(a), 0.0]),
        tangent2=np.tile([0.0, 0.0, 1.0], (n, 1)),
        normal=flip * np.array([sin(a), cos(a), 0.0]),
        triangle=triangle,
    )


def _on_right_face(rig: Rig, plane: Floats) -> Floats:
    """(..., 3) places in space [m] of those (..., 2) in (distance down the face, z from its back end)."""
    top, bottom, width = np.array(rig.face_top), np.array(rig.face_bottom), rig.blade.width
    down, z = plane[..., :1] / rig.damper.face_length, plane[..., 1:] - width / 2
    return np.concatenate([top + down * (bottom - top), z], axis=-1)


def triangulate_rectangle(height: float, length: float, n: int, strips: int | None = None) -> Floats:
    """Exactly n triangles in strips along `length`, symmetric about its middle.

    Rows of equally spaced points at equal distances over the height; a strip between rows of p and q segments holds
    p + q triangles.

    height, length: of the rectangle [m]
    strips: how many, with triangles as nearly of one size as they allow; by default as many as make them as near to
        equilateral as can be
    returns: (n, 3, 2) corners [m] in (along height, along length)
    """
    if strips:
        _, rows = _best_rows(_unevenness, strips, n)
    else:
        ideal = height / sqrt(sqrt(3.0) * height * length / n)  # strips of equilateral triangles of the mean area
        fewest, most = max(1, floor(ideal) - 1), min(n // 2, floor(ideal) + 2)
        numbers = range(min(fewest, most), max(1, most) + 1)
        _, rows = min(_best_rows(partial(_flatness, height / m, length), m, n) for m in numbers)
    step = height / (len(rows) - 1)
    found = []
    for i, (p, q) in enumerate(pairwise(rows)):
        strip = _strip(p, q) * np.array([step, length])
        strip[..., 0] += i * step
        found.append(strip)
    return np.concatenate(found)


def _flatness(step: float, length: float, p: int, q: int) -> float:
    """What the triangles of a strip so high and so long lack of being equilateral, all together."""
    return float(np.sum(1 - _shape(_strip(p, q) * np.array([step, length]))))


def _unevenness(p: int, q: int) -> float:
    """Sum of the squared areas of the triangles, in parts of their strip's."""
    return float(np.sum(areas(_strip(p, q)) ** 2))


def _best_rows(cost: Cost, n_strips: int, n: int) -> tuple[float, tuple[int, ...]]:
    """Cost and segments of each of the rows that give n triangles in all at the lowest cost (dynamic programming)."""
    mean = n // (2 * n_strips)
    allowed = range(max(1, mean - 2), mean + 4)

    @cache
    def strip_cost(p: int, q: int) -> float:
        return cost(p, q) + _ASYMMETRIC * (p + q) * (p % 2 and q % 2)

    best: dict[tuple[int, int], tuple[float, tuple[int, ...]]] = {(p, 0): (0.0, (p,)) for p in allowed}
    for _ in range(n_strips):
        following: dict[tuple[int, int], tuple[float, tuple[int, ...]]] = {}
        for (p, count), (so_far, rows) in best.items():
            for q in allowed:
                candidate = (so_far + strip_cost(p, q), (*rows, q))
                state = (q, count + p + q)
                if state not in following or candidate < following[state]:
                    following[state] = candidate
        best = following
    return min(choice for (_, count), choice in best.items() if count == n)


def _strip(p: int, q: int) -> Floats:
    """(p + q, 3, 2) triangles of the unit square between p segments at 0 and q at 1, from one end to the other.

    A segment's opposite corner lies between the neighbouring segments of the other row whose midpoints come before
    and after its own. Midpoints are compared as integers; equal ones are taken so that the halves mirror each other.
    """
    low, high = np.arange(p), np.arange(q)
    low_key, high_key = 2 * (2 * low + 1) * q, 2 * (2 * high + 1) * p
    high_key = high_key + np.where(high_key <= 2 * p * q, 1, -1)
    low_apex, high_apex = np.searchsorted(high_key, low_key), np.searchsorted(low_key, high_key)
    zeros, ones = np.zeros, np.ones
    # Counterclockwise about the outward normal with the first coordinate running down the face, the second along +z.
    first = np.stack(
        [
            np.stack([zeros(p), low / p], axis=-1),
            np.stack([zeros(p), (low + 1) / p], axis=-1),
            np.stack([ones(p), low_apex / q], axis=-1),
        ],
        axis=1,
    )
    second = np.stack(
        [
            np.stack([ones(q), (high + 1) / q], axis=-1),
            np.stack([ones(q), high / q], axis=-1),
            np.stack([zeros(q), high_apex / p], axis=-1),
        ],
        axis=1,
    )
    return np.concatenate([first, second])[np.argsort(np.concatenate([low_key, high_key]))]


def _shape(triangles: Floats) -> Floats:
    """1 for an equilateral triangle, 0 for a flat one: 4 sqrt(3) area / sum of squared sides."""
    a, b, c = triangles[:, 1] - triangles[:, 0], triangles[:, 2] - triangles[:, 1], triangles[:, 0] - triangles[:, 2]
    shape: Floats = 4 * sqrt(3.0) * areas(triangles) / np.sum(a**2 + b**2 + c**2, axis=1)
    return shape
