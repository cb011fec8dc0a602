"""What effects of the structure have in common: elements at a joint or at the blades' tips, and changes of one
component's modes.

Effects of a bolted joint are for models whose modes were identified in a test. The joint is not a point of such a
model: its motion goes with that of the mode, so an element at the excitation point stands for it, and its parameters
are those seen from there. With several modes, each of which moves the joint otherwise, it may be placed at another
point (`placed.py`).

Elements at the tips stand for what the blades themselves do, or what touches them there; between the platforms, for
what happens across their gap. Changes of one component's modes are made within the model
of all components side by side: the other components and the order of owners stay.
"""

from collections.abc import Callable, Iterator, Mapping
from dataclasses import replace
from typing import Any

import jax.numpy as jnp
import numpy as np
import scipy.linalg
from numpy.typing import NDArray
from scipy.sparse import csr_array
from scipy.sparse.csgraph import connected_components

from updamp.effects.rig_model import PointElement, RigModel
from updamp.hbm.contact.between_points import BetweenPoints
from updamp.hbm.contact.law import ContactLaw

Floats = NDArray[np.float64]
Integers = NDArray[np.int64]

BLADES = ("blade_left", "blade_right")
TIPS = ("blade_left.tip.x", "blade_right.tip.x")
PLATFORMS = ("blade_left.platform.x", "blade_right.platform.x")
# Fewest samples of a period for laws that are not smooth.
_SAMPLES = 128


def joint_model(model: RigModel) -> RigModel:
    """raises: ValueError where the model is not one that these effects are for"""
    if model.contacts is not None:
        raise ValueError(
            "this effect stands for a joint in a model of identified modes, and this model has contacts of its own: "
            "take an effect of the contact, such as sub_patch_microslip"
        )
    if not model.identified:
        raise ValueError(
            'this effect stands for a joint in a model of identified modes (a rig file with kind = "modal"); the modes '
            "of this model were computed"
        )
    return model


def joint_of(model: RigModel) -> str:
    """Point that the effects of a joint act at; raises as `joint_model`"""
    return joint_model(model).joint or model.excitation


def with_joint_element(model: RigModel, name: str, law: ContactLaw, **entries: float) -> RigModel:
    """The model with an element between its joint and the ground; entries: of the law's parameters.

    raises: ValueError where the model is not one of identified modes without contacts
    """
    added = _element(name, (joint_of(model),), law, entries)
    return replace(model, elements=(*model.elements, added), time_samples=max(model.time_samples, _SAMPLES))


def with_point_element(model: RigModel, name: str, point: str, law: ContactLaw, **entries: float) -> RigModel:
    """The model with an element between one of its points and the ground; entries: of the law's parameters.

    raises: ValueError where the model lacks the point
    """
    added = _element(name, (point,), law, entries)
    return replace(model_with(model, (point,)), elements=(*model.elements, added))


def model_with(model: RigModel, points: tuple[str, ...]) -> RigModel:
    """raises: ValueError where the model lacks one of the points"""
    if missing := [point for point in points if point not in model.components.points]:
        raise ValueError(f"this effect acts on {' and '.join(points)}; the model has no {' and no '.join(missing)}")
    return model


def with_tip_elements(model: RigModel, name: str, law: ContactLaw, **entries: float | tuple[float, float]) -> RigModel:
    """The model with one element at each tip, between it and the ground.

    entries: of the law's parameters, of both or of the left and of the right one
    raises: ValueError where the model lacks one of the tips
    """
    model_with(model, TIPS)
    each = [{entry: float(np.broadcast_to(value, 2)[i]) for entry, value in entries.items()} for i in range(2)]
    added = tuple(_element(f"{name} at {tip}", (tip,), law, own) for tip, own in zip(TIPS, each, strict=True))
    return replace(model, elements=(*model.elements, *added))


def with_platform_element(model: RigModel, name: str, law: ContactLaw, **entries: float) -> RigModel:
    """The model with an element between the two platforms; entries: of the law's parameters.

    raises: ValueError where the model lacks one of the platforms
    """
    added = _element(name, PLATFORMS, BetweenPoints(law), entries)
    return replace(model_with(model, PLATFORMS), elements=(*model.elements, added))


def _element(name: str, points: tuple[str, ...], law: ContactLaw, entries: Mapping[str, float]) -> PointElement:
    parameters: Any = law.parameters(**{entry: jnp.full(1, value) for entry, value in entries.items()})
    return PointElement(name, points, law, parameters)


def modes_of(model: RigModel, component: str) -> Integers:
    """Numbers of its modes. raises: ValueError naming the components there are"""
    modes = np.flatnonzero(np.array(model.owner) == component)
    if not len(modes):
        there = ", ".join(dict.fromkeys(model.owner)) or "none"
        raise ValueError(f"the model has no component '{component}', which this effect changes; there are {there}")
    return modes


def with_modal_stiffness(model: RigModel, stiffness: Floats) -> RigModel:
    """The model with another modal stiffness (m, m) [rad^2/s^2], brought back to modes of its own.

    Modes that it does not couple stay as they are, whatever their frequencies: symmetries are kept.
    """
    omega_squared, X = np.diag(stiffness).copy(), np.eye(len(stiffness))
    for coupled in _coupled(stiffness):
        omega_squared[coupled], X[np.ix_(coupled, coupled)] = scipy.linalg.eigh(stiffness[np.ix_(coupled, coupled)])
    c = model.components
    changed = replace(
        c,
        omega_squared=omega_squared,
        phi=c.phi @ X,
        hysteretic=X.T @ c.hysteretic @ X,
        viscous=X.T @ c.viscous @ X,
    )
    return replace(model, components=changed, turned=model.rotation @ X)


def function_of(function: Callable[[Floats], Floats], matrix: Floats) -> Floats:
    """Of a symmetric matrix (m, m), that of each eigenvalue; what the matrix does not couple the result does not."""
    result = np.diag(function(np.diag(matrix)))
    for coupled in _coupled(matrix):
        values, X = scipy.linalg.eigh(matrix[np.ix_(coupled, coupled)])
        result[np.ix_(coupled, coupled)] = X * function(values) @ X.T
    return result


def _coupled(matrix: Floats) -> Iterator[Integers]:
    """Groups of more than one row that a symmetric matrix couples."""
    _, label = connected_components(csr_array(matrix), directed=False)
    yield from (np.flatnonzero(label == group) for group in np.flatnonzero(np.bincount(label) > 1))
