"""Intervals by profile likelihood: those by derivatives where chi-square is a parabola, and right where it is not."""

from dataclasses import dataclass, replace
from types import SimpleNamespace

import numpy as np
import pytest
from support.small_model import NUISANCES, condition, parametrisation, synthetic_plan

from updamp.comparison.fit import profile_likelihood as under_test
from updamp.comparison.fit.compared import Compared
from updamp.comparison.fit.fit import Fit, fit
from updamp.comparison.fit.profile_likelihood import Profile, profile
from updamp.comparison.prediction.numerical_error import NumericalError
from updamp.comparison.prediction.traced_branch import trace_branch
from updamp.hbm.continuation.continuation import BranchStoppedError
from updamp.hbm.newton.newton import Status

LOSS_FACTOR, FRICTION = 1, 2


def test_it_is_that_of_the_derivatives_where_chi_square_is_a_parabola():
    scatter = np.array([n.scatter for n in NUISANCES])
    conditions = (condition(10.0), condition(40.0))
    p, truth = parametrisation(), np.array([0.004, 0.1, 0.2, 0.0])
    plan, _ = synthetic_plan(p, truth, conditions, 1e-6 * scatter, seed=3, repeats=1)
    found = fit(p, plan, truth, at_start=[trace_branch(p, truth, c) for c in conditions])
    for place in (LOSS_FACTOR, FRICTION):
        lower, upper = profile(found, plan, place).interval
        half = 1.96 * found.uncertainty[place]
        assert (found.u[place] - lower, upper - found.u[place]) == pytest.approx((half, half), rel=0.02), place


@dataclass(frozen=True)
class At:
    """A fit with the parameter held"""

    value: float
    chi2: float

    @property
    def u(self) -> np.ndarray:
        return np.array([self.value])


def uneven(value: float) -> float:
    """A parabola about 0.8 with a deviation of 0.15, as the data have it, and a dent at 0.66 in which a fit ends."""
    return ((value - 0.8) / 0.15) ** 2 - 1.5 * np.exp(-(((value - 0.66) / 0.02) ** 2))


def profile_of(monkeypatch, chi2, at=0.66, deviation=0.1, lower=-5.0, upper=5.0):
    """Of a fit of one parameter whose derivatives tell a deviation"""
    monkeypatch.setattr(under_test, "_ready", lambda found, *_: found)
    monkeypatch.setattr(under_test._Work, "held", lambda _, value: At(value, chi2(value)))
    monkeypatch.setattr(under_test, "objective", lambda _, compared: compared.chi2)
    p = SimpleNamespace(lower=np.array([lower]), upper=np.array([upper]))
    known = np.array([deviation])
    found = SimpleNamespace(
        parametrisation=p, u=np.array([at]), deviations=known, uncertainty=known, covariance=np.diag(known**2),
        compared=At(at, chi2(at)),
    )  # fmt: skip
    return profile(found, None, 0)


def test_a_dent_that_a_fit_ends_in_does_not_make_it_surer_than_the_data_are(monkeypatch):
    lower, upper = profile_of(monkeypatch, uneven, deviation=0.08).interval
    assert lower == pytest.approx(0.8 - 1.96 * 0.15, abs=0.04)
    assert upper == pytest.approx(0.8 + 1.96 * 0.15, abs=0.04)


def test_what_is_held_elsewhere_counts_as_much_as_the_data_tell_it(monkeypatch):
    """With what finer numerics change among the unknowns a deviation is twice as large, and so is the interval."""
    monkeypatch.setattr(under_test._Work, "counts", 0.25)
    narrow = profile_of(monkeypatch, lambda v: (v / 0.1) ** 2, at=0.0, deviation=0.2).interval
    assert narrow == pytest.approx((-0.392, 0.392), rel=1e-6)


def test_what_the_data_do_not_tell_ends_at_the_bound(monkeypatch):
    found = profile_of(monkeypatch, lambda v: (max(v, 0.0) / 0.1) ** 2, at=0.0, lower=-0.3)
    assert found.told == (False, True)
    assert found.interval == pytest.approx((-0.3, 0.196), rel=1e-6)


def test_what_the_data_do_not_tell_at_all_is_open_from_bound_to_bound(monkeypatch):
    """An exponent of a loss that is nil: no derivative, and by derivatives no deviation."""
    assert profile_of(monkeypatch, lambda _: 0.0, deviation=0.0, lower=-1.0, upper=3.0).interval == (-1.0, 3.0)


def test_a_model_without_a_response_farther_out_ends_it_there(monkeypatch):
    def chi2(value):
        if value > 0.3:
            raise BranchStoppedError(10.0, 1.0, Status.STALLED)
        return (value / 0.5) ** 2

    found = profile_of(monkeypatch, chi2, at=0.0)
    assert found.told == (True, False)
    assert found.interval[0] == pytest.approx(-0.98, rel=1e-6)
    assert found.interval[1] == pytest.approx(0.196)


def test_numerical_error_is_taken_as_it_is_where_the_fit_ends(monkeypatch):
    """2 % of an amplitude, and 10 % more by a unit of the loss factor, which is 0.3 there: 5 % wherever it is held."""
    error, slopes = {"a run": np.array([[0.0, 0.02]])}, {"a run": np.array([[[0.0, 0.0], [0.0, 0.1]]])}
    numerics = NumericalError(("mesh",), error, error, about=np.zeros(2), by_parameter=slopes)
    compared = Compared(np.array([0.0, 0.3, 0.0]), (), (), (), {}, None, (), 0.0, 1.0)
    traced = []
    monkeypatch.setattr(under_test, "predict_branches", lambda p, u, *_: traced.append((p.numerics, u)) or ())
    there = under_test._ready(Fit(replace(parametrisation(), numerics=numerics), compared, np.eye(3), ""), None, None)
    for held in (traced[0][0], there.parametrisation.numerics):
        assert held.expected_at("a run", np.array([0.0, 0.7])) == pytest.approx(np.array([[0.0, 0.05]]))


def test_an_interval_has_no_holes():
    """Between two minima chi-square may be higher than at its ends."""
    found = Profile(np.array([0.0, 1.0, 2.0, 3.0, 4.0]), np.array([9.0, 0.0, 5.0, 1.0, 9.0]))
    assert found.interval == pytest.approx((1 - 1.96 / 3, 3 + 0.96 / 2))
