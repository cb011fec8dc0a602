"""Where the force of a triangular contact element acts, so that few of them carry what their face carries."""

import numpy as np
from numpy.typing import NDArray

Floats = NDArray[np.float64]


def points_of_force(triangles: Floats) -> Floats:
    """(n, 2) points in triangles (n, 3, 2) that tile a rectangle, whose sides are along the coordinates.

    At the centroids, forces carry less of a face's rotation than the traction over it does: with m strips of triangles
    2 / (3 m^2) less, a sixth with two. So the centroids are moved away from the face's middle, along either axis in
    one proportion, until the areas at the points have the second moments of the face: products of linear fields are
    integrated exactly then (a quadrature rule of order 2), and a rigid face is as stiff as under the traction.
    What that does to resonances: docs/harmonic_balance.md, Contact elements.
    """
    centroid, area = triangles.mean(axis=1), areas(triangles)
    arm = centroid - np.average(centroid, axis=0, weights=area)
    lost = np.average(((triangles - centroid[:, None]) ** 2).sum(axis=1) / 12, axis=0, weights=area)
    kept = np.average(arm**2, axis=0, weights=area)
    points: Floats = centroid + arm * (np.sqrt(1 + lost / kept) - 1)
    return points


def areas(triangles: Floats) -> Floats:
    """(n,) of triangles (n, 3, 2)"""
    a, b = triangles[:, 1] - triangles[:, 0], triangles[:, 2] - triangles[:, 0]
    return np.asarray(np.abs(a[:, 0] * b[:, 1] - a[:, 1] * b[:, 0]) / 2)


def barycentric(triangle: Floats, place: Floats) -> Floats:
    """(n, 3) barycentric coordinates of a place (n, 3) in the plane of each triangle (n, 3, 3); their sum is one."""
    edges = triangle[:, 1:] - triangle[:, :1]
    metric = np.einsum("nix,njx->nij", edges, edges)
    right = np.einsum("nix,nx->ni", edges, place - triangle[:, 0])
    inner = np.linalg.solve(metric, right[:, :, None])[:, :, 0]
    return np.column_stack([1 - inner.sum(axis=1), inner])
