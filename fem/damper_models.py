"""How the damper is modelled: choices that a rig file can name."""

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from types import MappingProxyType

import numpy as np
from numpy.typing import NDArray

from updamp.fem.contact_rest import StaticContact
from updamp.fem.lumped_damper import lumped_damper
from updamp.fem.reduced_model import ReducedModel
from updamp.geometry.contact_elements import ContactElements


@dataclass(frozen=True)
class DamperModel:
    """apply: from the reduced model of the finite elements and its rest state to those that vibrate
    element_of_patch: (n_patches,) number of the contact element that each patch of the mesh belongs to
    """

    apply: Callable[[ReducedModel, StaticContact], tuple[ReducedModel, StaticContact]]
    element_of_patch: Callable[[ContactElements], NDArray[np.int64]]


DAMPER_MODELS: Mapping[str, DamperModel] = MappingProxyType(
    {
        "elastic": DamperModel(
            apply=lambda reduced, rest: (reduced, rest),
            element_of_patch=lambda contacts: np.arange(len(contacts)),
        ),
        "lumped": DamperModel(
            apply=lumped_damper,
            element_of_patch=lambda contacts: contacts.face,
        ),
    }
)
