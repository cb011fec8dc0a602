"""Elements at the tips of both blades."""

from dataclasses import replace
from typing import Any

import jax.numpy as jnp

from updamp.diagnosis.model.rig_model import PointElement, RigModel
from updamp.hbm.contact.law import ContactLaw

TIPS = ("blade_left.tip.x", "blade_right.tip.x")


def checked(model: RigModel) -> RigModel:
    """raises: ValueError where the model lacks one of the tips"""
    if missing := [tip for tip in TIPS if tip not in model.components.points]:
        raise ValueError(f"this effect acts on {' and '.join(TIPS)}; the model has no {' and no '.join(missing)}")
    return model


def with_tip_elements(model: RigModel, name: str, law: ContactLaw, **entries: float) -> RigModel:
    """The model with one element at each tip, between it and the ground; entries: of the law's parameters.

    raises: ValueError where the model lacks one of the tips
    """
    checked(model)
    parameters: Any = law.parameters(**{entry: jnp.full(1, value) for entry, value in entries.items()})
    added = tuple(PointElement(f"{name} at {tip}", (tip,), law, parameters) for tip in TIPS)
    return replace(model, elements=(*model.elements, *added))
