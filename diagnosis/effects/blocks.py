"""Changes of one component's modes within the side-by-side model: the others and the order of owners stay."""

from dataclasses import replace

import numpy as np
import scipy.linalg
from numpy.typing import NDArray

from updamp.diagnosis.model.rig_model import RigModel
from updamp.hbm.linear_model import LinearModel

Floats = NDArray[np.float64]
Integers = NDArray[np.int64]

BLADES = ("blade_left", "blade_right")


def modes_of(model: RigModel, component: str) -> Integers:
    """Numbers of its modes. raises: ValueError naming the components there are"""
    modes = np.flatnonzero(np.array(model.owner) == component)
    if not len(modes):
        there = ", ".join(dict.fromkeys(model.owner)) or "none"
        raise ValueError(f"the model has no component '{component}', which this effect changes; there are {there}")
    return modes


def with_block_stiffness(components: LinearModel, modes: Integers, stiffness: Floats) -> LinearModel:
    """The model with the modal stiffness of these modes (k, k) [rad^2/s^2] brought back to modes of their own."""
    values, X = scipy.linalg.eigh(stiffness)
    omega_squared, T = components.omega_squared.copy(), np.eye(len(components.omega_squared))
    omega_squared[modes] = values
    T[np.ix_(modes, modes)] = X
    return replace(
        components,
        omega_squared=omega_squared,
        phi=components.phi @ T,
        hysteretic=T.T @ components.hysteretic @ T,
        viscous=T.T @ components.viscous @ T,
    )
