"""Whether all measured responses lag the model's by one angle, or by one time, as a delay, a filter or a multiplexer
makes them.

Calibration makes up for such an angle by frequency and loss, so that neither may be told before it is known. It is read
where these have no say: the model's points about its top against the run's about its own. Frequency and loss move a
top; at the top an oscillator's phase stays what it is. What fails otherwise turns the phase there by another angle at
each level (microslip of a beam's joint 1 degree at the lowest level, 9 at the highest), or at each sensor: one angle is
told only where all say the same, of two modes or of two levels at least, since one always agrees with itself; one time,
where it says the same of modes far from each other, and angles do not. One sensor that lags so by itself, the model and
the other sensors, has its phases left out: calibration would make up for half of what it lags by.
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray
from scipy.stats import chi2, norm

from updamp.comparison.comparison import Finding
from updamp.comparison.findings.direction import Sensor
from updamp.comparison.findings.peak_misfit import PLACED, without_peak
from updamp.comparison.findings.peak_reading import SweptBranch, reading_noise, swept_branch, tops_of_run
from updamp.comparison.findings.peak_sentences import ALIKE
from updamp.comparison.findings.several_peaks import several_peaks
from updamp.comparison.fit.failing_model import RISK
from updamp.comparison.fit.fit import Fit
from updamp.comparison.fit.matching import Matched
from updamp.comparison.fit.observations import Plan, noise_of
from updamp.comparison.prediction.predicted_branch import PredictedBranch
from updamp.comparison.prediction.run_condition import RunCondition
from updamp.effects.effect import Effect
from updamp.effects.phase_lag import EFFECT as PHASE_LAG
from updamp.effects.sensor_delay import EFFECT as SENSOR_DELAY

Floats = NDArray[np.float64]

PHASE = "phase"


@dataclass(frozen=True)
class PhaseLag:
    """size: by which measured responses lag the model's, the parameter of the effect: an angle [rad] of `phase_lag`, a
    time [s] of `sensor_delay`; significance: in standard deviations, signed"""

    effect: Effect
    size: float
    significance: float


@dataclass(frozen=True)
class _Read:
    """In one test. angles: (s,) lag at each sensor, as mean over the repeats [rad]; deviation: of their mean; turned:
    of that by the noise of the phases alone; angular: its frequency [rad/s]"""

    angles: Floats
    deviation: float
    turned: float
    angular: float

    def of(self, sensor: int) -> "_Read":
        """Of one alone, less well known than the mean of all"""
        angles = self.angles[[sensor]]
        return replace(self, angles=angles, deviation=self.deviation * float(np.sqrt(len(self.angles))))

    def against_others(self, sensor: int) -> "_Read":
        """Where the resonance is taken to be turns all sensors alike: it has no part in what one is off the others."""
        n = len(self.angles)
        angle = self.angles[sensor] - np.mean(np.delete(self.angles, sensor))
        return replace(self, angles=np.array([angle]), deviation=self.turned * n / float(np.sqrt(n - 1)))


@dataclass(frozen=True)
class SensorLag:
    """Of one sensor alone."""

    sensor: Sensor
    lag: PhaseLag


_Known = Sequence[tuple[RunCondition, _Read]]


def read_lags(fit: Fit, plan: Plan, branches: Sequence[PredictedBranch]) -> _Known:
    """Of the tests whose runs and whose model have smooth tops: where a sweep jumps, the phase there is where it
    happens to. branches: calibrated, one a condition"""
    without = {*without_peak(plan, branches), *(one.test for one in several_peaks(fit, plan, branches))}
    of_tests = ((c, _of_test(fit, i, branches[i])) for i, c in enumerate(plan.conditions) if i not in without)
    return [(condition, one) for condition, one in of_tests if one is not None]


def sensor_lags(known: _Known) -> tuple[SensorLag, ...]:
    """Of the sensors that lag both the model and the mean of the other ones, by as much as they lag those, as
    `phase_lag`"""
    found = []
    for sensor in dict.fromkeys(s for condition, _ in known for s in condition.sensors):
        seen = [(c, one, c.sensors.index(sensor)) for c, one in known if sensor in c.sensors and len(c.sensors) > 1]
        lag = phase_lag([(c, one.against_others(j)) for c, one, j in seen])
        if lag is not None and phase_lag([(c, one.of(j)) for c, one, j in seen]) is not None:
            found.append(SensorLag(sensor, lag))
    return tuple(found)


def without_phases(plan: Plan, lags: Sequence[SensorLag]) -> Plan:
    """As if these sensors had recorded none."""
    sensors = {one.sensor for one in lags}
    runs = []
    for o in plan.observations:
        own = o.own.copy()
        own[:, [2 + 2 * j for j, s in enumerate(plan.conditions[o.test].sensors) if s in sensors]] = np.inf
        runs.append(replace(o, own=own))
    conditions = [replace(c, noise=tuple(noise_of(runs, test).tolist())) for test, c in enumerate(plan.conditions)]
    return replace(plan, conditions=tuple(conditions), observations=tuple(runs))


def phase_lag(known: _Known) -> PhaseLag | None:
    """None where neither an angle nor a time stands out, or tests and sensors do not agree on it: all within a third of
    the mean; and where it is larger than a lag can be, such as of a force of the wrong sign, which is asked about."""
    if len({(condition.mode, condition.level) for condition, _ in known}) < 2:
        return None
    read = [one for _, one in known]
    if not all(PHASE_LAG.parameters[0].allows(float(np.mean(one.angles))) for one in read):
        return None
    told = [_agreed(PHASE_LAG, read, np.ones(len(read)))]
    if len({condition.mode for condition, _ in known}) >= SENSOR_DELAY.modes:
        told.append(_agreed(SENSOR_DELAY, read, np.array([one.angular for one in read])))
    agreed = [one for one in told if one is not None]
    if len(agreed) > 1 and agreed[0][1] - agreed[1][1] < chi2.isf(RISK, 1):
        agreed.pop()  # as good as the angle, which is told where no mode is far from the others
    return agreed[-1][0] if agreed else None


def _agreed(effect: Effect, read: Sequence[_Read], rates: Floats) -> tuple[PhaseLag, float] | None:
    """With what the tests leave of it, in squared standard deviations. rates: (tests,) of the angle by its size"""
    by_test = np.array([np.mean(one.angles) for one in read]) / rates
    each = np.concatenate([one.angles / rate for one, rate in zip(read, rates, strict=True)])
    deviations = np.array([one.deviation for one in read]) / rates
    mean = float(np.mean(by_test))
    if np.any(np.abs(each - mean) > ALIKE * abs(mean)):
        return None
    spread = float(np.std(by_test, ddof=1) / np.sqrt(len(read))) if len(read) > 1 else 0.0
    significance = mean / max(spread, float(np.linalg.norm(deviations)) / len(read))
    left = float(np.sum(((by_test - mean) / deviations) ** 2))
    return (PhaseLag(effect, mean, significance), left) if abs(significance) > norm.isf(RISK / 2) else None


def _of_test(fit: Fit, test: int, branch: PredictedBranch) -> _Read | None:
    """None where it is not read."""
    sensors = list(range(len(branch.condition.sensors)))
    matched = [m for m in fit.compared.matched if m.observations.test == test]
    if not sensors or not matched:
        return None
    swept = swept_branch(branch, [m.observations for m in matched], sensors[0])
    if not (swept.is_smooth(sensors) and all(swept.has_smooth_run(m, sensors) for m in matched)):
        return None
    lags = np.array([_lags(swept, m, sensors) for m in matched])
    if not np.isfinite(lags).all():
        return None
    deviations = _deviations(swept, matched, sensors, fit.compared.scatter.noise)
    angular = 2 * np.pi * float(np.exp(np.mean(swept.tops(sensors)[: len(sensors)])))
    return _Read(np.mean(lags, axis=0), *deviations, angular)


def _lags(swept: SweptBranch, m: Matched, sensors: Sequence[int]) -> Floats:
    """(s,) [rad], nan where the phase was not measured"""
    o = m.observations
    known = all(o.has_phase(j) for j in sensors)
    turned = swept.tops_as_measured(o, sensors).phase - tops_of_run(o, sensors).phase
    return np.angle(np.exp(1j * turned)) if known else np.full(len(sensors), np.nan)


def _deviations(
    swept: SweptBranch, matched: Sequence[Matched], sensors: Sequence[int], noise: float
) -> tuple[float, float]:
    """Of the mean over runs and sensors, and by the noise of the phases alone. A top that is misplaced by a half-width
    turns the phase by 1: each by its noise, the model's by as much as no top is placed better than."""
    s, of_runs, of_phases = len(sensors), [], []
    for m in matched:
        placed = noise * reading_noise(m.observations, sensors)[:s] / [swept.half_width(j) for j in sensors]
        turned = noise * m.observations.noise[:, [2 + 2 * j for j in sensors]].max(axis=0)
        of_runs.append(float(np.linalg.norm(np.hypot(placed, turned))) / s)
        of_phases.append(float(np.linalg.norm(turned)) / s)
    by_phases = float(np.linalg.norm(of_phases)) / len(matched)
    return float(np.hypot(np.linalg.norm(of_runs) / len(matched), PLACED)), by_phases


def fitted_lag(fit: Fit, effect: Effect) -> PhaseLag:
    """Of a fit that has the effect, its own size."""
    place = fit.parametrisation.columns(effect.name)
    size = fit.parametrisation.values(fit.u)[effect.name][effect.parameters[0].name]
    return PhaseLag(effect, size, float(fit.u[place][0] / fit.uncertainty[place][0]))


def lag_finding(lag: PhaseLag) -> Finding:
    text = (
        f"measured phases {_by(lag, '')}, or linear dynamics that the model lacks; what else is told is of the model "
        f"that {'lags' if lag.size > 0 else 'leads'} as much"
    )
    return Finding(text, "", None, PHASE, "", lag.size, lag.significance)


def sensor_lag_finding(one: SensorLag, names: Mapping[str, str]) -> Finding:
    """names: of the channels, by the model's points"""
    channel = names.get(one.sensor[0], one.sensor[0])
    text = (
        f"{channel}: its phases {_by(one.lag, ', and the other sensors do not')}; they are left out of calibration and "
        "of what else is told"
    )
    return Finding(text, "", None, PHASE, channel, one.lag.size, one.lag.significance)


def _by(lag: PhaseLag, unlike: str) -> str:
    """unlike: whom"""
    side = "lag" if lag.size > 0 else "lead"
    if lag.effect is PHASE_LAG:
        angle = f"{np.degrees(abs(lag.size)):.1f} degrees in all runs"
        cause = "a delay or a filter of the measurement" if lag.size > 0 else "a filter of the measurement"
        return f"{side} the model's by {angle}{unlike}, as {cause} makes them"
    time = f"{1e3 * abs(lag.size):.3g} ms in all runs{unlike}, more degrees the higher the frequency is"
    return f"{side} the model's by {time}, as a delay makes them"
