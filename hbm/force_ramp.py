"""The force as what varies along a branch, at a fixed frequency."""

from dataclasses import dataclass

import numpy as np

from updamp.hbm.system import Excitation


@dataclass(frozen=True)
class ForceRamp:
    """A harmonic point force on `row` at w [rad/s]. The parameter is the logarithm of the force [N]."""

    row: int
    w: float

    def at(self, parameter: float) -> tuple[float, Excitation]:
        return self.w, Excitation(self.row, _force(parameter))

    def rates(self, parameter: float) -> tuple[float, float]:
        return 0.0, _force(parameter)


def _force(parameter: float) -> float:
    """[N], limited: Newton's method may ask for more than a number holds"""
    return float(np.exp(np.clip(parameter, -100.0, 100.0)))
