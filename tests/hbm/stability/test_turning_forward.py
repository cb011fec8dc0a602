"""The point at which a branch turns forward again, on whichever side of the fold it lies."""

import numpy as np
import pytest

from updamp.hbm.contact.springs import CubicParameters, CubicSpring, QuinticSpring
from updamp.hbm.continuation.curve import CurveRequest, whole_curve
from updamp.hbm.continuation.sweeps import turning_points
from updamp.hbm.harmonics import Harmonics
from updamp.hbm.problem.elements import ElementGroup
from updamp.hbm.problem.linear_model import from_matrices
from updamp.hbm.problem.system import Excitation, NonlinearSystem
from updamp.hbm.stability.branch_stability import WHOLE, State, between_turning_points, branch_stability


@pytest.mark.parametrize("whole", [WHOLE, 0])
def test_the_point_at_which_a_branch_turns_forward_is_computed(monkeypatch, whole):
    """It may lie beyond the fold: it counted to the part before it, and was told unstable without being computed. Of an
    oscillator that softens and then hardens, in all points and in a share of them."""
    monkeypatch.setattr("updamp.hbm.stability.branch_stability.WHOLE", whole)
    springs = (
        ElementGroup(CubicSpring(), CubicParameters(np.array([-0.5])), np.array([[0]])),
        ElementGroup(QuinticSpring(), CubicParameters(np.array([0.15])), np.array([[1]])),
    )
    linear = from_matrices(np.eye(1), 0.02 * np.eye(1), np.eye(1), np.ones((2, 1)), {"mass": np.ones(1)})
    system = NonlinearSystem(linear, springs, Harmonics((1, 3, 5)), 256)
    request = CurveRequest("1", Excitation(system.free.row("mass"), 0.05), (0.08, 0.25), ("mass",))
    curve = whole_curve(system, request)
    found, against = branch_stability(system, curve, "mass"), between_turning_points(curve.frequency)
    forward = [i for i in turning_points(curve.frequency) if against[i]]
    assert len(forward) == 2
    assert found.computed[forward].all()
    for i in forward:
        grows = _largest_multiplier(curve, i) > 1
        assert found.state[i] == (State.UNSTABLE if grows else State.STABLE)
    assert State.STABLE in found.state[forward]


def _largest_multiplier(curve, place):
    """Of the oscillator above, about its motion, by Runge and Kutta."""
    harmonics, w, n = Harmonics(curve.orders), 2 * np.pi * curve.frequency[place], 2000
    u = harmonics.synthesis(2 * n) @ curve.displacement[place, 0]
    stiffness = 1 - 1.5 * u**2 + 0.75 * u**4
    rates = [np.array([[0.0, 1.0], [-k, -0.02]]) for k in [*stiffness, stiffness[0]]]
    h, P = 2 * np.pi / w / n, np.eye(2)
    for A, B, C in zip(rates[:-1:2], rates[1::2], rates[2::2], strict=True):
        a = A @ P
        b = B @ (P + h / 2 * a)
        c = B @ (P + h / 2 * b)
        P = P + h / 6 * (a + 2 * b + 2 * c + C @ (P + h * c))
    return np.abs(np.linalg.eigvals(P)).max()
