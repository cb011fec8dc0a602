"""Calibration on synthetic runs: the truth is found, intervals hold it, chi2 is that of the scatter."""

from dataclasses import replace
from types import SimpleNamespace

import numpy as np
import pytest
from support.small_model import NUISANCES, condition, parametrisation, synthetic_plan

from updamp.comparison.findings.findings import findings, misfits
from updamp.comparison.fit.compared import compare_at, predict_branches
from updamp.comparison.fit.fit import SETTLED, Fit, FitOptions, covariance_of, fit
from updamp.comparison.fit.observations import Plan
from updamp.comparison.fit.scatter import Scatter
from updamp.comparison.prediction.traced_branch import trace_branch

CONDITIONS = (condition(10.0), condition(40.0), condition(80.0, upwards=False))
SCATTER = np.array([n.scatter for n in NUISANCES])
KNOWN = Scatter({n.name: n.scatter for n in NUISANCES}, drift=5e-5, gain=0.005)
TRUTH = np.array([0.004, 0.1, 0.2, 0.0])


@pytest.fixture(scope="module")
def runs():
    return synthetic_plan(parametrisation(), TRUTH, CONDITIONS, SCATTER, seed=3)


@pytest.fixture(scope="module")
def fitted(runs):
    return fitted_from(runs[0], np.zeros(4))


def fitted_from(plan: Plan, start: np.ndarray) -> Fit:
    p = parametrisation()
    return fit(p, plan, start, at_start=[trace_branch(p, start, c) for c in plan.conditions])


def test_chi2_at_the_truth_is_that_of_the_scatter(runs):
    """Each assembly at its own parameters, with drift and gain as they scatter."""
    plan, drawn = runs
    known = replace(KNOWN, parameters=dict.fromkeys(KNOWN.parameters, 1e-9))
    chi2 = values = 0.0
    for repeat, b in zip(plan.repeats, drawn, strict=True):
        own = replace(plan, observations=tuple(o for o in plan.observations if o.repeat == repeat))
        branches = [trace_branch(parametrisation(), TRUTH + b, c) for c in plan.conditions]
        found = compare_at(parametrisation(), TRUTH + b, own, branches, known)
        chi2, values = chi2 + found.chi2, values + found.values
    assert values == 3 * 3 * 40 * 4
    assert 0.9 < chi2 / values < 1.1


def test_offsets_of_the_assemblies_are_found(runs):
    """Friction's, which nothing else imitates: within a third of its scatter."""
    plan, drawn = runs
    branches = predict_branches(parametrisation(), TRUTH, plan)
    found = compare_at(parametrisation(), TRUTH, plan, branches, KNOWN)
    slip = np.array([o.parameters[2] + o.parameters[3] for o in found.offsets.values()])
    np.testing.assert_allclose(slip, drawn[:, 2] + drawn[:, 3], atol=0.015)


def test_the_truth_is_found_from_afar(fitted, runs):
    mean = TRUTH + runs[1].mean(axis=0)
    assert fitted.message == SETTLED
    assert np.all(np.abs(fitted.u - mean) < 3 * fitted.deviations), (fitted.u, mean, fitted.deviations)
    assert abs(fitted.u[0] - mean[0]) < 3e-4
    assert abs(fitted.u[1] - mean[1]) < 0.03
    assert 0.85 < fitted.compared.chi2 / fitted.compared.values < 1.15


def test_nothing_stands_out_of_the_scatter(fitted, runs):
    found = misfits(fitted, runs[0], [1.0] * len(CONDITIONS))
    assert findings(fitted, runs[0], found) == ()


@pytest.mark.long
def test_a_shifted_resonance_is_named(runs):
    """One level's frequencies are moved by 0.3 %: nothing that all levels share explains that."""
    plan = runs[0]
    moved = []
    for o in plan.observations:
        observed = o.observed.copy()
        observed[:, 0] += 0.003 * (o.test == 2)
        moved.append(replace(o, observed=observed))
    plan = replace(plan, observations=tuple(moved))
    found = fitted_from(plan, TRUTH)
    said = findings(found, plan, misfits(found, plan, [1.0] * 3))
    assert said
    assert said[0].quantity == "frequency"


@pytest.mark.long
def test_a_fit_does_not_settle_on_branches_that_lack_what_a_sweep_sees(fitted, runs):
    """As those do that were moved from where a sweep saw less: half of the measured points have no place there."""
    plan, p = runs[0], parametrisation()
    places = [[m.place for m in fitted.compared.matched if m.observations.test == i] for i in range(len(CONDITIONS))]
    lacking = [
        with_a_gap(trace_branch(p, fitted.u, c), np.concatenate(place))
        for c, place in zip(CONDITIONS, places, strict=True)
    ]
    settled, kept = (
        fit(p, plan, fitted.u, fitted.compared.scatter, lacking, FitOptions(retraced=retraced)).compared
        for retraced in (True, False)
    )
    assert kept.mean_squared_misfit > 2 * fitted.compared.mean_squared_misfit
    assert settled.mean_squared_misfit == pytest.approx(fitted.compared.mean_squared_misfit, rel=0.05)


def with_a_gap(branch, place):
    low, high = np.quantile(place, [0.25, 0.75])
    gone = (branch.place > low) & (branch.place < high)
    points = tuple(replace(point, after_gap=lacks) for point, lacks in zip(branch.points, gone, strict=True))
    return replace(branch, points=points)


def test_a_parameter_that_the_data_hardly_tell_is_not_told_to_be_known_exactly():
    """Its part of the information matrix is less than the round-off of another one's: 0 then, or negative."""
    columns = np.linalg.qr(np.random.default_rng(0).standard_normal((50, 3)))[0] * [1e9, 1e-1, 1.0]
    compared = SimpleNamespace(equations=lambda *_: (np.zeros(50), columns))
    found = covariance_of(SimpleNamespace(deviation=np.array([np.inf, np.inf, 2.0])), compared)
    np.testing.assert_allclose(np.sqrt(np.diag(found)), [1e-9, 10.0, 1 / np.sqrt(1.25)], rtol=1e-6)
