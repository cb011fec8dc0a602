"""Runs that are high or low as a whole, at all frequencies: at all sensors by another level than the file says, another
point of excitation; at one of them by a gain that was changed in between; in one repeat of several, or in all of them.

Nothing that a structure does looks so, unless all runs do: so where factors of single runs explain most of what the
model leaves, these are what is said. They are estimated for each sensor, together with the fitted parameters, by
generalised least squares, as the other misfits are (`findings.py`).
"""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace

import numpy as np
import scipy.linalg
from numpy.typing import NDArray
from scipy.stats import median_abs_deviation, norm

from updamp.comparison.comparison import Finding
from updamp.comparison.findings.direction import Direction, Sensor
from updamp.comparison.findings.findings import equations_with
from updamp.comparison.findings.kinds import OF_MODES, Amplitude, SensorGain
from updamp.comparison.findings.unlike_repeats import FEWEST
from updamp.comparison.findings.words import FAR_LESS, in_percent, level_of
from updamp.comparison.fit.compared import reweighed
from updamp.comparison.fit.failing_model import RISK
from updamp.comparison.fit.fit import Fit
from updamp.comparison.fit.lack_of_fit import lack_of_fit
from updamp.comparison.fit.matching import Matched
from updamp.comparison.fit.observations import Plan
from updamp.comparison.prediction.run_condition import RunCondition

# Deviation of the level of a run where there is none.
_NONE = 1e-9

Floats = NDArray[np.float64]
Bools = NDArray[np.bool_]


def whole_run_findings(fit: Fit, plan: Plan) -> tuple[Finding, ...]:
    """A sentence on each test that is off as a whole against most of its mode, or on each of its sensors, or repeats,
    where these are not off alike, the farthest first; none unless these leave less than a quarter of what the model
    does, and less than resonances and damping of all tests would."""
    modes = [condition.mode for condition in plan.conditions]
    tests = [i for i, mode in enumerate(modes) if modes.count(mode) > 1]
    if not tests:
        return ()
    of_most, fit = _of_most_runs(fit, plan), _with_levels_told(fit, plan)
    if lack_of_fit(fit, plan) >= RISK:
        return ()
    runs = [(o.test, o.repeat) for o in plan.observations if o.test in tests]
    factors = [_Factor(*run, sensor=sensor) for run in runs for sensor in plan.conditions[run[0]].sensors]
    # of one assembly, which have its sensors' gains in common
    alike: dict[tuple[str, int, Sensor], list[int]] = {}
    for i, one in enumerate(factors):
        alike.setdefault((modes[one.test], one.repeat, one.sensor), []).append(i)
    estimate, covariance, left = _estimated(fit, plan, factors, _differences(tuple(alike.values())))
    others = [kind(test) for kind in OF_MODES for test in tests]
    *_, otherwise = _estimated(fit, plan, others, np.eye(len(others)))
    if left > otherwise or left - 1 > FAR_LESS * (fit.compared.mean_squared_misfit - 1):
        return ()
    against = np.zeros((len(factors), len(factors)))
    for places in alike.values():
        against[places] = _against_the_middle(places, estimate)
    same_run = np.array(
        [[(one.test, one.repeat) == (other.test, other.repeat) for other in factors] for one in factors]
    )
    off, of_off = against @ estimate, against @ (covariance + of_most**2 * same_run) @ against.T
    found: list[Finding] = []
    for test in tests:
        own = [i for i, one in enumerate(factors) if one.test == test]
        of_test = _Test(plan, test, [factors[i] for i in own], off[own], of_off[np.ix_(own, own)], len(factors))
        found += of_test.sentences()
    return tuple(sorted(found, key=lambda f: -abs(f.significance)))


def _of_most_runs(fit: Fit, plan: Plan) -> float:
    """Deviation of the levels of runs as those of most of them have it, and at least as stated: one run that is unlike
    all others makes the deviation of all so large that it is one of its draws."""
    levels = [level for offsets in fit.compared.offsets.values() for level in offsets.level.values()]
    return min(fit.compared.scatter.level, max(plan.level, float(median_abs_deviation(levels, scale="normal"))))


def _with_levels_told(fit: Fit, plan: Plan) -> Fit:
    """The fit as if all runs of an assembly had one level: what they differ by is then a misfit."""
    without = replace(fit.compared.scatter, level=_NONE)
    return replace(fit, compared=reweighed(fit.parametrisation, plan, fit.compared, without))


@dataclass(frozen=True)
class _Factor(SensorGain):
    """Of what one sensor reads in a whole run."""

    repeat: int = 0

    def prior(self, plan: Plan) -> float:
        return Amplitude().prior(plan)

    def column(self, m: Matched, sensors: Sequence[Sensor], parameters: Sequence[str]) -> Floats:
        return super().column(m, sensors, parameters) * (m.observations.repeat == self.repeat)


def _differences(alike: Sequence[Sequence[int]]) -> Floats:
    """(factors, combinations) by which those of one sensor differ from run to run of a mode and assembly: what they
    have in common is the model's, or the sensor's gain. alike: places of the factors of each"""
    same = np.zeros((len(alike), sum(len(places) for places in alike)))
    for row, places in zip(same, alike, strict=True):
        row[list(places)] = 1.0
    return np.asarray(scipy.linalg.null_space(same))


def _estimated(fit: Fit, plan: Plan, directions: Sequence[Direction], combined: Floats) -> tuple[Floats, Floats, float]:
    """(directions,) how far each is off, their covariance with the noise that is left, and the mean squared misfit that
    they leave. combined: (directions, combinations) orthonormal, which alone are free"""
    r, columns = equations_with(fit, plan, directions)
    n = columns.shape[1] - len(directions)
    both = np.concatenate([columns[:, :n], columns[:, n:] @ combined], axis=1)
    before = 1 / fit.parametrisation.deviation**2
    sizes = np.array([direction.prior(plan) for direction in directions])
    free = combined.T @ (combined / sizes[:, None] ** 2)
    covariance = np.linalg.inv(both.T @ both + scipy.linalg.block_diag(np.diag(before), free))
    estimate = covariance @ (both.T @ r - np.append(fit.u * before, np.zeros(combined.shape[1])))
    left = fit.compared.mean_squared_misfit * float(np.sum((r - both @ estimate) ** 2) / np.sum(r**2))
    deviations = combined @ covariance[n:, n:] @ combined.T * max(1.0, left)
    return combined @ estimate[n:], np.asarray(deviations), left


def _against_the_middle(places: Sequence[int], estimate: Floats) -> Floats:
    """(places, factors) each against the one in the middle, or the two; of two the second against the first."""
    in_order = sorted(places, key=lambda i: estimate[i])
    middle = in_order[(len(in_order) - 1) // 2 : len(in_order) // 2 + 1] if len(in_order) > 2 else places[:1]
    against = np.eye(len(estimate))[list(places)]
    against[:, list(middle)] -= 1 / len(middle)
    return against


@dataclass(frozen=True, eq=False)
class _Test:
    """factors: (n,) of its runs and sensors; off: (n,) logarithms of the measured amplitudes over those in the middle
    of the runs of the mode and assembly; covariance: (n, n) of these; tested: how many such there are in all"""

    plan: Plan
    test: int
    factors: Sequence[_Factor]
    off: Floats
    covariance: Floats
    tested: int

    def sentences(self) -> Iterator[Finding]:
        repeats = np.array([factor.repeat for factor in self.factors])
        each, everywhere = tuple(dict.fromkeys(repeats.tolist())), np.ones(len(repeats), dtype=bool)
        # of two none can be told to be the odd one
        told_apart = [r for r in each if len(each) >= FEWEST and self._is_unlike(repeats == r, everywhere)]
        for repeat in told_apart:
            yield from self._of(repeats == repeat, f", repeat {repeat}")
        if not told_apart:
            yield from self._of(everywhere, "")

    def _of(self, run: Bools, which: str) -> Iterator[Finding]:
        """run: (n,) which factors are of it"""
        of_sensors = {s: np.array([f.sensor == s for f in self.factors]) for s in self._condition.sensors}
        where = f"{self._condition.mode} at {level_of(self.plan, self.test)}{which}"
        if any(self._is_unlike(own, run) for own in of_sensors.values()):
            for (channel, _), own in of_sensors.items():
                if self._stands_out(row := _mean(own & run)):
                    yield self._of_sensor(where, channel, row)
        elif self._stands_out(row := _mean(run)):
            yield self._of_run(where, row)

    def _is_unlike(self, own: Bools, among: Bools) -> bool:
        """Whether some stand out of the mean of the others among these"""
        return bool((~own & among).any()) and self._stands_out(_mean(own & among) - _mean(~own & among))

    @property
    def _condition(self) -> RunCondition:
        return self.plan.conditions[self.test]

    def _stands_out(self, row: Floats) -> bool:
        """Out of chance; and less than a sensor's gain may be off by anyway is not worth a sentence."""
        limit = float(norm.isf(RISK / 2 / self.tested))
        return abs(self._significance(row)) > limit and abs(float(row @ self.off)) > self.plan.gain

    def _significance(self, row: Floats) -> float:
        deviation = float(np.sqrt(row @ self.covariance @ row))
        return float(row @ self.off) / deviation if deviation else 0.0

    def _of_run(self, where: str, row: Floats) -> Finding:
        relative, of_model = np.expm1([float(row @ self.off), -float(row @ self.off)]).tolist()
        text = (
            f"{where}: the whole run reads {in_percent(relative)}, at all frequencies, against the other runs of the "
            "mode: is its level, its point of excitation or a gain another one?"
        )
        of = self._condition.mode, self._condition.level, Amplitude.quantity, ""
        return Finding(text, *of, of_model, -self._significance(row))

    def _of_sensor(self, where: str, channel: str, row: Floats) -> Finding:
        relative, of_model = np.expm1([float(row @ self.off), -float(row @ self.off)]).tolist()
        text = (
            f"{where}: {channel} reads {in_percent(relative)} in the whole run, at all frequencies, against the other "
            "runs of the mode, unlike the other sensors: was its gain or its range another one?"
        )
        of = self._condition.mode, self._condition.level, SensorGain.quantity, channel
        return Finding(text, *of, of_model, -self._significance(row))


def _mean(some: Bools) -> Floats:
    """(n,) shares of a mean over some"""
    return some.astype(float) / float(np.count_nonzero(some))
