"""Harmonic balance against marching in time: a damped system with three friction contacts, from stick to separation."""

import numpy as np
import pytest
from support.peers import friction
from support.time_march import march

from updamp.hbm.contact.jenkins_box import JenkinsBox
from updamp.hbm.continuation.continuation import first_point
from updamp.hbm.harmonics import Harmonics
from updamp.hbm.newton.observe import ContactState, contact_states
from updamp.hbm.problem.elements import ElementGroup
from updamp.hbm.problem.linear_model import from_matrices
from updamp.hbm.problem.system import Excitation, NonlinearSystem


def _structure():
    """Five degrees of freedom, damping 3 to 8 %, three contacts with all directions coupled."""
    rng = np.random.default_rng(4)
    omega = 2 * np.pi * np.array([80.0, 110.0, 190.0, 260.0, 420.0])
    M, K = np.eye(5), np.diag(omega**2)
    C = np.diag(2 * omega * np.array([0.03, 0.04, 0.05, 0.06, 0.08]))
    Q = rng.normal(size=(9, 5))
    return M, C, K, Q, np.array([1.0, 0.4, 0.2, 0.1, 0.3])


@pytest.mark.parametrize(
    ("force", "states"),
    [(0.5, {ContactState.STUCK}), (12.0, {ContactState.STICK_SLIP}), (400.0, {ContactState.SEPARATING})],
)
def test_periodic_response_agrees(force, states):
    M, C, K, Q, load = _structure()
    n0, kt, kn, mu = np.array([1.0, 1.2, 0.8]) * 4, 3e4, 4e4, 0.4
    linear = from_matrices(M, C, K, Q, {"load": load, "q0": np.eye(5)[0]})
    group = ElementGroup(JenkinsBox(2), friction(3, mu, kt, kn, n0), np.arange(9).reshape(3, 3))
    system = NonlinearSystem(linear, (group,), Harmonics(tuple(range(12))), 512)
    w = 2 * np.pi * 105.0
    solution = first_point(system, Excitation(linear.row("load"), force), w)
    assert solution.converged
    assert states <= set(contact_states(system, solution.x, w))

    every = np.ones(3)
    history = march(
        M, C, K, Q, (mu * every, kt * every, kn * every, n0), force * load, w,
        np.zeros(5), np.zeros(5), np.zeros((3, 2)), periods=60, steps=1024,
    )  # fmt: skip
    relative = history @ Q.T
    marched = Harmonics((0, 1, 2, 3)).analysis(1024) @ relative
    scale = np.abs(marched).max()
    np.testing.assert_allclose(solution.x[:, :7], marched.T, rtol=0, atol=0.005 * scale)
