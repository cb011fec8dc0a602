"""Stiffness and mass of straight-edged 20-node hexahedra, many at once.

The three displacement components share one scalar basis, so that all is built from the integrals of
products of its gradients, which are matrix products over the quadrature points.
"""

from typing import Protocol

import numpy as np
import skfem
from numpy.typing import NDArray
from skfem.quadrature import get_quadrature


class ElasticMaterial(Protocol):
    """Isotropic linear elastic: Young's modulus [Pa], Poisson's ratio [-], density [kg/m^3]."""

    @property
    def youngs_modulus(self) -> float: ...
    @property
    def poissons_ratio(self) -> float: ...
    @property
    def density(self) -> float: ...


def lame_parameters(material: ElasticMaterial) -> tuple[float, float]:
    """First and second Lame parameter [Pa]; the second is the shear modulus."""
    modulus, ratio = material.youngs_modulus, material.poissons_ratio
    return modulus * ratio / ((1 + ratio) * (1 - 2 * ratio)), modulus / (2 * (1 + ratio))


Floats = NDArray[np.float64]

# 3 x 3 x 3 Gauss points: exact for the mass of a parallelepiped. With 14 or 8 points frequencies are visibly off.
INTEGRATION_ORDER = 4


def _reference_basis(element: skfem.Element, points: Floats) -> tuple[Floats, Floats]:
    """Values (n_basis, q) and reference gradients (n_basis, 3, q) of a scalar element."""
    pairs = [element.lbasis(points.copy(), i) for i in range(len(element.doflocs))]
    shape = (points.shape[1],)
    values = np.array([np.broadcast_to(value, shape) for value, _ in pairs])
    gradients = np.array([[np.broadcast_to(part, shape) for part in gradient] for _, gradient in pairs])
    return values, gradients


def element_matrices(corners: Floats, material: ElasticMaterial) -> tuple[Floats, Floats]:
    """Stiffness and scalar mass of isotropic linear elastic hexahedra.

    corners: (n, 8, 3) vertices in the order of skfem.ElementHex1 [m]
    returns: stiffness (n, 20, 20, 3, 3) [N/m], mass (n, 20, 20) [kg], the latter the same for each component
    raises: ValueError for an element whose Jacobian changes sign or vanishes
    """
    points, weights = get_quadrature(skfem.ElementHexS2, INTEGRATION_ORDER)
    _, geometry_gradients = _reference_basis(skfem.ElementHex1(), points)
    values, gradients = _reference_basis(skfem.ElementHexS2(), points)
    # jacobian[e, q, i, j] = d x_i / d X_j
    jacobian = np.einsum("eai,ajq->eqij", corners, geometry_gradients, optimize=True)
    determinant = np.linalg.det(jacobian)
    if not (np.all(determinant > 0, axis=1) | np.all(determinant < 0, axis=1)).all():
        raise ValueError("the mesh has a hexahedron that is turned inside out or has no volume; check its vertex order")
    scale = np.abs(determinant) * weights
    physical = np.einsum("ajq,eqji->eiaq", gradients, np.linalg.inv(jacobian), optimize=True)
    mass = material.density * np.einsum("eq,aq,bq->eab", scale, values, values, optimize=True)
    return _stiffness(physical * np.sqrt(scale)[:, None, None, :], material), mass


def _stiffness(gradients: Floats, material: ElasticMaterial) -> Floats:
    """gradients: (n, 3, 20, q) physical, times the square root of the quadrature weight -> (n, 20, 20, 3, 3)."""
    n, _, n_basis, n_points = gradients.shape
    flat = gradients.reshape(n, 3 * n_basis, n_points)
    # products[e, i, a, j, b] = integral of d_i N_a d_j N_b
    products = (flat @ flat.transpose(0, 2, 1)).reshape(n, 3, n_basis, 3, n_basis)
    first, second = lame_parameters(material)
    stiffness = first * products.transpose(0, 2, 4, 1, 3) + second * products.transpose(0, 2, 4, 3, 1)
    stiffness += second * np.einsum("eiaib->eab", products)[..., None, None] * np.eye(3)
    return stiffness
