"""Which fit counts of those made one after the other, each with the numerical error where the last one ended."""

from types import SimpleNamespace

import numpy as np
import pytest

from updamp.comparison.fit import own_numerics
from updamp.comparison.fit.own_numerics import OwnNumericsOptions, until_it_stays
from updamp.hbm.continuation.continuation import BranchStoppedError
from updamp.hbm.newton.newton import Status


def fit_at(place: float, misfit: float) -> SimpleNamespace:
    """One whose numerical error was asked for at the place that is the whole number below its own; half way to the
    next is as far as it may move."""
    values = 400
    compared = SimpleNamespace(mean_squared_misfit=misfit, chi2=misfit * values)
    return SimpleNamespace(place=place, compared=compared, freedom=values)


@pytest.fixture(autouse=True)
def how_far(monkeypatch) -> None:
    monkeypatch.setattr(own_numerics, "farthest_moved", lambda fit: 2 * (fit.place % 1) * OwnNumericsOptions().moved)


def one_after_the_other(places, misfits, options=OwnNumericsOptions()) -> float:
    """Where that ends."""
    fits = iter([fit_at(*each) for each in zip(places, misfits, strict=True)])
    plan = SimpleNamespace(noise_freedom=np.inf)
    return until_it_stays(next(fits), lambda _: next(fits), lambda fit: (fit, plan), options).place


@pytest.mark.parametrize(
    ("misfits", "ends"), [((1.0, 1.03, 1.02), 2.2), ((4.0, 4.1, 4.0), 1.6), ((4.0, 3.9, 3.9), 2.2)]
)
def test_within_the_scatter_an_error_that_belongs_counts_and_beyond_it_a_smaller_misfit(misfits, ends) -> None:
    assert one_after_the_other((1.6, 2.2, 3.2), misfits) == ends


def test_one_of_many_that_fails_goes_on_only_where_another_fall_as_large_would_explain_the_data() -> None:
    """Each time takes as long as all finer branches of all runs, and a wrong effect took four of them."""
    places, one_of_many = (1.6, 2.6, 3.6, 4.2), OwnNumericsOptions(given_up=True)
    assert one_after_the_other(places, (5.0, 4.2, 4.0, 3.9), one_of_many) == 2.6
    assert one_after_the_other(places, (5.0, 2.9, 1.0, 1.0), one_of_many) == 4.2
    assert one_after_the_other(places, (14.5, 12.0, 5.0, 0.86)) == 4.2


def test_it_ends_where_parameters_move_by_less_than_is_enough() -> None:
    assert one_after_the_other((1.4, 3.6), (1.0, 1.0)) == 1.4
    assert one_after_the_other((1.6, 2.7, 3.4), (1.0, 1.0, 1.0)) == 3.4


def test_it_is_asked_so_often_at_most() -> None:
    places, misfits = np.arange(6) + 0.9, 6 * (1.0,)
    assert one_after_the_other(places, misfits) == 4.9
    assert one_after_the_other(places, misfits, OwnNumericsOptions(again=0)) == 0.9


def test_where_a_finer_model_has_no_response_what_was_found_stands() -> None:
    def no_branch(_):
        raise BranchStoppedError(440.0, 1e-3, Status.STALLED)

    found = fit_at(1.9, 1.0)
    assert until_it_stays(found, no_branch, lambda fit: (fit, None)) is found
