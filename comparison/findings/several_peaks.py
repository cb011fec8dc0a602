"""Runs that have more peaks than the model: a resonance that it lacks, or one that two bodies share.

A peak is one that chance does not make (`tops.py`). One or two points that stand beside their neighbours, or fall short
of them, make none: peaks are those of a running median of five points. Where a test has more of them than the model,
what is read off its highest top is of another resonance, and is not read.
"""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.ndimage import median_filter

from updamp.comparison.comparison import Finding
from updamp.comparison.findings.kinds import Frequency
from updamp.comparison.findings.tops import tops
from updamp.comparison.findings.words import levels_of
from updamp.comparison.fit.fit import Fit
from updamp.comparison.fit.observations import Observations, Plan
from updamp.comparison.prediction.predicted_branch import PredictedBranch

Floats = NDArray[np.float64]
_MEDIAN = 5  # points, of which two may be anything


@dataclass(frozen=True)
class SeveralPeaks:
    """test: place in the plan; measured, model: frequencies of the peaks [Hz]"""

    test: int
    measured: tuple[float, ...]
    model: tuple[float, ...]


def several_peaks(fit: Fit, plan: Plan, branches: Sequence[PredictedBranch]) -> tuple[SeveralPeaks, ...]:
    """The tests all of whose runs have more peaks than the model at one of their sensors.

    branches: calibrated, one a condition
    """
    noise = fit.compared.scatter.noise
    found = []
    for test, branch in enumerate(branches):
        runs = [o for o in plan.observations if o.test == test]
        of_sensors = (_of_sensor(test, j, runs, branch, noise) for j in range(len(branch.condition.sensors)))
        found += [one for one in of_sensors if one is not None][:1]
    return tuple(found)


def several_peaks_findings(found: Sequence[SeveralPeaks], plan: Plan) -> tuple[Finding, ...]:
    """A sentence for each mode, with the frequencies of its lowest level."""
    sentences = []
    for mode in dict.fromkeys(plan.conditions[one.test].mode for one in found):
        tests = sorted((o for o in found if plan.conditions[o.test].mode == mode), key=lambda o: _level(plan, o))
        first = tests[0]
        of_model = f"{_number(first.model)}, at {_and(first.model)}" if first.model else "none"
        text = (
            f"{mode}: {_number(first.measured)} peaks were measured, at {_and(first.measured)}, where the model has "
            f"{of_model} ({levels_of([o.test for o in tests], plan)})"
        )
        sentences.append(Finding(text, mode, _level(plan, first), Frequency.quantity, "", float("nan"), float("nan")))
    return tuple(sentences)


def _level(plan: Plan, one: SeveralPeaks) -> float:
    return plan.conditions[one.test].level


def _number(frequencies: Sequence[float]) -> str:
    return {1: "one", 2: "two", 3: "three"}.get(len(frequencies), str(len(frequencies)))


def _and(frequencies: Sequence[float]) -> str:
    *others, last = (f"{f:.5g}" for f in frequencies)
    return f"{', '.join(others)} and {last} Hz" if others else f"{last} Hz"


def _of_sensor(
    test: int, sensor: int, runs: Sequence[Observations], branch: PredictedBranch, noise: float
) -> SeveralPeaks | None:
    place = 1 + 2 * sensor
    each = [_peaks(o.frequency, o.observed[:, place] - o.log_force, o.noise[:, place] * noise) for o in runs]
    least = min((len(frequencies) for frequencies, _ in each), default=0)
    if least < 2:
        return None
    lesser = min(prominence for _, prominence in each)
    of_model = _peaks_of_model(branch, sensor, lesser)
    if least <= len(of_model):
        return None
    same = [frequencies for frequencies, _ in each if len(frequencies) == least]
    return SeveralPeaks(test, tuple(np.median(same, axis=0).tolist()), of_model)


def _peaks(frequency: Floats, log_size: Floats, deviation: Floats) -> tuple[list[float], float]:
    """Frequencies of the peaks that chance does not make, ascending, and the prominence of the least of them."""
    n, given, log_size = len(log_size), log_size, median_filter(log_size, _MEDIAN, mode="nearest")
    # Of two tops of one height, as rounded numbers have them, the dip between them would be that of neither.
    unequal = log_size + np.finfo(float).eps * (1 + np.abs(log_size).max(initial=0.0)) * np.arange(n)
    found, prominences = tops(unequal, deviation)
    # a median moves a top by a point or two
    near = [np.arange(max(top - _MEDIAN // 2, 0), min(top + _MEDIAN // 2 + 1, n)) for top in found]
    highest = [int(places[np.argmax(given[places])]) for places in near]
    return sorted(frequency[highest].tolist()), float(min(prominences, default=np.inf))


def _peaks_of_model(branch: PredictedBranch, sensor: int, prominence: float) -> tuple[float, ...]:
    """Of what a sweep sees of it, those as prominent as the least that was measured."""
    low, high = branch.condition.window
    seen = branch.visited & (branch.frequency >= low) & (branch.frequency <= high)
    found, each = tops(np.log(np.abs(branch.amplitude[seen, sensor])))
    return tuple(sorted(branch.frequency[seen][found[each >= prominence]].tolist()))
