"""Findings on a model without contacts, also where it fails grossly: its resonances against the measured ones, read
off both in the same way.

To first order, as misfits are estimated elsewhere, a resonance that is wrong by its own width is not described; and
curves that the model cannot follow at all would be followed by impossible parameters that nearly cancel.
"""

from collections.abc import Iterable, Mapping, Sequence

import numpy as np
from numpy.typing import NDArray

from updamp.comparison.comparison import Backbone, Finding
from updamp.comparison.findings.backbone import FIVE, places_of
from updamp.comparison.findings.direction import Misfit
from updamp.comparison.findings.findings import findings
from updamp.comparison.findings.gross_sensors import sensor_misfits
from updamp.comparison.findings.kinds import OF_MODES, Amplitude, Damping, OfMode
from updamp.comparison.findings.peak_misfit import without_peak
from updamp.comparison.findings.peak_sentences import without_peak_findings
from updamp.comparison.findings.several_peaks import several_peaks, several_peaks_findings
from updamp.comparison.findings.whole_runs import whole_run_findings
from updamp.comparison.findings.words import aimed_at
from updamp.comparison.fit.failing_model import RISK
from updamp.comparison.fit.fit import Fit
from updamp.comparison.fit.lack_of_fit import lack_of_fit
from updamp.comparison.fit.observations import Plan
from updamp.comparison.prediction.predicted_branch import PredictedBranch

Floats = NDArray[np.float64]

# Growth of the damping that is worth a sentence: of the logarithm, in standard deviations, and in itself.
_STANDS_OUT, _WORTH = 5.0, 0.2
# Growth, of the logarithm, up to which a damping stays: less than 5 % would be told as 1.0-fold.
_STAYS = 0.05


def linear_findings(
    fit: Fit,
    plan: Plan,
    branches: Sequence[PredictedBranch],
    first_order: Sequence[Misfit],
    measured: Sequence[Backbone],
    model: Sequence[Backbone],
) -> tuple[Finding, ...]:
    """Of a model without contacts: sentences on misfits as estimated to first order or, where the model fails, as read
    off the resonances, whose damping its phase tells: to first order what a misfit consists of drowns in its whole.
    Where runs that are off as a whole account for it, nothing else is read off them.

    branches: calibrated, one a condition; measured, model: as for `gross_misfits`
    """
    if whole_runs := whole_run_findings(fit, plan):
        return whole_runs
    if lack_of_fit(fit, plan) >= RISK:
        return findings(fit, plan, first_order)
    gains = [m for m in first_order if m.direction == Amplitude()]
    more = several_peaks(fit, plan, branches)
    unlike = {one.test for one in more}
    missing = [i for i in without_peak(plan, branches) if _has_peak(plan, i) and i not in unlike]
    of_tests = [m for m in gross_misfits(fit, plan, measured, model) if m.direction.test not in unlike.union(missing)]
    read = (*of_tests, *sensor_misfits(plan, measured, model))
    without = (*several_peaks_findings(more, plan), *without_peak_findings(missing, plan))
    told = (*without, *(() if unlike else damping_growth(fit, plan, measured, model)))
    return (*told, *findings(fit, plan, (*read, *gains), told))


def _has_peak(plan: Plan, test: int) -> bool:
    """Whether all runs of a test are highest inside of what was measured, at all sensors, with as many points on both
    sides as a top is read off: of some the window is on the flank of a resonance."""
    places = 1 + 2 * np.arange(len(plan.conditions[test].sensors))
    runs = [o for o in plan.observations if o.test == test]
    highest = [int(np.argmax(o.observed[:, j] - o.log_force)) for o in runs for j in places]
    last = [len(o) - 1 for o in runs for _ in places]
    return all(FIVE // 2 <= i <= n - FIVE // 2 for i, n in zip(highest, last, strict=True))


def gross_misfits(fit: Fit, plan: Plan, measured: Sequence[Backbone], model: Sequence[Backbone]) -> tuple[Misfit, ...]:
    """Frequency and damping of each test, as mean over its repeats and sensors, held against the scatter by itself and
    less the mean over its mode's tests, in which assemblies differ alike. The larger significance counts.

    measured: one a mode and sensor, entries in the order of the plan's runs; model: likewise, of its conditions
    """
    found = []
    for kind in OF_MODES:
        each = [_by_repeat(kind, test, plan, measured, model) for test in range(len(plan.conditions))]
        scatter = kind.scatter(fit.compared.scatter)
        for test, own in enumerate(each):
            logs = _finite(own.values())
            if len(logs) == 0:
                continue
            mean = float(np.mean(logs))
            relative = float(np.expm1(mean))
            alike = [e for e, c in zip(each, plan.conditions, strict=True) if c.mode == plan.conditions[test].mode]
            significance = max(_significance(logs, scatter), _significance(_less_mean(own, alike), scatter))
            found.append(Misfit(kind(test), relative, abs(relative) / significance if significance else scatter))
    return tuple(found)


def _significance(logs: Floats, scatter: float) -> float:
    """Of a mean over repeats and sensors; scatter: of a test, at least"""
    if len(logs) == 0:
        return 0.0
    spread = np.std(logs, ddof=1) / np.sqrt(len(logs)) if len(logs) > 1 else 0.0
    return abs(float(np.mean(logs))) / max(float(np.hypot(spread, scatter)), np.finfo(float).tiny)


def _less_mean(own: Mapping[int, Floats], tests: Sequence[Mapping[int, Floats]]) -> Floats:
    """Logarithms of a test less those of all tests of its mode in the same repeat, sensor by sensor"""
    found = []
    for repeat, logs in own.items():
        alike = [e[repeat] for e in tests if repeat in e and np.isfinite(e[repeat]).all()]
        if len(alike) > 1:
            found.append(logs - np.mean(alike, axis=0))
    return _finite(found)


def _finite(of_repeats: Iterable[Floats]) -> Floats:
    logs = np.concatenate([np.zeros(0), *of_repeats])
    return logs[np.isfinite(logs)]


def damping_growth(
    fit: Fit, plan: Plan, measured: Sequence[Backbone], model: Sequence[Backbone]
) -> tuple[Finding, ...]:
    """A sentence for each mode whose damping changes with the level otherwise than the model's."""
    found = []
    for mode in dict.fromkeys(c.mode for c in plan.conditions):
        of_mode = [i for i, c in enumerate(plan.conditions) if c.mode == mode]
        tests = sorted(of_mode, key=lambda i: plan.conditions[i].level)
        first, last = plan.conditions[tests[0]], plan.conditions[tests[-1]]
        if len(tests) < 2 or last.level <= first.level:
            continue
        ends = [_logs(measured, plan, t, True) for t in (tests[0], tests[-1])]
        of_model = [_logs(model, plan, t, False) for t in (tests[0], tests[-1])]
        if any(np.isnan(logs).all() for logs in (*ends, *of_model)):
            continue
        grown, models = (float(np.nanmean(b) - np.nanmean(a)) for a, b in (ends, of_model))
        deviation = np.sqrt(2) * Damping.scatter(fit.compared.scatter)
        significance = (models - grown) / deviation
        if abs(significance) > _STANDS_OUT and abs(models - grown) > _WORTH:
            text = (
                f"{mode}: measured damping {_fold(grown)} from {aimed_at(first)} to {aimed_at(last)}, "
                f"the model's {_fold(models)}"
            )
            found.append(
                Finding(text, mode, None, Damping.quantity, "", float(np.expm1(models - grown)), float(significance))
            )
    return tuple(found)


def _by_repeat(
    kind: type[OfMode], test: int, plan: Plan, measured: Sequence[Backbone], model: Sequence[Backbone]
) -> dict[int, Floats]:
    """Repeat -> (n_sensors,) logarithms of model over measured."""
    pairs = [(m, c) for m, c in zip(measured, model, strict=True) if m.mode == plan.conditions[test].mode]
    there, here = places_of(plan, test, False), places_of(plan, test, True)
    logs = np.log([kind.of(c)[there] / kind.of(m)[here] for m, c in pairs]).T
    return dict(zip([o.repeat for o in plan.observations if o.test == test], logs, strict=True))


def _logs(backbones: Sequence[Backbone], plan: Plan, test: int, is_measured: bool) -> Floats:
    """Of the damping at a test."""
    mode = plan.conditions[test].mode
    return np.log(np.concatenate([b.damping[places_of(plan, test, is_measured)] for b in backbones if b.mode == mode]))


def _fold(log_ratio: float) -> str:
    if abs(log_ratio) < _STAYS:
        return "stays"
    return f"{'grows' if log_ratio > 0 else 'falls'} {np.exp(abs(log_ratio)):.1f}-fold"
