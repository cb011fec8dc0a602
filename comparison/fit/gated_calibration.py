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
from updamp.comparison.fit.compared import padded
from updamp.comparison.fit.fit import Fit
from updamp.comparison.fit.numerical_gate import Asked, NumericalGate, starting_at
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
    found = until_it_stays(work.calibrated(begin), work.again, work.fit_of, options)
    return GatedCalibration(found.calibration, begin.asked.parametrisation, begin.branches)


@dataclass(frozen=True, eq=False)
class _Begin:
    """Where a calibration begins. u: (p,); branches: at u, with the numerical error there, one a test of the fit"""

    asked: Asked
    u: Floats
    branches: tuple[PredictedBranch, ...]


@dataclass(frozen=True, eq=False)
class _Calibrated:
    calibration: Calibration
    begin: _Begin


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

    def at(self, u: Floats) -> _Begin:
        """u: (p,) of the model without numerical error, which begins as it is expected there"""
        asked = self.gate.at(self.plain, u)
        found = asked.parametrisation
        begin, seen = padded(u, len(found)), [asked.branches[i] for i in self.training]
        return _Begin(asked, begin, starting_at(found, begin, self.train, seen, self.gate.branches_of))

    def calibrated(self, begin: _Begin) -> _Calibrated:
        of_model = begin.asked.parametrisation, self.train, begin.branches, begin.u
        return _Calibrated(calibration(*of_model, self.progress, self.gate.branches_of), begin)

    def again(self, last: _Calibrated) -> _Calibrated:
        self.progress("numerical error of the calibrated model")
        return self.calibrated(self.at(last.calibration.fit.u[: len(self.plain)]))

    def fit_of(self, found: _Calibrated) -> tuple[Fit, Plan]:
        return found.calibration.fit, found.calibration.rests_on(self.train)
