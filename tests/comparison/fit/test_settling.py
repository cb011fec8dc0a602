"""When a fit ends: the loop alone, on numbers that a fit beside jumps had (a flexible clamp, 27 November 2026)."""

from dataclasses import dataclass
from types import SimpleNamespace

import numpy as np
import pytest

from updamp.comparison.fit import fit as loop

# Twice the negative logarithm of the probability at two stiffnesses, on branches traced there and on moved ones; where
# first order leads to from such a value, and how much lower it promises to be.
TRACED, MOVED = {1.258: 2439.0, 1.608: 2446.0}, {1.258: 2442.5, 1.608: 2439.3}
AHEAD = {2439.0: (1.608, 3.3), 2442.5: (1.608, 3.3), 2446.0: (1.258, 5.5), 2439.3: (1.258, 5.5)}
MODEL = SimpleNamespace(deviation=np.array([1.0]))


@dataclass(frozen=True)
class At:
    stiffness: float
    objective: float
    weighed: float = 2400.0
    inflation: float = 1.0

    @property
    def scatter(self) -> SimpleNamespace:
        return SimpleNamespace(noise=1.0)

    @property
    def u(self) -> np.ndarray:
        return np.array([self.stiffness])


def fitted(monkeypatch, start, traced=TRACED, moved=MOVED, ahead=AHEAD):
    """What a fit says, and where it has traced branches; all that its loop calls is replaced by the numbers."""
    places: list[float] = []

    def of_trace(*given):
        there = given[2]
        places.append(there.stiffness)
        return At(there.stiffness, traced[there.stiffness])

    def of_round(*given):
        best = given[2]
        place, gain = ahead[best.objective]
        return At(place, best.objective - gain)

    monkeypatch.setattr(loop, "_traced", of_trace)
    monkeypatch.setattr(loop, "_moved", lambda *given: At(given[2].stiffness, moved[given[2].stiffness]))
    monkeypatch.setattr(loop, "one_round", of_round)
    monkeypatch.setattr(loop, "reweighed", lambda *given: given[2])
    monkeypatch.setattr(loop, "objective", lambda *given: given[1].objective)
    monkeypatch.setattr(loop, "compared_at_start", lambda *given: At(float(given[1][0]), moved[float(given[1][0])]))
    monkeypatch.setattr(loop, "prior_scatter", lambda *_: None)
    monkeypatch.setattr(loop, "_weighed", lambda *given: given[2])
    monkeypatch.setattr(loop, "_fall", lambda *_: "")
    monkeypatch.setattr(loop, "_result", lambda *given: given[1:3])
    return *loop.fit(MODEL, None, np.array([start]), None, [], loop.FitOptions()), places


@pytest.mark.parametrize("start", sorted(TRACED))
def test_places_that_first_order_leads_to_and_fro_between_end_a_fit(monkeypatch, start):
    """A small gain is promised at one of them, more on the way back: for 60 rounds when the branches were traced where
    first order leads to, not where the fit stands."""
    _, message, places = fitted(monkeypatch, start)
    assert message == loop.SETTLED
    assert len(places) <= 3


def test_no_fit_ends_higher_than_where_it_was_traced(monkeypatch):
    """Where what was moved seemed lower and is not."""
    at, message, _ = fitted(
        monkeypatch,
        1.258,
        traced={1.258: 2439.0, 1.608: 2446.0},
        moved={1.258: 2440.0, 1.608: 2430.0},
        ahead={2440.0: (1.258, 0.0), 2439.0: (1.608, 9.0), 2430.0: (1.608, 0.0), 2446.0: (1.608, 0.0)},
    )
    assert at.stiffness == 1.258, (at, message)


def test_a_fit_does_not_end_short_of_where_a_derivative_leaps(monkeypatch):
    """A gap at the edges that opens at 0.3 of its typical size: up to there first order promises little, from there on
    much (case 002 of the draw 30138193)."""
    places = {0.27: 317.3, 0.31: 308.0, 0.51: 193.0}
    ahead = {317.3: (0.31, 0.4), 308.0: (0.51, 115.0), 193.0: (0.51, 0.0)}
    at, message, _ = fitted(monkeypatch, 0.27, traced=places, moved=places, ahead=ahead)
    assert (at.stiffness, message) == (0.51, loop.SETTLED)


def test_a_promise_of_little_that_is_not_kept_ends_where_it_was_solved(monkeypatch):
    places = {0.27: 317.3, 0.31: 318.0}
    at, message, _ = fitted(
        monkeypatch, 0.27, traced=places, moved=places, ahead={317.3: (0.31, 0.4), 318.0: (0.27, 5.0)}
    )
    assert (at.stiffness, message) == (0.27, loop.SETTLED)
