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
from updamp.comparison.fit.failing_model import RISK
from updamp.comparison.fit.fit import Fit
from updamp.comparison.fit.lack_of_fit import lack_of_fit
from updamp.comparison.fit.numerical_gate import NumericalGate, largest_change, starting_at
from updamp.comparison.fit.observations import Plan
from updamp.comparison.prediction.parameters import Parametrisation
from updamp.comparison.prediction.predicted_branch import PredictedBranch
from updamp.hbm.continuation.continuation import BranchStoppedError

Floats = NDArray[np.float64]


@dataclass(frozen=True)
class GateOptions:
    """again: how often at most what finer numerics change is asked for where a calibration ends
    moved: in their stated deviations, what parameters move by from one time to the next where that is enough: numerical
        error and calibration then belong to each other
    """

    again: int = 4
    moved: float = 0.5


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
    options: GateOptions = GateOptions(),
) -> GatedCalibration:
    """plain: without numerical error; training: places of the gate's tests that the fit sees
    start: (p,) parameters to begin with, those of the rig file by default

    raises: BranchStoppedError where the model has no response at the beginning of a run
    """
    work = _Work(plain, gate, tuple(training), progress)
    progress("prediction")
    begin = work.at(np.zeros(len(plain)) if start is None else start)
    progress("calibration")
    found = work.calibrated(begin)
    if largest_change(begin.parametrisation.numerics, gate.plan) > 1:  # else one of a share of it is nothing
        found = work.with_own_numerics(found, options)
    return GatedCalibration(found, begin.parametrisation, begin.branches)


@dataclass(frozen=True, eq=False)
class _Begin:
    """Where a calibration begins. parametrisation: with the numerical error there; u: (p,); branches: at u"""

    parametrisation: Parametrisation
    u: Floats
    branches: tuple[PredictedBranch, ...]


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
        found, branches = self.gate.at(self.plain, u)
        begin, seen = padded(u, len(found)), [branches[i] for i in self.training]
        return _Begin(found, begin, starting_at(found, begin, self.train, seen, self.gate.branches_of))

    def calibrated(self, begin: _Begin) -> Calibration:
        of_model = begin.parametrisation, self.train, begin.branches, begin.u
        return calibration(*of_model, self.progress, self.gate.branches_of)

    def with_own_numerics(self, found: Calibration, options: GateOptions) -> Calibration:
        """Until the parameters stay where the error was asked for, whatever that does to a misfit within the scatter:
        where a run of few points ends beside a jump, an error asked for elsewhere makes parameters up that the data
        seem to tell well. Of a model that fails, as long as it fails less."""
        for _ in range(options.again):
            self.progress("numerical error of the calibrated model")
            try:
                again = self.calibrated(self.at(found.fit.u[: len(self.plain)]))
            except BranchStoppedError:  # of a finer model, far from where it was: what was found before stands
                return found
            if _misfit(again) >= _misfit(found) and lack_of_fit(again.fit, again.rests_on(self.train)) < RISK:
                return found
            before, found = found, again
            if self._moved(before.fit, again.fit) <= options.moved:
                break
        return found

    def _moved(self, before: Fit, after: Fit) -> float:
        """The farthest of the model's parameters, in the smaller one of its two deviations."""
        n = len(self.plain)
        deviations = np.minimum(before.uncertainty[:n], after.uncertainty[:n])
        return float(np.max(np.abs(after.u[:n] - before.u[:n]) / deviations))


def _misfit(found: Calibration) -> float:
    return found.fit.compared.mean_squared_misfit
