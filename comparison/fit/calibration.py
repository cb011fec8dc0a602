"""The calibration that comparisons and diagnoses rest on: parameters, with the scatter that the repeats alone show.

A model that fails differs from the runs by more than they scatter by. What scatters is therefore read off the repeats,
and the sensors' noise off how rough a first fit leaves the runs; neither is learnt from the misfit. Without repeats
what differs from run to run is as it is stated. Single points that are unlike those next to them are left out, and all
is done again without them.
"""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace
from functools import partial

import numpy as np

from updamp.comparison.fit.compared import reweighed
from updamp.comparison.fit.fit import Fit, FitOptions, fit
from updamp.comparison.fit.fit_from_far import LAST, fit_from_far
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

    def rests_on(self, plan: Plan) -> Plan:
        """Of the runs that were given, and of others of the same measurement, what counts: without the points that
        were left out, and with the noise of each sensor."""
        return with_noise_of_sensors(without_odd(plan, self.odd), self.noise)


def calibration(
    parametrisation: Parametrisation,
    plan: Plan,
    branches: Sequence[PredictedBranch],
    progress: Callable[[str], None] = lambda _: None,
    branches_of: Branches = in_turn,
) -> Calibration:
    """branches: of the model as given, one a condition

    raises: BranchStoppedError where the model has no response at the beginning of a run
    """
    contacts = parametrisation.base.contacts is not None
    far, once_more = (partial(fit, options=_FIRST), FitOptions()) if contacts else (fit_from_far, LAST)
    start = np.zeros(len(parametrisation))
    first = far(parametrisation, plan, start, None, branches, progress=progress, branches_of=branches_of)
    noise = noise_of_each_sensor(first.compared.matched, plan)
    given, plan = plan, with_noise_of_sensors(plan, noise)
    beside = reweighed(parametrisation, plan, first.compared, replace(first.compared.scatter, noise=1.0))
    scatter, repeatability = scatter_of_repeats(replace(first, compared=beside), plan)
    found = fit(parametrisation, plan, first.u, scatter, first.compared.branches, once_more, progress, branches_of)
    if not (odd := odd_readings(found.compared.matched, plan)):
        return Calibration(found, noise, repeatability)
    progress(f"calibration without {len(odd)} odd points")
    again = calibration(parametrisation, without_odd(given, odd), branches, progress, branches_of)
    return replace(again, odd=tuple(sorted((*odd, *again.odd), key=lambda one: one.chance)))
