"""The same pressure everywhere: eq. (5) of Pesaresi et al. 2017."""

import numpy as np

from updamp.fem.contact_face import prescribed_rest
from updamp.fem.contact_rest import StaticContact
from updamp.fem.reduced_model import ReducedModel
from updamp.rig import Rig


def uniform(reduced: ReducedModel, rig: Rig) -> StaticContact:
    """sigma0 = CF / (2 A (cos(alpha) + mu sin(alpha))), N0 = sigma0 times the area of the patch."""
    return prescribed_rest(reduced.contacts, np.ones(len(reduced.contacts)), rig)
