"""Whether all measured responses lag the model's by one angle, as a delay, a filter or a multiplexer makes them.

Calibration makes up for such an angle by frequency and loss, so that neither may be told before it is known. It is read
where these have no say: the model's points about its top against the run's about its own. Frequency and loss move a
top; at the top an oscillator's phase stays what it is. What fails otherwise turns the phase there by another angle at
each level (microslip of a beam's joint 1 degree at the lowest level, 9 at the highest), or at each sensor: one angle is
told only where all say the same, of two modes or of two levels at least, since one always agrees with itself.
"""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.stats import norm

from updamp.comparison.comparison import Finding
from updamp.comparison.findings.peak_misfit import PLACED, without_peak
from updamp.comparison.findings.peak_reading import SweptBranch, reading_noise, swept_branch, tops_of_run
from updamp.comparison.findings.peak_sentences import ALIKE
from updamp.comparison.findings.several_peaks import several_peaks
from updamp.comparison.fit.failing_model import RISK
from updamp.comparison.fit.fit import Fit
from updamp.comparison.fit.matching import Matched
from updamp.comparison.fit.observations import Plan
from updamp.comparison.prediction.predicted_branch import PredictedBranch
from updamp.effects.phase_lag import EFFECT as PHASE_LAG

Floats = NDArray[np.float64]

PHASE = "phase"


@dataclass(frozen=True)
class PhaseLag:
    """angle: by which the measured responses lag the model's [rad]; significance: in standard deviations, signed"""

    angle: float
    significance: float


def phase_lag(fit: Fit, plan: Plan, branches: Sequence[PredictedBranch]) -> PhaseLag | None:
    """None where it does not stand out, or tests and sensors do not agree on it: all within a third of the mean; and
    where it is larger than a lag can be, such as of a force of the wrong sign, which is asked about.

    Read of tests whose runs and whose model have smooth tops: where a sweep jumps, the phase there is where it happens
    to. branches: calibrated, one a condition
    """
    without = {*without_peak(plan, branches), *(one.test for one in several_peaks(fit, plan, branches))}
    of_tests = ((c, _of_test(fit, i, branches[i])) for i, c in enumerate(plan.conditions) if i not in without)
    known = [(condition, one) for condition, one in of_tests if one is not None]
    if len({(condition.mode, condition.level) for condition, _ in known}) < 2:
        return None
    read = [one for _, one in known]
    each = np.concatenate([angles for angles, _ in read])
    mean = float(np.mean([np.mean(angles) for angles, _ in read]))
    if np.any(np.abs(each - mean) > ALIKE * abs(mean)) or not PHASE_LAG.parameters[0].allows(mean):
        return None
    by_test = np.array([np.mean(angles) for angles, _ in read])
    spread = float(np.std(by_test, ddof=1) / np.sqrt(len(read))) if len(read) > 1 else 0.0
    by_reading = float(np.linalg.norm([deviation for _, deviation in read])) / len(read)
    significance = mean / max(spread, by_reading)
    return PhaseLag(mean, significance) if abs(significance) > norm.isf(RISK / 2) else None


def _of_test(fit: Fit, test: int, branch: PredictedBranch) -> tuple[Floats, float] | None:
    """(s,) lag at each sensor, as mean over the repeats, and the deviation of their mean; None where it is not read."""
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
    return np.mean(lags, axis=0), _deviation(swept, matched, sensors, fit.compared.scatter.noise)


def _lags(swept: SweptBranch, m: Matched, sensors: Sequence[int]) -> Floats:
    """(s,) [rad], nan where the phase was not measured"""
    o = m.observations
    known = all(o.has_phase(j) for j in sensors)
    turned = swept.tops_as_measured(o, sensors).phase - tops_of_run(o, sensors).phase
    return np.angle(np.exp(1j * turned)) if known else np.full(len(sensors), np.nan)


def _deviation(swept: SweptBranch, matched: Sequence[Matched], sensors: Sequence[int], noise: float) -> float:
    """Of the mean over runs and sensors. A top that is misplaced by a half-width turns the phase by 1: each by its
    noise, the model's by as much as no top is placed better than."""
    s, of_runs = len(sensors), []
    for m in matched:
        placed = noise * reading_noise(m.observations, sensors)[:s] / [swept.half_width(j) for j in sensors]
        turned = noise * m.observations.noise[:, [2 + 2 * j for j in sensors]].max(axis=0)
        of_runs.append(float(np.linalg.norm(np.hypot(placed, turned))) / s)
    return float(np.hypot(np.linalg.norm(of_runs) / len(matched), PLACED))


def fitted_lag(fit: Fit) -> PhaseLag:
    """Of a fit that has the effect, its own angle."""
    place = fit.parametrisation.columns(PHASE_LAG.name)
    angle = fit.parametrisation.values(fit.u)[PHASE_LAG.name][PHASE_LAG.parameters[0].name]
    return PhaseLag(angle, float(fit.u[place][0] / fit.uncertainty[place][0]))


def lag_finding(lag: PhaseLag) -> Finding:
    degrees = float(np.degrees(abs(lag.angle)))
    text = (
        f"measured phases {'lag' if lag.angle > 0 else 'lead'} the model's by {degrees:.1f} degrees in all runs, as a "
        "delay or a filter of the measurement makes them; what else is told is of the model that lags as much"
    )
    return Finding(text, "", None, PHASE, "", lag.angle, lag.significance)
