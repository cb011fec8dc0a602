"""The force loop of one contact: its motion and its forces over a period."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from updamp.effects.rig_model import RigModel
from updamp.hbm.newton.observe import ContactState, force_loop

Floats = NDArray[np.float64]


@dataclass(frozen=True, eq=False)
class ForceLoop:
    """motion: (n_time, 3) relative displacement along (t1, t2, n) [m]; force: (n_time, 3) less that at rest [N]
    preload: normal force at rest [N]; mu: friction coefficient; state: over the period"""

    name: str
    motion: Floats
    force: Floats
    preload: float
    mu: float
    state: ContactState

    @property
    def normal(self) -> Floats:
        """(n_time,) the whole normal force, pressing [N]"""
        return self.preload + self.force[:, 2]

    def first_harmonic(self, direction: int) -> complex:
        """Of the force along t1, t2 or n [N]."""
        spectrum = np.fft.rfft(self.force[:, direction])
        return complex(2 * spectrum[1] / len(self.force))


def loop_of_contact(
    model: RigModel, displacement: Floats, w: float, element: int, name: str, state: ContactState
) -> ForceLoop:
    """displacement: (n_relative, n_coefficients) in the harmonics of the model's system [m]; w: [rad/s]
    element: number of the contact element. raises: ValueError for a model without contacts"""
    if model.contacts is None:
        raise ValueError("a model without contacts has no force loops")
    motion, force = force_loop(model.system, displacement, w, element)
    parameters = model.contacts.parameters
    preload, mu = float(np.asarray(parameters.n0)[element]), float(np.asarray(parameters.mu)[element])
    return ForceLoop(name, motion, force, preload, mu, state)
