"""Where the triangular contact patches lie on the rectangular facets of a finite element face."""

from dataclasses import dataclass

import numpy as np
import shapely
from numpy.typing import NDArray

from updamp.geometry.rig_mesh import GeometryError

Floats = NDArray[np.float64]
Integers = NDArray[np.int64]


@dataclass(frozen=True, eq=False)
class PatchOverlap:
    """Quadrature points on the intersections of triangles and facets, one entry a point.

    An integral over triangle i is the sum over its points of weight times integrand.

    triangle, facet: (n,) numbers
    reference: (n, 2) coordinates in the facet, in [0, 1]: its corners 0, 1, 2, 3 are (0, 0), (1, 0), (1, 1), (0, 1)
    weight: (n,) [m^2]
    """

    triangle: Integers
    facet: Integers
    reference: Floats
    weight: Floats


def patch_overlap(triangles: Floats, facets: Floats) -> PatchOverlap:
    """Intersect every triangle with every facet; exact for polynomials of total degree 4 in the face's coordinates.

    triangles: (n_triangles, 3, 3) corners [m]; facets: (n_facets, 4, 3) corners of parallelograms in the same plane [m]
    raises: ValueError when a facet is no parallelogram, or facets and triangles do not lie in one plane;
        GeometryError when the facets do not cover every triangle
    """
    origin, axes, scale = _plane(triangles, facets)
    triangles_2d, facets_2d = ((points - origin) @ axes.T / scale for points in (triangles, facets))
    triangle_polygons, facet_polygons = shapely.polygons(triangles_2d), shapely.polygons(facets_2d)
    triangle, facet = shapely.STRtree(facet_polygons).query(triangle_polygons, predicate="intersects")
    common = shapely.intersection(triangle_polygons[triangle], facet_polygons[facet])
    keep = shapely.area(common) > 0  # those that only touch share no area
    pieces, owner = _fan(common[keep])
    points, weight = _quadrature(pieces)
    owner = np.repeat(np.flatnonzero(keep)[owner], points.shape[1])
    triangle, facet, points = triangle[owner], facet[owner], points.reshape(-1, 2)
    covered = np.bincount(triangle, weight.ravel(), len(triangles)).astype(np.float64)
    _check_cover(covered, shapely.area(triangle_polygons))
    return PatchOverlap(triangle, facet, _reference(points, facets_2d[facet]), weight.ravel() * scale**2)


def _plane(triangles: Floats, facets: Floats) -> tuple[Floats, Floats, float]:
    """Origin [m], two orthonormal axes (2, 3) and the size [m] of the common plane."""
    origin = facets[0, 0]
    along, across = facets[0, 1] - origin, facets[0, 3] - origin
    normal = np.cross(along, across)
    normal = normal / np.linalg.norm(normal)
    first = along / np.linalg.norm(along)
    everything = np.concatenate([triangles.reshape(-1, 3), facets.reshape(-1, 3)]) - origin
    scale = float(np.abs(everything).max())
    off_plane = float(np.abs(everything @ normal).max())
    if off_plane > 1e-9 * scale:
        raise ValueError(f"contact patches and facets must lie in one plane; they are {off_plane:.3g} m off it")
    skew = float(np.abs(facets[:, 0] - facets[:, 1] + facets[:, 2] - facets[:, 3]).max())
    if skew > 1e-9 * scale:
        raise ValueError(f"contact facets must be parallelograms; one is {skew:.3g} m off")
    return origin, np.stack([first, np.cross(normal, first)]), scale


def _fan(polygons: NDArray[np.object_]) -> tuple[Floats, Integers]:
    """Cut convex polygons into triangles (n, 3, 2) about their first corner; number of the polygon of each."""
    coordinates, polygon = shapely.get_coordinates(polygons, return_index=True)
    start = np.searchsorted(polygon, polygon)  # first coordinate of the same polygon
    place = np.arange(len(polygon))
    # Rings are closed, so a polygon's last coordinate is its first one and starts no edge; nor does the first corner
    # span a triangle with the two edges it lies on.
    last = np.searchsorted(polygon, polygon, side="right") - 1
    edge = np.flatnonzero((place > start) & (place < last - 1))
    return np.stack([coordinates[start[edge]], coordinates[edge], coordinates[edge + 1]], axis=1), polygon[edge]


def _quadrature(triangles: Floats) -> tuple[Floats, Floats]:
    """Points (n, 9, 2) and weights (n, 9): 3 x 3 Gauss points on the collapsed square, exact to total degree 4."""
    gauss, gauss_weight = ((array / 2).astype(np.float64) for array in np.polynomial.legendre.leggauss(3))
    gauss = gauss + 0.5
    u, v = (grid.ravel() for grid in np.meshgrid(gauss, gauss, indexing="ij"))
    shape = np.stack([1 - u, u * (1 - v), u * v])
    a, b = triangles[:, 1] - triangles[:, 0], triangles[:, 2] - triangles[:, 0]
    doubled_area = np.abs(a[:, 0] * b[:, 1] - a[:, 1] * b[:, 0])
    unit_weight = np.outer(gauss_weight * gauss, gauss_weight).ravel()
    return np.einsum("cq,tcd->tqd", shape, triangles), np.outer(doubled_area, unit_weight)


def _reference(points: Floats, facets: Floats) -> Floats:
    matrix = np.stack([facets[:, 1] - facets[:, 0], facets[:, 3] - facets[:, 0]], axis=-1)
    solution: Floats = np.linalg.solve(matrix, (points - facets[:, 0])[..., None]).astype(np.float64)
    return solution[..., 0]


def _check_cover(covered: Floats, area: Floats) -> None:
    fraction = covered / area
    worst = int(np.abs(fraction - 1).argmax())
    if abs(fraction[worst] - 1) > 1e-9:
        raise GeometryError(
            "damper.face_length",
            f"patch {worst} covered to {100 * fraction[worst]:.6g} %",
            "the facets must cover every contact patch exactly once; mesh and patches must be of the same rig",
        )
