"""A branch ends at the end of its window, whichever end it was traced from."""

import numpy as np
import pytest

from updamp.hbm.contact.springs import CubicParameters, CubicSpring
from updamp.hbm.continuation.curve import CurveRequest, whole_curve
from updamp.hbm.harmonics import Harmonics
from updamp.hbm.problem.elements import ElementGroup
from updamp.hbm.problem.linear_model import from_matrices
from updamp.hbm.problem.system import Excitation, NonlinearSystem

OMEGA, TURN = 2 * np.pi * np.array([10.0, 20.0]), np.array([[np.cos(0.3), -np.sin(0.3)], [np.sin(0.3), np.cos(0.3)]])
LOAD = TURN @ [0.2, 1.0]
STIFFNESS, DAMPING = TURN @ np.diag(OMEGA**2) @ TURN.T, TURN @ np.diag([0.06, 0.004] * OMEGA) @ TURN.T


def receptance(frequency: float) -> float:
    w = 2 * np.pi * frequency
    return float(abs(np.linalg.solve(STIFFNESS - w**2 * np.eye(2) + 1j * w * DAMPING, LOAD)[0]))


@pytest.mark.parametrize("upwards", [True, False])
def test_a_neighbour_beyond_the_end_is_no_peak(upwards):
    """The last step went beyond the window, where the neighbour's flank is higher: not complete upwards, complete
    downwards."""
    free = from_matrices(np.eye(2), DAMPING, STIFFNESS, [[1.0, 0.0]], {"load": LOAD, "q0": np.array([1.0, 0.0])})
    next_to_linear = ElementGroup(CubicSpring(), CubicParameters(np.array([1e-3])), np.array([[0]]))
    system = NonlinearSystem(free, (next_to_linear,), Harmonics((0, 1, 2, 3)), time_samples=64)
    window = (5.0, 19.745)
    curve = whole_curve(
        system, CurveRequest("m", Excitation(free.row("load"), 1.0), window, points=("q0",), upwards=upwards)
    )
    assert curve.stopped == ""
    assert (curve.frequency.min(), curve.frequency.max()) == pytest.approx(window, rel=1e-12)
    top = max(np.linspace(9.9, 10.1, 2001), key=receptance)
    assert curve.peak("q0") == pytest.approx((top, receptance(top)), rel=1e-4)
