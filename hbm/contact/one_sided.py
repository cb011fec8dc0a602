"""Laws that push one way alone."""

from typing import Any, Protocol, runtime_checkable

import numpy as np
from numpy.typing import NDArray

from updamp.hbm.contact.law import ContactLaw


@runtime_checkable
class OneSidedLaw(ContactLaw, Protocol):
    """A law that tells which of its elements, at rest without a load, push one way alone: what they do moves the mean
    position, which harmonic 0 is."""

    def one_sided(self, parameters: Any) -> NDArray[np.bool_]:
        """(n_elements,)"""
        ...
