"""A hysteresis that a step has gone across is found, from either end."""

import numpy as np
import pytest

from updamp.hbm.contact.springs import CubicParameters, CubicSpring
from updamp.hbm.continuation.curve import CurveRequest, whole_curve
from updamp.hbm.continuation.sweeps import swept, turning_points
from updamp.hbm.harmonics import Harmonics
from updamp.hbm.problem.elements import ElementGroup
from updamp.hbm.problem.linear_model import from_matrices
from updamp.hbm.problem.system import Excitation, NonlinearSystem

OMEGA, DAMPING, FORCE = 2 * np.pi * 10.0, 0.01, 0.0042 * 1.002


def folds() -> list[float]:
    """Of u'' + 2 D u' + u + u^3 = F cos(w t) by one harmonic [w in 2 pi 10 Hz]: (k - W)^2 + 4 D^2 W = (F / a)^2 with
    k = 1 + 3/4 a^2 and W = w^2 along the upper flank."""
    a = np.linspace(0.1, 0.2, 200001)
    b = 1 + 0.75 * a**2 - 2 * DAMPING**2
    frequency = 10 * np.sqrt(b + np.sqrt(b**2 - (1 + 0.75 * a**2) ** 2 + (FORCE / a) ** 2))
    return sorted(frequency[turning_points(frequency)].tolist())


@pytest.mark.parametrize("upwards", [True, False])
def test_a_hysteresis_of_three_thousandths_of_a_half_width(upwards):
    """0.0003 Hz wide, where the force has just passed the one at which it begins."""
    free = from_matrices(np.eye(1), [[2 * DAMPING * OMEGA]], [[OMEGA**2]], [[1.0]], {"q": np.array([1.0])})
    spring = ElementGroup(CubicSpring(), CubicParameters(np.array([OMEGA**2])), np.array([[0]]))
    system = NonlinearSystem(free, (spring,), Harmonics((1,)), time_samples=32)
    driven = Excitation(free.row("q"), FORCE * OMEGA**2)
    curve = whole_curve(system, CurveRequest("m", driven, (9.0, 11.3), points=("q",), upwards=upwards))
    low, high = folds()
    assert high - low < 4e-4
    assert swept(curve, True).jumps == pytest.approx([high], abs=1e-5)
    assert swept(curve, False).jumps == pytest.approx([low], abs=1e-5)
