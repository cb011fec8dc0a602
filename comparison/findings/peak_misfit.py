"""How far the model's peaks are from the measured ones: resonance frequency, height, and each sensor's height against
the others', for each test, read off both in the same way.

This asks nothing of the curve but a top. It holds where contacts slip and the phase does not turn as an oscillator's
does, where the misfit is too large for estimates to first order, and where calibration has ended in a poor compromise.
"""

from collections.abc import Collection, Sequence
from dataclasses import dataclass, replace

import numpy as np
import scipy.linalg
from numpy.typing import NDArray
from scipy.stats import norm
from scipy.stats import t as student

from updamp.comparison.findings.direction import Direction
from updamp.comparison.findings.kinds import KINDS, Amplitude, Damping
from updamp.comparison.findings.peak_reading import SweptBranch, damping_noise, reading_noise, swept_branch, tops_of_run
from updamp.comparison.fit.fit import Fit
from updamp.comparison.fit.observations import Observations, Plan
from updamp.comparison.fit.scatter import Scatter
from updamp.comparison.prediction.predicted_branch import PredictedBranch

Floats = NDArray[np.float64]

# No top is placed better than to this share of the half-width: steps are a fifth of it.
PLACED = 0.02
_LEAST_STEP = 1e-6  # of a parameter, for derivatives


@dataclass(frozen=True)
class PeakMisfit:
    """relative: model over measurement less 1; significance: in standard deviations of the scatter, with its sign
    severity: by how much of the peak's height amplitudes are wrong where they are most so: the logarithm; of a
        frequency what a shift does on the flank; of a sensor against the others its own part of it
    """

    direction: Direction
    relative: float
    significance: float
    severity: float


@dataclass(frozen=True, eq=False)
class _Test:
    """One test's statements, k of them.

    directions: (k,); logs: (repeats, k) of model over measured, nan where a repeat is missing; damping: (repeats, s)
    damping_variance: of the mean of all of these, by noise; nan where it is not asked for
    common: (q, k) what scatter of assemblies (sensors' gains among it) by one deviation does, the same in all tests
    by_parameter: (p, k); own: (k, k) covariance of what this test alone scatters by
    units: (k,) what a severity of 1 is; smooth: whether model and runs have tops, and do not jump from them
    """

    directions: tuple[Direction, ...]
    logs: Floats
    damping: Floats
    damping_variance: float
    common: Floats
    by_parameter: Floats
    own: Floats
    units: Floats
    smooth: bool


def peak_misfits(
    fit: Fit, plan: Plan, branches: Sequence[PredictedBranch], scatter: Scatter | None = None
) -> tuple[PeakMisfit, ...]:
    """Model over measured, as mean over the repeats: of each test the resonance frequency (mean over the sensors), the
    peak height (likewise), the damping where the phase tells it, and of each sensor its height against the others'.

    Each is held against the scatter by itself and against the mean over the levels of its mode, which is known far
    better: assemblies differ from each other in all levels alike. The larger significance counts. Where a sweep jumps
    from its top, or ends below it, how high it comes is where it happens to, in each assembly elsewhere: no linear
    scatter tells how far, and such a test is held against what its repeats differ by alone.

    branches: calibrated, one a condition; those of `without_peak` are left out
    scatter: of assemblies, runs and sensors, the fit's own by default
    """
    if scatter is not None:
        fit = replace(fit, compared=replace(fit.compared, scatter=scatter))
    tests, without = [], without_peak(plan, branches)
    for i, branch in enumerate(branches):
        sensors = list(range(len(branch.condition.sensors)))
        runs = {o.repeat: o for o in plan.observations if o.test == i}
        if sensors and runs and i not in without:
            tests.append(_of_test(fit, i, branch, sensors, [runs.get(r) for r in plan.repeats]))
    if not tests:
        return ()
    directions = [d for t in tests for d in t.directions]
    logs, units = np.concatenate([t.logs for t in tests], axis=1), np.concatenate([t.units for t in tests])
    covariance = _covariance(fit, tests, len(plan.repeats))
    jumps = {t.directions[0].test for t in tests if not t.smooth}
    found = []
    for i, direction in enumerate(directions):
        mean = float(np.nanmean(logs[:, i]))
        if direction.test in jumps:
            significance = by_repeats(logs[:, i])
        else:
            held_against = _held_against(i, directions, plan, jumps)
            significance = max(_significance(row, logs, covariance) for row in held_against)
        signed = float(np.copysign(significance, mean))
        found.append(PeakMisfit(direction, float(np.expm1(mean)), signed, abs(mean) / float(units[i])))
    return (*found, *(m for t in tests for m in _of_damping(t, directions, covariance)))


def without_peak(plan: Plan, branches: Sequence[PredictedBranch]) -> tuple[int, ...]:
    """Conditions whose branch has no top where there was measured, at one of the sensors: it is another resonance's, or
    another branch than the sweep was on."""
    found = []
    for i, branch in enumerate(branches):
        sensors = list(range(len(branch.condition.sensors)))
        runs = [o for o in plan.observations if o.test == i]
        if sensors and runs:
            swept = swept_branch(branch, runs, sensors[0])
            found += [] if all(swept.has_top(j) for j in sensors) else [i]
    return tuple(found)


def _held_against(i: int, directions: Sequence[Direction], plan: Plan, without: Collection[int]) -> list[Floats]:
    """Combinations of all statements: one by itself, and less the mean over its mode's levels, without some tests."""
    itself, one = np.zeros(len(directions)), directions[i]
    itself[i] = 1.0
    alike = [(d.in_all_tests, plan.conditions[d.test].mode) for d in directions]
    wanted = (one.in_all_tests, plan.conditions[one.test].mode)
    levels = np.array([a == wanted and d.test not in without for a, d in zip(alike, directions, strict=True)])
    return [itself, itself - levels / levels.sum()] if levels.sum() > 1 else [itself]


def _significance(row: Floats, logs: Floats, covariance: Floats) -> float:
    """Size of a combination of statements over its deviation: as scatter makes it, or as the repeats themselves have
    it, whichever is larger."""
    used = np.flatnonzero(row)
    each = logs[:, used] @ row[used]
    each = each[np.isfinite(each)]
    if len(each) == 0:
        return 0.0
    return abs(float(np.mean(each))) / max(float(np.sqrt(row @ covariance @ row)), _deviation_of_mean(each), 1e-12)


def by_repeats(each: Floats) -> float:
    """Size of a mean over its deviation as the repeats alone have it: as many deviations of a normal distribution as
    are as likely by Student's t; 0 of one repeat."""
    each = each[np.isfinite(each)]
    if len(each) < 2:
        return 0.0
    deviation = max(_deviation_of_mean(each), np.finfo(float).tiny)
    by_chance = float(student.sf(abs(float(np.mean(each))) / deviation, len(each) - 1))
    return float(norm.isf(max(by_chance, np.finfo(float).tiny)))


def _deviation_of_mean(each: Floats) -> float:
    """Deviation of the mean of the repeats, as they have it."""
    return float(np.std(each, ddof=1) / np.sqrt(len(each))) if len(each) > 1 else 0.0


def _of_damping(test: _Test, directions: Sequence[Direction], covariance: Floats) -> list[PeakMisfit]:
    """Where the phase of every sensor tells it in every run: as well as the height is known, at best, and as noise
    lets it be read; about a top that the sweep jumps from or ends at, as its repeats have it."""
    made = test.damping[np.isfinite(test.logs).any(axis=1)]
    if not np.isfinite(made).all():
        return []
    by_phase = np.mean(made, axis=1)
    place = test.directions[0].test
    i = directions.index(Amplitude(place))
    mean = float(np.mean(by_phase))
    if test.smooth:
        deviation = float(np.sqrt(covariance[i, i] + test.damping_variance))
        significance = abs(mean) / max(deviation, _deviation_of_mean(by_phase))
    else:
        significance = by_repeats(by_phase)
    signed = float(np.copysign(significance, mean))
    return [PeakMisfit(Damping(place), float(np.expm1(mean)), signed, abs(mean))]


def _covariance(fit: Fit, tests: Sequence[_Test], repeats: int) -> Floats:
    """Of all statements, as mean over the repeats: scatter, and what the fit does not know."""
    common = np.concatenate([t.common for t in tests], axis=1)
    by_parameter = np.concatenate([t.by_parameter for t in tests], axis=1)
    own = scipy.linalg.block_diag(*(t.own for t in tests))
    return np.asarray(common.T @ common / repeats + by_parameter.T @ fit.covariance @ by_parameter + own)


def _of_test(
    fit: Fit, test: int, branch: PredictedBranch, sensors: Sequence[int], runs: Sequence[Observations | None]
) -> _Test:
    made = [o for o in runs if o is not None]
    swept = swept_branch(branch, made, sensors[0])
    stated = [one for kind in KINDS for one in kind.at_tops(test, [branch.condition.sensors[j] for j in sensors])]
    directions, rows = tuple(d for d, _ in stated), np.array([row for _, row in stated])
    logs, damping = np.full((len(runs), len(rows)), np.nan), np.full((len(runs), len(sensors)), np.nan)
    for i, o in enumerate(runs):
        if o is not None:
            measured, model = tops_of_run(o, sensors), swept.tops_as_measured(o, sensors)
            logs[i] = rows @ (model.value + swept.by_drive(o, sensors) - measured.value)
            damping[i] = np.log(model.loss_factor / measured.loss_factor)
    half_width = swept.half_width(sensors[int(np.argmax(swept.tops(sensors)[len(sensors) :]))])
    common, by_parameter, own = _scatter(fit, swept, sensors, made, half_width)
    units = np.array([d.unit(half_width, len(sensors)) for d in directions])
    matched = [m for m in fit.compared.matched if m.observations.test == test]
    smooth = swept.is_smooth(sensors) and all(swept.has_smooth_run(m, sensors) for m in matched)
    of_damping = np.nan
    if smooth and np.isfinite(damping[[o is not None for o in runs]]).all():
        noise = fit.compared.scatter.noise * np.concatenate([damping_noise(o, sensors) for o in made])
        of_damping = float(np.sum(noise**2)) / len(noise) ** 2
    of_tops = common @ rows.T, by_parameter @ rows.T, rows @ own @ rows.T
    return _Test(directions, logs, damping, of_damping, *of_tops, units, smooth)


def _scatter(
    fit: Fit, swept: SweptBranch, sensors: Sequence[int], runs: Sequence[Observations], half_width: float
) -> tuple[Floats, Floats, Floats]:
    """Of the tops' values: what scatter of assemblies by one deviation does (q, 2 s), derivatives by the parameters
    (p, 2 s), and the covariance (2 s, 2 s) that is this test's own, of the mean over its runs."""
    s, scatter, nuisances = len(sensors), fit.compared.scatter, fit.parametrisation.nuisances
    by_parameter = swept.by_parameter(sensors, np.maximum(fit.deviations, _LEAST_STEP))
    of_parameters = by_parameter[: len(nuisances)] * np.array([scatter.parameters[n.name] for n in nuisances])[:, None]
    gains = np.concatenate([np.zeros((s, s)), scatter.gain * np.eye(s)], axis=1)
    frequencies = np.append(np.ones(s), np.zeros(s))
    together = np.outer(frequencies, frequencies)
    noise = scatter.noise * np.mean([reading_noise(o, sensors) for o in runs], axis=0)
    rough = swept.branch.rough_at(swept.places(sensors))
    jagged = np.append(rough[:, 0], rough[np.arange(s), 1 + 2 * np.array(sensors)])
    levels = np.outer(1 - frequencies, 1 - frequencies) * scatter.level**2
    own = (together * scatter.drift**2 + levels + np.diag(noise**2)) / len(runs)
    own += together * (PLACED * half_width) ** 2 + np.diag(jagged**2)
    return np.concatenate([of_parameters, gains]), by_parameter, own
