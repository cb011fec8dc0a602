"""Runs that are high or low as a whole, at all frequencies: at all sensors by another level than the file says, another
point of excitation; at one of them by a gain that was changed in between.

Nothing that a structure does looks so, unless all runs do: so where factors of single runs explain most of what the
model leaves, these are what is said. They are estimated for each sensor, together with the fitted parameters, by
generalised least squares, as the other misfits are (`findings.py`).
"""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass

import numpy as np
import scipy.linalg
from numpy.typing import NDArray
from scipy.stats import norm

from updamp.comparison.comparison import Finding
from updamp.comparison.findings.direction import Direction, Sensor
from updamp.comparison.findings.findings import equations_with
from updamp.comparison.findings.kinds import OF_MODES, Amplitude, SensorGain
from updamp.comparison.findings.words import FAR_LESS, in_percent, level_of
from updamp.comparison.fit.failing_model import RISK
from updamp.comparison.fit.fit import Fit
from updamp.comparison.fit.observations import Plan

Floats = NDArray[np.float64]


def whole_run_findings(fit: Fit, plan: Plan) -> tuple[Finding, ...]:
    """A sentence on each test that is off as a whole against most of its mode, or on each of its sensors where these
    are not off alike, the farthest first; none unless these leave less than a quarter of what the model does, and less
    than resonances and damping of all tests would."""
    modes = [condition.mode for condition in plan.conditions]
    tests = [i for i, mode in enumerate(modes) if modes.count(mode) > 1]
    if not tests:
        return ()
    factors = [_Factor(test, sensor=sensor) for test in tests for sensor in plan.conditions[test].sensors]
    alike: dict[tuple[str, Sensor], list[int]] = {}
    for i, one in enumerate(factors):
        alike.setdefault((modes[one.test], one.sensor), []).append(i)
    estimate, covariance, left = _estimated(fit, plan, factors, _differences(tuple(alike.values())))
    others = [kind(test) for kind in OF_MODES for test in tests]
    *_, otherwise = _estimated(fit, plan, others, np.eye(len(others)))
    if left > otherwise or left - 1 > FAR_LESS * (fit.compared.mean_squared_misfit - 1):
        return ()
    against = np.zeros((len(factors), len(factors)))
    for places in alike.values():
        against[places] = _against_the_middle(places, estimate)
    off, of_off = against @ estimate, against @ covariance @ against.T
    found: list[Finding] = []
    for test in tests:
        own = [i for i, one in enumerate(factors) if one.test == test]
        run = _Run(plan, test, [factors[i].channel for i in own], off[own], of_off[np.ix_(own, own)], len(factors))
        found += run.sentences()
    return tuple(sorted(found, key=lambda f: -abs(f.significance)))


@dataclass(frozen=True)
class _Factor(SensorGain):
    """Of what one sensor reads in a whole run."""

    def prior(self, plan: Plan) -> float:
        return Amplitude().prior(plan)


def _differences(alike: Sequence[Sequence[int]]) -> Floats:
    """(factors, combinations) by which those of one sensor differ from test to test of a mode: what they have in common
    is the model's. alike: places of the factors of each"""
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
class _Run:
    """A test, of all its runs. channels: (s,) its sensors; off: (s,) logarithms of the measured amplitudes over those
    in the middle of the mode's tests; covariance: (s, s) of these; tested: how many such there are in all"""

    plan: Plan
    test: int
    channels: Sequence[str]
    off: Floats
    covariance: Floats
    tested: int

    def sentences(self) -> Iterator[Finding]:
        n = len(self.off)
        each = np.eye(n)
        against_others = each - (1 - each) / max(n - 1, 1)
        if n > 1 and any(self._stands_out(row) for row in against_others):
            for channel, row in zip(self.channels, each, strict=True):
                if self._stands_out(row):
                    yield self._of_sensor(channel, row)
        elif self._stands_out(mean := np.full(n, 1 / n)):
            yield self._of_run(mean)

    def _stands_out(self, row: Floats) -> bool:
        """Out of chance; and less than a sensor's gain may be off by anyway is not worth a sentence."""
        limit = float(norm.isf(RISK / 2 / self.tested))
        return abs(self._significance(row)) > limit and abs(float(row @ self.off)) > self.plan.gain

    def _significance(self, row: Floats) -> float:
        deviation = float(np.sqrt(row @ self.covariance @ row))
        return float(row @ self.off) / deviation if deviation else 0.0

    def _of_run(self, row: Floats) -> Finding:
        condition, off = self.plan.conditions[self.test], float(row @ self.off)
        text = (
            f"{condition.mode} at {level_of(self.plan, self.test)}: the whole run reads {in_percent(np.expm1(off))}, "
            "at all frequencies, against the other runs of the mode: is its level, its point of excitation or a gain "
            "another one?"
        )
        of = condition.mode, condition.level, Amplitude.quantity, ""
        return Finding(text, *of, float(np.expm1(-off)), -self._significance(row))

    def _of_sensor(self, channel: str, row: Floats) -> Finding:
        condition, off = self.plan.conditions[self.test], float(row @ self.off)
        text = (
            f"{condition.mode} at {level_of(self.plan, self.test)}: {channel} reads {in_percent(np.expm1(off))} in the "
            "whole run, at all frequencies, against the other runs of the mode, unlike the other sensors: was its gain "
            "or its range another one?"
        )
        of = condition.mode, condition.level, SensorGain.quantity, channel
        return Finding(text, *of, float(np.expm1(-off)), -self._significance(row))
