"""How the pull is spread over the patches of the laboratory's contacts, by the pressure that the rig file states."""

import numpy as np
from numpy.polynomial.polynomial import polyval2d
from numpy.typing import NDArray

from updamp.benchmarks.virtual_rig.bodies import Bodies
from updamp.rig.pressure import PolynomialPressure, UniformPressure
from updamp.rig.rig import Rig

Floats = NDArray[np.float64]

# Six points of a triangle that integrate polynomials of order 4 exactly: weight of three, their two alike barycentric
# coordinates (D. A. Dunavant, Int. J. Numer. Meth. Engng 21 (1985) 1129, table II).
_RULE = ((0.223381589678011, 0.445948490915965), (0.109951743655322, 0.091576213509771))


def load_shares(rig: Rig, bodies: Bodies) -> Floats:
    """(n,) shares of what both faces carry, half of it each.

    raises: NotImplementedError for a pressure that the laboratory cannot lay on
    """
    pressure = rig.contact.pressure
    if isinstance(pressure, UniformPressure):
        mean = np.ones(len(bodies.area))
    elif isinstance(pressure, PolynomialPressure) and pressure.coefficients is not None:
        mean = _mean_over_patches(np.array(pressure.coefficients), bodies)
    else:
        raise NotImplementedError("contact.pressure: the laboratory knows uniform and polynomial coefficients")
    load = mean * bodies.area
    for side in (0, 1):
        load[bodies.face == side] /= 2 * load[bodies.face == side].sum()
    return load


def _mean_over_patches(coefficients: Floats, bodies: Bodies) -> Floats:
    """(n,) of the polynomial where it is not below zero."""
    mean = np.zeros(len(bodies.area))
    for weight, alike in _RULE:
        for one in range(3):
            corners = np.full(3, alike)
            corners[one] = 1 - 2 * alike
            mean += weight * np.maximum(polyval2d(bodies.up @ corners, bodies.along @ corners, coefficients), 0.0)
    return mean
