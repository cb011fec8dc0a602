"""What effects of the contact have in common."""

from typing import Any

import numpy as np
from numpy.typing import NDArray

from updamp.diagnosis.model.rig_model import RigModel
from updamp.hbm.contact.around import LawAround

Floats = NDArray[np.float64]


def entry(model: RigModel, name: str) -> Floats:
    """(n, ...) one entry of the contacts' parameters. raises: ValueError where the model has no contacts"""
    if model.contacts is None:
        raise ValueError("this effect is one of the contact, and the model has no contacts: leave the effect out")
    return np.array(getattr(model.contacts.parameters, name))


def put_around(model: RigModel, law: type[LawAround], **entries: Any) -> RigModel:
    """The model with `law` around the law of its contacts.

    entries: what it adds to the parameters: numbers, the same for all elements, or (n,)
    raises: ValueError where the model has no contacts, or such without friction
    """
    each = np.ones(len(entry(model, "mu")))
    assert model.contacts is not None, "entry has seen to that"
    added = {name: value * each for name, value in entries.items()}
    return model.with_contacts(law.put_around(model.contacts.law), **added)
