"""A fit whose weights, learnt from what is left, make of each of two places the other one ends there."""

from types import SimpleNamespace

import numpy as np
import pytest
from support.small_model import parametrisation

from updamp.comparison.fit.fit import FitOptions, _Reached, _Rounds

P = parametrisation()
ROUNDS = _Rounds(P, None, None, None, FitOptions(), print, None, lambda _: False)  # type: ignore[arg-type]


def at(place: float, noise: float = 1.0, reach: float = 1.0) -> _Reached:
    best = SimpleNamespace(u=np.full(len(P), place), scatter=SimpleNamespace(noise=noise))
    return _Reached(best, reach, moved=False)  # type: ignore[arg-type]


@pytest.mark.parametrize(
    ("lately", "now", "circle"),
    [
        ([at(0.0), at(0.1, 1.1), at(0.0)], at(0.1, 1.1), 2),
        ([at(0.0), at(0.1, 1.1), at(0.2, 1.2)], at(1e-7), 3),
        ([at(0.0), at(0.0, 1.1)], at(0.0), 2),
        ([at(0.0), at(0.1, 1.1), at(0.2, 1.2)], at(0.3, 1.3), 0),
        ([at(0.1), at(0.0), at(0.0)], at(0.0), 0),  # it has not left
        ([at(0.0), at(0.1)], at(0.0), 0),  # with the same weights
        ([at(0.0), at(0.1, 1.1)], at(0.0, reach=0.5), 0),  # the next step is another one
        ([at(0.0), at(0.1, 1.1)], at(0.0, 1.1), 0),
    ],
)
def test_a_circle_is_what_was_gone_through_since_the_same_place(lately, now, circle) -> None:
    found = ROUNDS.circle(lately, now)
    assert len(found) == circle
    assert not circle or found[-1] is now
