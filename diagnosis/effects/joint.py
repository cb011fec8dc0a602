"""What effects of a bolted joint have in common.

They are for models whose modes were identified in a test. The joint is not a point of such a model: its motion goes
with that of the mode, so an element at the excitation point stands for it, and its parameters are those seen from
there. With several modes, each of which moves the joint otherwise, they are not the joint's own.
"""

from dataclasses import replace
from typing import Any

import jax.numpy as jnp

from updamp.diagnosis.model.rig_model import PointElement, RigModel
from updamp.hbm.contact.law import ContactLaw

# Fewest samples of a period for laws that are not smooth.
_SAMPLES = 128


def checked(model: RigModel) -> RigModel:
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


def with_joint_element(model: RigModel, name: str, law: ContactLaw, **entries: float) -> RigModel:
    """The model with an element between its excitation point and the ground; entries: of the law's parameters.

    raises: ValueError where the model is not one of identified modes without contacts
    """
    parameters: Any = law.parameters(**{entry: jnp.full(1, value) for entry, value in entries.items()})
    added = PointElement(name, (checked(model).excitation,), law, parameters)
    return replace(model, elements=(*model.elements, added), time_samples=max(model.time_samples, _SAMPLES))
