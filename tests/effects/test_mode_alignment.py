"""Modes of a changed component beside those before."""

import numpy as np
import pytest

from updamp.effects.mode_alignment import ModesDifferError, alignment
from updamp.hbm.problem.linear_model import LinearModel

OWNER = ("blade",) * 3


def component(omega_squared: list[float], phi: np.ndarray) -> LinearModel:
    n, m = phi.shape
    nothing = np.zeros((m, m))
    return LinearModel(np.array(omega_squared), phi, np.zeros((n, n)), nothing, nothing, n, ())


def turned(degrees: float) -> np.ndarray:
    """(3, 3) of the last two modes"""
    c, s = np.cos(np.radians(degrees)), np.sin(np.radians(degrees))
    return np.array([[1, 0, 0], [0, c, -s], [0, s, c]])


SHAPES = np.random.default_rng(5).standard_normal((12, 3))


def test_modes_that_turn_towards_each_other_without_meeting_are_combined():
    """Squared frequencies 4.4 % apart, where a change of 2 % in a dimension moves them by 0 to 3.8 %: they cannot meet,
    and turn by 34 degrees."""
    before = component([1.0, 30.0, 31.32], SHAPES)
    after = component([1.038, 30.3, 32.0], SHAPES @ turned(34))
    Q = alignment(before, after, OWNER)
    np.testing.assert_allclose(Q @ Q.T, np.eye(3), atol=1e-12)
    np.testing.assert_allclose(after.phi @ Q, SHAPES, atol=1e-12)


def test_modes_too_far_apart_to_turn_are_not_combined_however_alike_they_look():
    before = component([1.0, 30.0, 45.0], SHAPES)
    after = component([1.038, 30.3, 46.0], SHAPES @ turned(20))
    np.testing.assert_array_equal(alignment(before, after, OWNER), np.eye(3))


def test_a_mode_that_came_from_no_other_is_refused():
    shapes = np.linalg.qr(SHAPES)[0]
    before = component([1.0, 30.0, 45.0], shapes)
    with pytest.raises(ModesDifferError, match="a mode of blade turns by 50 degrees"):
        alignment(before, component([1.038, 30.3, 46.0], shapes @ turned(50)), OWNER)
