"""Points that do not move at the frequency of the force: their peaks are none, and spoil nothing of the others'."""

import jax.numpy as jnp
import numpy as np
import pytest

from updamp.hbm.contact.springs import CubicParameters, CubicSpring
from updamp.hbm.continuation.curve import CurveRequest, whole_curve
from updamp.hbm.harmonics import Harmonics
from updamp.hbm.problem.elements import ElementGroup
from updamp.hbm.problem.linear_model import from_matrices
from updamp.hbm.problem.system import Excitation, NonlinearSystem

COUPLED = np.array([[1.3, -0.3], [-0.3, 1.3]])
WINDOW = (0.1, 0.25)  # [Hz]


def traced(told, upwards=True):
    """Two equal masses on equal cubic springs, driven alike: their difference is zero, up to round-off."""
    rows = np.eye(2)
    points = {"sum": np.ones(2), "difference": np.array([1.0, -1.0])}
    linear = from_matrices(np.eye(2), 0.02 * np.eye(2), COUPLED, rows, points)
    springs = ElementGroup(CubicSpring(), CubicParameters(jnp.array([0.1, 0.1])), np.array([[0], [1]]))
    system = NonlinearSystem(linear, (springs,), Harmonics((1, 3)), time_samples=64)
    request = CurveRequest("1", Excitation(linear.row("sum"), 0.02), WINDOW, tuple(points), upwards=upwards, told=told)
    return whole_curve(system, request)


@pytest.mark.parametrize("upwards", [True, False])
def test_a_point_at_rest_among_those_told_leaves_the_others_as_they_are(upwards):
    alone, both = traced(("sum",), upwards), traced(("sum", "difference"), upwards)
    assert both.complete
    assert np.array_equal(both.frequency, alone.frequency)
    assert both.peak("sum") == alone.peak("sum")
    assert both.peak("difference")[1] <= 1e-9 * both.peak("sum")[1]


def test_a_curve_that_is_to_tell_the_peak_of_such_a_point_says_that_there_is_none():
    curve = traced(("difference",))
    assert not curve.complete
    assert curve.stopped.startswith("'difference' does not move at the frequency of the force")
