"""How a contact element's motion is read off, and its force spread over, the finite element nodes of a face.

Each coupling gives weights W (n_contacts, n_nodes): scalar motion of contact i = sum_j W_ij u_j, and by virtual work
a force f on contact i loads node j with W_ij f. Rows sum to one.
"""

from typing import Protocol

import numpy as np
import skfem
from numpy.typing import NDArray
from scipy import sparse
from skfem.quadrature import get_quadrature

from updamp.geometry.contact_elements import ContactElements
from updamp.geometry.patch_overlap import patch_overlap
from updamp.geometry.points_of_force import barycentric

Floats = NDArray[np.float64]
Integers = NDArray[np.int64]


class Coupling(Protocol):
    """nodes: (n_nodes, 3) [m]; facets: (n_facets, 8) node numbers; contacts: those of this face only."""

    def __call__(self, nodes: Floats, facets: Integers, contacts: ContactElements) -> sparse.csr_array: ...


def patch(nodes: Floats, facets: Integers, contacts: ContactElements) -> sparse.csr_array:
    """Average over the element's triangle, weighted; the force is a traction over it that is distributed likewise.

    W_ij = (1 / A_i) integral over triangle i of w_i N_j, N_j the 8-node shape functions, w_i the linear function of
    mean one that puts the force's resultant at the element's point (`ContactElements.corner_weights`). Converges with
    the mesh, and with the number of elements sooner than with w = 1 (geometry/points_of_force.py).

    raises: GeometryError where the facets do not cover a triangle
    """
    overlap = patch_overlap(contacts.triangle, nodes[facets[:, :4]])
    shape = facet_shape_functions(overlap.reference.T)
    places = np.einsum("jn,njx->nx", shape, nodes[facets[overlap.facet]])
    within = barycentric(contacts.triangle[overlap.triangle], places)
    weighting = np.einsum("nc,nc->n", contacts.corner_weights[overlap.triangle], within)
    weights = overlap.weight * weighting / contacts.area[overlap.triangle] * shape
    rows = np.broadcast_to(overlap.triangle, shape.shape)
    return sparse.csr_array(
        (weights.ravel(), (rows.ravel(), facets[overlap.facet].T.ravel())), shape=(len(contacts), len(nodes))
    )


def nearest_node(nodes: Floats, facets: Integers, contacts: ContactElements) -> sparse.csr_array:
    """The finite element node nearest to the triangle's centroid, as Pesaresi et al. (2017) do.

    The flexibility under one loaded node grows without bound as the mesh is refined: for comparison only.
    """
    candidates = np.unique(facets)
    distance = np.linalg.norm(contacts.triangle.mean(axis=1)[:, None] - nodes[candidates], axis=2)
    columns = candidates[distance.argmin(axis=1)]
    return sparse.csr_array(
        (np.ones(len(contacts)), (np.arange(len(contacts)), columns)), shape=(len(contacts), len(nodes))
    )


COUPLINGS: dict[str, Coupling] = {"patch": patch, "nearest_node": nearest_node}


def coupling_named(name: str) -> Coupling:
    """raises: ValueError for an unknown name, listing the known ones"""
    if name not in COUPLINGS:
        raise ValueError(f"contact.coupling = '{name}' is unknown; choose one of {', '.join(COUPLINGS)}")
    return COUPLINGS[name]


def facet_shape_functions(reference: Floats) -> Floats:
    """reference: (2, n) in [0, 1] -> (8, n): the traces of the 20-node hexahedron's shape functions on a facet."""
    element = skfem.ElementQuadS2()
    return np.array([element.lbasis(reference, i)[0] for i in range(8)])


def face_average(nodes: Floats, facets: Integers) -> Floats:
    """Weights (n_nodes,) of the average over a whole plane face; they sum to one. Integrates 3 x 3 Gauss points."""
    points, weights = get_quadrature(skfem.ElementQuadS2, 5)
    corners = nodes[facets[:, :4]]
    _, gradients = zip(*(skfem.ElementQuad1().lbasis(points, i) for i in range(4)), strict=True)
    along = np.einsum("fci,cdq->fqdi", corners, np.array(gradients))
    scale = np.linalg.norm(np.cross(along[:, :, 0], along[:, :, 1]), axis=2) * weights
    integrals = scale @ facet_shape_functions(points).T
    return np.bincount(facets.ravel(), integrals.ravel(), len(nodes)) / scale.sum()
