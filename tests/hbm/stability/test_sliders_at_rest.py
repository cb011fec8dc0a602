"""Sliders that stand still in a motion: beside elements that move on, and where what grows moves them."""

import jax.numpy as jnp
import numpy as np

from updamp.hbm.contact.friction import FrictionParameters
from updamp.hbm.contact.jenkins_box import JenkinsBox
from updamp.hbm.contact.springs import CubicParameters, CubicSpring
from updamp.hbm.continuation.curve import CurveRequest, whole_curve
from updamp.hbm.harmonics import Harmonics
from updamp.hbm.problem.elements import ElementGroup
from updamp.hbm.problem.linear_model import LinearModel, from_matrices
from updamp.hbm.problem.system import Excitation, NonlinearSystem
from updamp.hbm.stability.branch_stability import State, between_turning_points, branch_stability


def box(rows: list[int], mu: float, kt: float, kn: float, n0: float) -> ElementGroup:
    mu_, kt_, kn_, n0_, gap = (jnp.array([v]) for v in (mu, kt, kn, n0, 0.0))
    return ElementGroup(JenkinsBox(), FrictionParameters(mu_, kt_, kn_, n0_, jnp.zeros((1, 2)), gap), np.array([rows]))


def structure(mass: object, damping: object, stiffness: object, relative: object, load: list[float]) -> LinearModel:
    matrices = (np.array(one, dtype=float) for one in (mass, damping, stiffness, relative))
    return from_matrices(*matrices, {"load": np.array(load), "q0": np.array([1.0, 0.0])})


def test_a_friction_contact_that_sticks_beside_a_cubic_spring_leaves_the_stability_known():
    """A group of no loose elements could not be reshaped, and every point was unknown."""
    stiffness = np.array([[6e3, -2e3], [-2e3, 4e3]])
    free = structure(np.eye(2), 2e-4 * stiffness, stiffness, [[1, 0.2], [0.1, 1], [1, -0.5], [1, -1]], [1.0, 0.0])
    spring = ElementGroup(CubicSpring(), CubicParameters(jnp.array([1e7])), np.array([[3]]))
    groups = (box([0, 1, 2], 0.5, 1e3, 1e3, 1e3), spring)
    system = NonlinearSystem(free, groups, Harmonics(tuple(range(6))), time_samples=128)
    curve = whole_curve(system, CurveRequest("m", Excitation(free.row("load"), 2.0), (8.0, 20.0), points=("q0",)))
    found = branch_stability(system, curve, "q0")
    assert not [reason for reason in found.reasons if "reshape" in reason]
    state, against = np.array(found.state), between_turning_points(curve.frequency)
    assert (state[against][:-1] == State.UNSTABLE).all()  # the last one is the turning point itself
    assert np.mean(state == State.UNKNOWN) < 0.1


def test_between_turning_points_sliders_that_have_shaken_down_do_not_make_a_motion_stable():
    """Marched from there, it leaves (growth 0.37 to 0.45 1/s); all 26 points were told stable."""
    stiffness = np.array([[4e3, -4e3], [-4e3, 4e3]])
    free = structure(np.diag([1.0, 2.0]), 2e-4 * stiffness, stiffness, [[1, 0], [0, 1], [0.5, -1]], [1.0, 0.3])
    system = NonlinearSystem(free, (box([0, 1, 2], 0.5, 2e3, 3e3, 3.0),), Harmonics(tuple(range(6))), time_samples=256)
    curve = whole_curve(system, CurveRequest("m", Excitation(free.row("load"), 0.6), (6.0, 20.0), points=("q0",)))
    against = between_turning_points(curve.frequency)
    assert against.sum() > 5
    state = np.array(branch_stability(system, curve, "q0").state)
    assert (state[against][:-1] == State.UNSTABLE).all()  # the last one is the turning point itself
    assert state[~against][0] == State.STABLE
