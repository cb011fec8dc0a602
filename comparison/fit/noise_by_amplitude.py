"""The noise of each sensor, a share of the amplitude and a part that is there at any amplitude, read off what a model
leaves of runs whose noise is not stated.

A sensor and its amplifier have a floor, one for all where the range stays, a share of a run's largest amplitude where
the range is set for each run. What is small beside it, the lowest levels, the flanks of a resonance, the neighbourhood
of an antiresonance, is noisier in proportion, and one number for a sensor would count that as a misfit, and leave the
peaks less sure than they are.

How rough a run is tells its noise only where it has many points: third differences of a resonance in fifteen points are
as large as its noise, which is then taken for twice what it is, and what a model lacks goes unseen. A model that is
nearly right takes the resonance off. What it gets wrong is smooth, and third differences take that off in turn.
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from functools import partial

import numpy as np
from numpy.typing import NDArray
from scipy.optimize import minimize
from scipy.stats import norm

from updamp.comparison.fit.at_sensors import columns_at_sensors, recorded
from updamp.comparison.fit.matching import Matched
from updamp.comparison.fit.observations import Observations, Plan, noise_of
from updamp.comparison.fit.roughness import SHARES, deviation_of, known_to, third_differences

Floats = NDArray[np.float64]
# Point of the model and harmonic.
Sensor = tuple[str, int]
# Scale of a Cauchy distribution fitted to normal deviates, over their standard deviation c: the expectation of
# c^2 / (c^2 + x^2), sqrt(pi / 2) c exp(c^2 / 2) erfc(c / sqrt(2)), is to be a half. It is as little drawn up by a few
# places that the model gets wrong as the median is.
_CAUCHY = 0.6120031809624807
_OUTLYING = 3.0  # standard deviations
# Range of the two parts, as factors on what one of them alone would be.
_LOWEST, _HIGHEST = 1e-3, 10.0


@dataclass(frozen=True)
class SensorNoise:
    """Standard deviations of an amplitude, and of a phase times it. share: of the amplitude [-]
    floor: beside it, by mode [m], since a sensor of velocity or acceleration has another one at another frequency
    of_range: beside both, of the largest amplitude of the run [-]"""

    share: float
    floor: Mapping[str, float]
    of_range: float = 0.0

    def of(self, amplitude: Floats, mode: str) -> Floats:
        """(n,) relative to the amplitudes (n,) of a run [m]"""
        at_any = np.hypot(self.floor[mode], self.of_range * amplitude.max())
        return np.hypot(self.share, at_any / amplitude)

    def times(self, factor: float) -> "SensorNoise":
        floor = {mode: factor * floor for mode, floor in self.floor.items()}
        return SensorNoise(factor * self.share, floor, factor * self.of_range)


def noise_of_each_sensor(matched: Sequence[Matched], plan: Plan) -> dict[Sensor, SensorNoise]:
    """None of sensors whose runs are too short to tell, and none at all where the noise is stated."""
    if not plan.noise_read:
        return {}
    told: dict[Sensor, list[_Rough]] = {}
    for m in matched:
        condition, own = plan.conditions[m.observations.test], m.observations
        for place, (left, seen) in zip(recorded(m), columns_at_sensors(m), strict=True):
            sensor = (place - 1) // 2
            differences = third_differences(left * own.noise[:, place])
            rough = _Rough(condition.mode, _amplitude(own, sensor), seen, differences)
            told.setdefault(condition.sensors[sensor], []).append(rough)
    long_enough = {sensor: [r for r in each if len(r.differences)] for sensor, each in told.items()}
    return {sensor: _fitted(each) for sensor, each in long_enough.items() if each}


def with_noise_of_sensors(plan: Plan, noise: Mapping[Sensor, SensorNoise]) -> Plan:
    """The same runs with the noise of each sensor, no larger on the whole than they had, as well as that is known (two
    deviations), since a model that fails may leave rougher runs than there were; as it is where nothing is known of a
    sensor at a mode."""
    runs = list(plan.observations)
    for sensor, own in noise.items():
        places = [
            (i, c.sensors.index(sensor), c.mode)
            for i, c in ((i, plan.conditions[o.test]) for i, o in enumerate(runs))
            if sensor in c.sensors and c.mode in own.floor
        ]
        new = [own.of(_amplitude(runs[i], j), mode) for i, j, mode in places]
        before = np.concatenate([runs[i].own[:, 1 + 2 * j] for i, j, _ in places])
        most = float(np.median(before)) * np.exp(2 * known_to(len(before)))
        factor = min(1.0, most / float(np.median(np.concatenate(new))))
        for (i, j, _), each in zip(places, new, strict=True):
            runs[i] = _with_noise(runs[i], j, factor * each)
    conditions = [replace(c, noise=tuple(noise_of(runs, test).tolist())) for test, c in enumerate(plan.conditions)]
    return replace(plan, conditions=tuple(conditions), observations=tuple(runs))


@dataclass(frozen=True, eq=False)
class _Rough:
    """One run at one sensor. amplitude: (n,) [m]; seen: (n,) share of the noise's variance that is seen across the
    branch; differences: (n - 3,) of what is left of its amplitude or phase"""

    mode: str
    amplitude: Floats
    seen: Floats
    differences: Floats

    def deviations(self, noise: SensorNoise) -> Floats:
        """(n - 3,) standard deviations of the differences"""
        squared = self.seen * noise.of(self.amplitude, self.mode) ** 2
        return np.sqrt(np.convolve(squared, SHARES, "valid"))


def _fitted(runs: Sequence[_Rough]) -> SensorNoise:
    """The likeliest three parts, from where nearly all of it is one of them."""
    modes = tuple(dict.fromkeys(r.mode for r in runs))
    typical = {m: float(np.median(np.concatenate([r.amplitude for r in runs if r.mode == m]))) for m in modes}
    of_largest = float(np.median(np.concatenate([r.amplitude / r.amplitude.max() for r in runs])))
    alone = max(deviation_of(np.concatenate([r.differences for r in runs])), 1e-6)
    units = alone * np.array([1.0, of_largest, *typical.values()])
    unlikely = partial(_unlikely, runs, modes, units)
    bounds = [(np.log(_LOWEST), np.log(_HIGHEST))] * len(units)
    kinds = np.minimum(np.arange(len(units)), 2)  # share, range, floors
    ends = [np.log(np.where(kinds == most, 0.9, 0.1)) for most in range(3)]
    best = min((minimize(unlikely, end, method="L-BFGS-B", bounds=bounds) for end in ends), key=lambda r: float(r.fun))
    found = _of_parts(units * np.exp(best.x), modes)
    return found.times(_spread(np.concatenate([r.differences / r.deviations(found) for r in runs])))


def _of_parts(parts: Floats, modes: Sequence[str]) -> SensorNoise:
    """parts: (2 + modes,)"""
    share, of_range, *floors = parts.tolist()
    return SensorNoise(share, dict(zip(modes, floors, strict=True)), of_range)


def _spread(deviates: Floats) -> float:
    """Standard deviation of normal deviates, by those that are no outliers: twice as well known as a robust estimate
    alone, which tells which these are (P. J. Rousseeuw and A. M. Leroy, Robust Regression and Outlier Detection, 1987,
    ch. 1)."""
    kept = deviates[np.abs(deviates) < _OUTLYING]
    inside = 1 - 2 * _OUTLYING * norm.pdf(_OUTLYING) / (2 * norm.cdf(_OUTLYING) - 1)  # variance of what is kept
    return float(np.sqrt(np.mean(kept**2) / inside)) if len(kept) else 1.0


def _unlikely(runs: Sequence[_Rough], modes: Sequence[str], units: Floats, logarithms: Floats) -> float:
    """Minus the logarithm of the probability of the differences, as of a Cauchy distribution."""
    noise, total = _of_parts(units * np.exp(logarithms), modes), 0.0
    for r in runs:
        scale = _CAUCHY * r.deviations(noise)
        total += float(np.sum(np.log(scale) + np.log1p((r.differences / scale) ** 2)))
    return total


def _amplitude(run: Observations, sensor: int) -> Floats:
    """(n,) [m]; sensor: its place in the condition"""
    return np.asarray(np.exp(run.observed[:, 1 + 2 * sensor]))


def _with_noise(run: Observations, sensor: int, relative: Floats) -> Observations:
    noise = run.own.copy()
    noise[:, 1 + 2 * sensor] = relative
    if run.has_phase(sensor):
        noise[:, 2 + 2 * sensor] = relative
    return replace(run, own=noise)
