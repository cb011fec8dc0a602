"""What explanations of the same stated frequencies would do elsewhere, and which measurement tells them apart.

All at small force, where a prediction costs no curve: ratio of the tips, the damper's motion, the next modes, peak
heights, the frequency under another load, and the force from which on a sweep is no longer linear.
"""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace
from itertools import combinations

import numpy as np
from numpy.typing import NDArray

from updamp.diagnosis.next_measurement.candidate_runs import LOAD, RUN, SENSOR
from updamp.diagnosis.stated.low_force_modes import LowForceModes
from updamp.diagnosis.stated.stated_explanations import Explanation
from updamp.diagnosis.verdict import NextMeasurement
from updamp.effects.rig_model import RigModel
from updamp.hbm.problem.small_amplitude import SmallAmplitude
from updamp.model.small_amplitude import linear_up_to

Floats = NDArray[np.float64]

DECIDES = 3.0
_KEPT = 2  # measurements for each pair of explanations
_LOADS = {"half the load": 0.5, "twice the load": 2.0}
_STEP = 1e-3
# Relative standard deviations assumed of what would be measured.
_FREQUENCY, _RATIO, _MOTION, _PEAK, _ONSET = 1e-3, 0.02, 0.05, 0.1, 0.2
_LEFT, _RIGHT = "damper.corner_left.y", "damper.corner_right.y"


@dataclass(frozen=True)
class SurvivingExplanation:
    """An explanation, with what the stated values leave open of it: load_exponent: contact stiffness ~ load^exponent"""

    name: str
    explanation: Explanation
    load_exponent: float = 0.0

    def model(self, u: Floats, load: float = 1.0) -> RigModel:
        """load: on that of the measurement"""
        parametrisation = self.explanation.parametrisation
        plain = parametrisation.model(u)
        if load == 1.0 or plain.contacts is None:
            return plain
        loaded = replace(parametrisation, base=parametrisation.base.with_pull(load)).model(u)
        assert loaded.contacts is not None, "the plain one has contacts"
        entries = loaded.contacts.parameters
        if hasattr(entries, "mean_force"):  # the pressure at which the stiffness was stated: it does not change
            loaded = loaded.with_contacts(mean_force=plain.contacts.parameters.mean_force)
        if self.load_exponent:
            factor = load**self.load_exponent
            loaded = loaded.with_contacts(kt=entries.kt * factor, kn=entries.kn * factor)
        return loaded


@dataclass(frozen=True)
class MeasurableQuantity:
    """what: to be measured, in words; deviation: standard deviation of the measurement, of the value where relative
    read(model solved at the measurement's load, one at another load) -> value"""

    what: str
    unit: str
    deviation: float
    hours: float
    load: float
    read: Callable[["Solved"], float]


@dataclass(frozen=True, eq=False)
class Solved:
    """A model's modes at small force. modes: name -> solution and number of the mode in it"""

    model: RigModel
    modes: Mapping[str, tuple[SmallAmplitude, int]]
    component: str

    def frequency(self, mode: str) -> float:
        found, i = self.modes[mode]
        return float(found.frequencies[i])

    def ratio_of_tips(self, mode: str) -> float:
        found, i = self.modes[mode]
        return abs(found.at("blade_left.tip.x", i) / found.at("blade_right.tip.x", i))

    def damper(self, mode: str) -> float:
        """Vertical motion of one bottom corner over that of the tip."""
        found, i = self.modes[mode]
        tip = found.at(f"{self.component}.tip.x", i)
        return max(abs(found.at(corner, i) / tip) for corner in (_LEFT, _RIGHT))

    def peak(self, mode: str) -> float:
        found, i = self.modes[mode]
        return found.peak(f"{self.component}.tip.x", self.model.excitation, i)

    def onset(self, mode: str) -> float:
        return linear_up_to(self.model, *self.modes[mode])


@dataclass(frozen=True, eq=False)
class StatedPrediction:
    """value: (n_quantities,); deviation: (n_quantities,) from what the stated values leave open"""

    survivor: SurvivingExplanation
    value: Floats
    deviation: Floats


def quantities(modes: LowForceModes) -> tuple[MeasurableQuantity, ...]:
    """Those that a rig of two blades and a damper offers, mode by mode."""
    found = []
    study = tuple(modes.windows)
    for m in study:
        found += [
            MeasurableQuantity(f"{m}: left tip over right tip", "", _RATIO, RUN, 1.0, _reader(Solved.ratio_of_tips, m)),
            MeasurableQuantity(
                f"{m}: damper's corner over tip", "", _MOTION, RUN + SENSOR, 1.0, _reader(Solved.damper, m)
            ),
            MeasurableQuantity(
                f"{m}: force where contacts begin to slip", "N", _ONSET, 4 * RUN, 1.0, _reader(Solved.onset, m)
            ),
        ]
        for words, load in _LOADS.items():
            what = f"{m}: resonance at {words}"
            found.append(MeasurableQuantity(what, "Hz", _FREQUENCY, RUN + LOAD, load, _reader(Solved.frequency, m)))
    for m in modes.others:
        found.append(MeasurableQuantity(f"{m}: resonance", "Hz", _FREQUENCY, RUN, 1.0, _reader(Solved.frequency, m)))
    for m in study[1:]:
        read = _ratio_of_peaks(m, study[0])
        found.append(
            MeasurableQuantity(f"low-force peak of {m} over that of {study[0]}", "", _PEAK, 2 * RUN, 1.0, read)
        )
    return tuple(found)


def _reader(method: Callable[[Solved, str], float], mode: str) -> Callable[[Solved], float]:
    return lambda solved: method(solved, mode)


def _ratio_of_peaks(mode: str, other: str) -> Callable[[Solved], float]:
    return lambda solved: solved.peak(mode) / solved.peak(other)


def predict_quantities(
    survivors: Sequence[SurvivingExplanation], modes: LowForceModes, wanted: Sequence[MeasurableQuantity]
) -> tuple[StatedPrediction, ...]:
    """Of each explanation, with what its parameters' uncertainty makes of it to first order."""
    return tuple(_predicted(survivor, modes, wanted) for survivor in survivors)


def _predicted(
    survivor: SurvivingExplanation, modes: LowForceModes, wanted: Sequence[MeasurableQuantity]
) -> StatedPrediction:
    e = survivor.explanation
    lower, upper = e.parametrisation.lower, e.parametrisation.upper
    value, slopes = _values(survivor, e.u, modes, wanted), np.zeros((len(wanted), len(e.u)))
    for i in range(len(e.u)):
        above, below = e.u.copy(), e.u.copy()
        above[i], below[i] = min(e.u[i] + _STEP, upper[i]), max(e.u[i] - _STEP, lower[i])
        change = _values(survivor, above, modes, wanted) - _values(survivor, below, modes, wanted)
        slopes[:, i] = change / (above[i] - below[i])
    deviation = np.sqrt(np.einsum("qi,ij,qj->q", slopes, e.covariance, slopes))
    for u in e.as_good:
        # two standard deviations off at most
        deviation = np.maximum(deviation, np.abs(_values(survivor, u, modes, wanted) - value) / 2)
    return StatedPrediction(survivor, value, deviation)


def _values(
    survivor: SurvivingExplanation, u: Floats, modes: LowForceModes, wanted: Sequence[MeasurableQuantity]
) -> Floats:
    solved = {}
    for load in dict.fromkeys(q.load for q in wanted):
        model = survivor.model(u, load)
        solved[load] = Solved(model, modes.solved(model, tuple(modes.shapes)), modes.component)
    return np.array([q.read(solved[q.load]) for q in wanted])


def separating(
    predictions: Sequence[StatedPrediction], wanted: Sequence[MeasurableQuantity]
) -> tuple[NextMeasurement, ...]:
    """For each pair of explanations the measurements that separate them best per hour; the best one where none does."""
    found = []
    for a, b in combinations(predictions, 2):
        measurements = [_measurement(a, b, i, q) for i, q in enumerate(wanted)]
        deciding = sorted((m for m in measurements if m.separation >= DECIDES), key=_rate, reverse=True)
        found += deciding[:_KEPT] or [max(measurements, key=lambda m: m.separation)]
    return tuple(sorted(found, key=_rate, reverse=True))


def _rate(measurement: NextMeasurement) -> float:
    return measurement.separation / measurement.hours


def _measurement(a: StatedPrediction, b: StatedPrediction, i: int, q: MeasurableQuantity) -> NextMeasurement:
    one, other = float(a.value[i]), float(b.value[i])
    noise = q.deviation * max(abs(one), abs(other))
    apart = abs(one - other) / max(float(np.sqrt(noise**2 + a.deviation[i] ** 2 + b.deviation[i] ** 2)), 1e-300)
    unit = f" {q.unit}" if q.unit else ""
    hint = "" if apart >= DECIDES else " (that is a hint at most)"
    names = (a.survivor.name, b.survivor.name)
    sentence = f"{q.what}: {one:.4g}{unit} with {names[0]}, {other:.4g}{unit} with {names[1]}{hint}"
    return NextMeasurement(sentence, names, apart, q.hours)
