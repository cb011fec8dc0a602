"""The calibration that comparisons and diagnoses rest on: parameters, with the scatter that the repeats alone show.

A model that fails differs from the runs by more than they scatter by. What scatters is therefore read off the repeats,
and the sensors' noise off how rough a first fit leaves the runs; neither is learnt from the misfit. Without repeats
what differs from run to run is as it is stated.

Single points that are unlike those next to them are left out. One alone, a hundred deviations off, may lead a fit to
where it is one of many. So those that are odd beside the model that it begins with are left out of a first calibration,
and counted again where they are not odd beside its outcome; those that are odd beside that are left out too, and all
is done again.
"""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace
from functools import partial

import numpy as np
from numpy.typing import NDArray

from updamp.comparison.fit.compared import compare_at, reweighed
from updamp.comparison.fit.fit import Fit, FitOptions, fit
from updamp.comparison.fit.fit_from_far import LAST, fit_from_far
from updamp.comparison.fit.fit_round import compared_at_start, prior_scatter
from updamp.comparison.fit.noise_by_amplitude import (
    Sensor,
    SensorNoise,
    noise_of_each_sensor,
    with_noise_of_sensors,
)
from updamp.comparison.fit.observations import Plan
from updamp.comparison.fit.odd_readings import OddReading, odd_readings, without_odd
from updamp.comparison.fit.repeat_scatter import scatter_of_repeats
from updamp.comparison.prediction.branch_tasks import Branches, in_turn
from updamp.comparison.prediction.parameters import Parametrisation
from updamp.comparison.prediction.predicted_branch import PredictedBranch

Floats = NDArray[np.float64]

# Of the calibration that the scatter of repeats is learnt beside; the one after it goes on until it settles.
_FIRST = FitOptions(rounds=4, retraced=False)


@dataclass(frozen=True, eq=False)
class Calibration:
    """fit: with the scatter that the repeats alone show; noise: of each sensor, where it is not stated
    repeatability: weighted residual RMS of what differs between the repeats
    odd: points that were left out, the least likely first"""

    fit: Fit
    noise: Mapping[Sensor, SensorNoise]
    repeatability: float
    odd: tuple[OddReading, ...] = ()

    def also_without(self, odd: Sequence[OddReading]) -> "Calibration":
        """Of points that had been left out before."""
        return replace(self, odd=tuple(sorted((*odd, *self.odd), key=lambda one: one.chance)))

    def rests_on(self, plan: Plan) -> Plan:
        """Of the runs that were given, and of others of the same measurement, what counts: without the points that
        were left out, and with the noise of each sensor."""
        return with_noise_of_sensors(without_odd(plan, self.odd), self.noise)


def calibration(
    parametrisation: Parametrisation,
    plan: Plan,
    branches: Sequence[PredictedBranch],
    start: Floats,
    progress: Callable[[str], None] = lambda _: None,
    branches_of: Branches = in_turn,
) -> Calibration:
    """start: (p,) parameters to begin with; branches: there, one a condition

    raises: BranchStoppedError where the model has no response at the beginning of a run
    """
    work = _Work(parametrisation, branches, start, progress, branches_of)
    suspects = work.odd_beside_start(plan)
    found = work.calibrated(without_odd(plan, suspects))
    if not suspects:
        return found
    odd = {one.point for one in work.odd_beside(found, plan)}
    confirmed = tuple(one for one in suspects if one.point in odd)
    if len(confirmed) < len(suspects):
        found = work.calibrated(without_odd(plan, confirmed))
    return found.also_without(confirmed)


@dataclass(frozen=True, eq=False)
class _Work:
    """What all calibrations of one model begin with. branches: at the start"""

    parametrisation: Parametrisation
    branches: Sequence[PredictedBranch]
    start: Floats
    progress: Callable[[str], None]
    branches_of: Branches

    def calibrated(self, given: Plan) -> Calibration:
        """Of all points but those that are odd beside the outcome."""
        p, progress, branches_of = self.parametrisation, self.progress, self.branches_of
        contacts = p.base.contacts is not None
        far, once_more = (partial(fit, options=_FIRST), FitOptions()) if contacts else (fit_from_far, LAST)
        first = far(p, given, self.start, None, self.branches, progress=progress, branches_of=branches_of)
        noise = noise_of_each_sensor(first.compared.matched, given)
        plan = with_noise_of_sensors(given, noise)
        beside = reweighed(p, plan, first.compared, replace(first.compared.scatter, noise=1.0))
        scatter, repeatability = scatter_of_repeats(replace(first, compared=beside), plan)
        found = fit(p, plan, first.u, scatter, first.compared.branches, once_more, progress, branches_of)
        if not (odd := odd_readings(found.compared, plan)):
            return Calibration(found, noise, repeatability)
        progress(f"calibration without {len(odd)} odd points")
        return self.calibrated(without_odd(given, odd)).also_without(odd)

    def odd_beside_start(self, plan: Plan) -> tuple[OddReading, ...]:
        p = self.parametrisation
        return odd_readings(compared_at_start(p, self.start, plan, self.branches, prior_scatter(p, plan)), plan)

    def odd_beside(self, found: Calibration, plan: Plan) -> tuple[OddReading, ...]:
        """Of points that it was not calibrated with too."""
        counting, c = found.rests_on(plan), found.fit.compared
        return odd_readings(compare_at(self.parametrisation, c.u, counting, c.branches, c.scatter), counting)
