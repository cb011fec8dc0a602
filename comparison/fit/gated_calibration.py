"""Calibration of a model together with its numerical error, which is asked for again where the calibration ends.

What finer numerics change depends on the parameters: with half the damping a resonance is twice as high, its contacts
slip farther, and harmonics and meshes change other things. The first calibration rests on what they change of the model
as given; with what they change of the calibrated one it is made again. (On a rig that jumps, 0.9 % and a factor of two
in the loss factor away from its rig file, the mean squared misfit was 14.5 and the normal stiffness 58 % off; they are
0.86 and 2 %.)
"""

from collections.abc import Callable, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from updamp.comparison.fit.calibration import Calibration, calibration
from updamp.comparison.fit.numerical_gate import Beginning, NumericalGate
from updamp.comparison.fit.observations import Plan
from updamp.comparison.fit.own_numerics import OwnNumericsOptions, until_it_stays
from updamp.comparison.prediction.parameters import Parametrisation
from updamp.comparison.prediction.predicted_branch import PredictedBranch

Floats = NDArray[np.float64]


@dataclass(frozen=True, eq=False)
class GatedCalibration:
    """calibration: with the numerical error where it ends
    given, before: the model where it began, with its numerical error there, and its branches, one a test of the fit
    """

    calibration: Calibration
    given: Parametrisation
    before: tuple[PredictedBranch, ...]


def gated_calibration(
    plain: Parametrisation,
    gate: NumericalGate,
    training: Sequence[int],
    start: Floats | None = None,
    progress: Callable[[str], None] = lambda _: None,
    options: OwnNumericsOptions = OwnNumericsOptions(),
) -> GatedCalibration:
    """plain: without numerical error; training: places of the gate's tests that the fit sees
    start: (p,) parameters to begin with, those of the rig file by default

    raises: BranchStoppedError where the model has no response at the beginning of a run
    """
    work = _Work(plain, gate, tuple(training), progress)
    progress("prediction")
    begin = work.at(np.zeros(len(plain)) if start is None else start)
    progress("calibration")
    found = until_it_stays(work.calibrated(begin), work.again, lambda c: (c.fit, c.rests_on(work.train)), options)
    return GatedCalibration(found, begin.parametrisation, begin.branches)


@dataclass(frozen=True, eq=False)
class _Work:
    """What all rounds have in common, as `gated_calibration` is given it."""

    plain: Parametrisation
    gate: NumericalGate
    training: tuple[int, ...]
    progress: Callable[[str], None]

    @property
    def train(self) -> Plan:
        return self.gate.plan.only(self.training)

    def at(self, u: Floats) -> Beginning:
        """u: (p,) of the model without numerical error, which begins as it is expected there"""
        return self.gate.beginning(self.plain, u, self.training)

    def calibrated(self, begin: Beginning) -> Calibration:
        of_model = begin.parametrisation, self.train, begin.branches, begin.u
        return calibration(*of_model, self.progress, self.gate.branches_of)

    def again(self, found: Calibration) -> Calibration:
        self.progress("numerical error of the calibrated model")
        return self.calibrated(self.at(found.fit.u[: len(self.plain)]))
