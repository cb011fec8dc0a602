"""Where the model fails along its curves: which mode and force level, frequency or damping, which sensor, and whether
that stands out of what the test repeats to.

Each statement is a direction in the residual (`kinds.py`): a shift of a run's resonance, more damping in it, a sensor
that reads high. All of them are estimated together, on top of the fitted parameters, by generalised least squares.
"""

from collections.abc import Sequence
from dataclasses import replace

import numpy as np
from numpy.typing import NDArray
from scipy.stats import norm

from updamp.comparison.comparison import Finding
from updamp.comparison.findings.direction import Direction, Misfit
from updamp.comparison.findings.kinds import KINDS, Amplitude
from updamp.comparison.findings.words import level_of
from updamp.comparison.fit.failing_model import RISK
from updamp.comparison.fit.fit import Fit
from updamp.comparison.fit.lack_of_fit import lack_of_fit
from updamp.comparison.fit.observations import Plan
from updamp.comparison.fit.scatter import Assembly, whitened

Floats = NDArray[np.float64]

# Distance from a bound at which a parameter counts as held by it, in prior deviations.
_AT_BOUND = 1e-3


def misfits(fit: Fit, plan: Plan, damping_share: Sequence[float]) -> tuple[Misfit, ...]:
    """All directions, estimated together with the fitted parameters, which stay where they are to within their own
    uncertainty: what all tests have in common is theirs, and what tests differ by is known far better than that.

    damping_share: for each condition, the material's share of the damping at its resonance: what turns a factor on
        the material's loss factor into one on all the damping
    """
    directions = [one for kind in KINDS for one in kind.along_curves(plan)]
    r, both = equations_with(fit, plan, directions)
    n = both.shape[1] - len(directions)
    sizes = np.array([one.prior(plan) for one in directions])
    before = 1 / fit.parametrisation.deviation**2
    prior = np.concatenate([before + 1 / np.maximum(fit.deviations, 1e-12) ** 2, 1 / sizes**2])
    both[:, :n] *= ~_held(fit)
    covariance = np.linalg.inv(both.T @ both + np.diag(prior))
    # the parameters stand at their best values: their own gradient is nil, but for the prior's
    estimate = covariance @ (both.T @ r - np.append(fit.u * before, np.zeros(len(sizes))))
    # with the noise that the misfit asks for, where it is larger (R. T. Birge, Phys. Rev. 40 (1932) 207)
    covariance = covariance * max(1.0, fit.compared.mean_squared_misfit)
    estimate, covariance = estimate[n:], covariance[n:, n:]

    def misfit(direction: Direction, combined: Floats) -> Misfit:
        # a correction that the model needs upwards is a model that reads low
        log, deviation = -float(combined @ estimate), float(np.sqrt(combined @ covariance @ combined))
        relative = float(np.expm1(log))
        # as significant as the logarithm is
        return Misfit(direction, relative, deviation * (relative / log if log else 1.0))

    rows = dict(zip(directions, np.eye(len(directions)), strict=True))
    return tuple(one for kind in KINDS for one in kind.stated(rows, damping_share, misfit))


def _held(fit: Fit) -> NDArray[np.bool_]:
    """(p,) whether each parameter stands at a bound: what it cannot make up for is a misfit."""
    p = fit.parametrisation
    near = _AT_BOUND * np.where(np.isfinite(p.deviation), p.deviation, 1.0)
    return np.asarray((fit.u - p.lower < near) | (p.upper - fit.u < near))


def whitened_with(a: Assembly, block: Floats, fit: Fit) -> tuple[Floats, Floats]:
    """The assembly's residual and a block of columns, with its scatter taken into account."""
    return whitened(replace(a, common=block), fit.compared.scatter)


def equations_with(fit: Fit, plan: Plan, directions: Sequence[Direction]) -> tuple[Floats, Floats]:
    """(values,) residuals of all assemblies with their scatter taken into account, and (values, p + directions) what a
    unit of each fitted parameter and direction takes from them."""
    residuals, columns = [], []
    for a in fit.compared.assemblies:
        block = np.concatenate([a.common, _columns(fit, plan, a.repeat, directions)], axis=1)
        r, c = whitened_with(a, block, fit)
        residuals.append(r)
        columns.append(c)
    return np.concatenate(residuals), np.concatenate(columns)


def _columns(fit: Fit, plan: Plan, repeat: int, directions: Sequence[Direction]) -> Floats:
    names, blocks = fit.parametrisation.names, []
    for m in (m for m in fit.compared.matched if m.observations.repeat == repeat):
        sensors = plan.conditions[m.observations.test].sensors
        blocks.append(np.column_stack([one.column(m, sensors, names) for one in directions]))
    return np.concatenate(blocks)


def findings(fit: Fit, plan: Plan, found: Sequence[Misfit], told: Sequence[Finding] = ()) -> tuple[Finding, ...]:
    """Sentences on the misfits that stand out; none where the model is adequate. told: what is said already"""
    limit = float(norm.isf(RISK / 2 / max(len(found), 1)))
    standing = [m for m in found if abs(m.significance) > limit]
    sentences = [one for kind in KINDS for one in kind.sentences(found, standing, plan)]
    sentences.sort(key=lambda f: -abs(f.significance))
    if not sentences and not told and lack_of_fit(fit, plan) < RISK:
        sentences.append(_of_all(fit, plan))
    return tuple(sentences)


def _of_all(fit: Fit, plan: Plan) -> Finding:
    mean_squared = fit.compared.mean_squared_misfit
    errors = np.array([[m.observations.test, np.mean(m.residual**2)] for m in fit.compared.matched])
    of_test = {int(i): float(np.mean(errors[errors[:, 0] == i, 1])) for i in np.unique(errors[:, 0])}
    worst = max(of_test, key=lambda i: of_test[i])
    condition, size = plan.conditions[worst], float(np.sqrt(of_test[worst])) / fit.compared.scatter.noise
    text = (
        f"the curves differ in shape, most of all {condition.mode} at {level_of(plan, worst)} ({size:.1f} times the "
        f"scatter): the mean squared misfit is {mean_squared:.2f}, and no resonance, peak or sensor stands out of so "
        "large a one by itself"
    )
    relative = float(np.sqrt(mean_squared) - 1)
    return Finding(text, condition.mode, condition.level, Amplitude.quantity, "", relative, _deviations(fit))


def _deviations(fit: Fit) -> float:
    """How many standard deviations chi2 is too large by (E. B. Wilson and M. M. Hilferty, PNAS 17 (1931) 684)."""
    k = fit.freedom
    return float((np.cbrt(fit.compared.chi2 / k) - (1 - 2 / (9 * k))) / np.sqrt(2 / (9 * k)))
