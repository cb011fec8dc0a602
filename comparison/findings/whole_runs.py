"""Runs that are high or low as a whole, at all frequencies and sensors: another level than the file says, another point
of excitation, a gain that was changed in between.

Nothing that a structure does looks so, unless all runs do: so where factors of single runs explain most of what the
model leaves, these are what is said. They are estimated together with the fitted parameters, by generalised least
squares, as the other misfits are (`findings.py`).
"""

from collections.abc import Iterator, Sequence

import numpy as np
import scipy.linalg
from numpy.typing import NDArray
from scipy.stats import norm

from updamp.comparison.comparison import Finding
from updamp.comparison.findings.direction import Direction
from updamp.comparison.findings.findings import equations_with
from updamp.comparison.findings.kinds import OF_MODES, Amplitude
from updamp.comparison.findings.words import FAR_LESS, in_percent, level_of
from updamp.comparison.fit.failing_model import RISK
from updamp.comparison.fit.fit import Fit
from updamp.comparison.fit.observations import Plan

Floats = NDArray[np.float64]


def whole_run_findings(fit: Fit, plan: Plan) -> tuple[Finding, ...]:
    """A sentence on each test that is off as a whole against most of its mode, the farthest first; none unless these
    leave less than a quarter of what the model does, and less than resonances and damping of all tests would."""
    modes = [condition.mode for condition in plan.conditions]
    tests = [i for i, mode in enumerate(modes) if modes.count(mode) > 1]
    if not tests:
        return ()
    several = dict.fromkeys(modes[test] for test in tests)
    of_modes = [[i for i, test in enumerate(tests) if modes[test] == mode] for mode in several]
    runs = [Amplitude(test) for test in tests]
    estimate, covariance, left = _estimated(fit, plan, runs, _differences(of_modes))
    others = [kind(test) for kind in OF_MODES for test in tests]
    *_, otherwise = _estimated(fit, plan, others, np.eye(len(others)))
    if left > otherwise or left - 1 > FAR_LESS * (fit.compared.mean_squared_misfit - 1):
        return ()
    limit = float(norm.isf(RISK / 2 / len(tests)))
    found = [one for of_mode in of_modes for one in _against_the_middle(of_mode, estimate, covariance)]
    # less than a sensor's gain may be off by anyway is not worth a sentence
    sentences = [_sentence(plan, tests[i], off, z) for i, off, z in found if abs(z) > limit and abs(off) > plan.gain]
    return tuple(sorted(sentences, key=lambda f: -abs(f.significance)))


def _differences(of_modes: Sequence[Sequence[int]]) -> Floats:
    """(tests, combinations) by which tests of a mode differ: what they have in common is the model's."""
    same = np.zeros((len(of_modes), sum(len(of_mode) for of_mode in of_modes)))
    for row, of_mode in zip(same, of_modes, strict=True):
        row[list(of_mode)] = 1.0
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


def _against_the_middle(
    of_mode: Sequence[int], estimate: Floats, covariance: Floats
) -> Iterator[tuple[int, float, float]]:
    """Each against the one in the middle, or the two; of two the second against the first: logarithm of the measured
    amplitude over that, and how many deviations it is."""
    in_order = sorted(of_mode, key=lambda i: estimate[i])
    middle = in_order[(len(in_order) - 1) // 2 : len(in_order) // 2 + 1] if len(in_order) > 2 else of_mode[:1]
    for i in of_mode:
        against = np.zeros(len(estimate))
        against[i] += 1.0
        against[middle] -= 1 / len(middle)
        if against.any():
            off = float(against @ estimate)
            yield i, off, off / float(np.sqrt(against @ covariance @ against))


def _sentence(plan: Plan, test: int, off: float, significance: float) -> Finding:
    condition, relative = plan.conditions[test], float(np.expm1(off))
    text = (
        f"{condition.mode} at {level_of(plan, test)}: the whole run reads {in_percent(relative)}, at all frequencies, "
        "against the other runs of the mode: is its level, its point of excitation or a gain another one?"
    )
    return Finding(text, condition.mode, condition.level, Amplitude.quantity, "", float(np.expm1(-off)), -significance)
