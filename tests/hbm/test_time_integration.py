"""Harmonic balance against marching in time: a damped system with three friction contacts, from stick to separation."""

import numpy as np
import pytest
from support.peers import friction
from support.time_march import marched_from_rest

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


W, N0 = 2 * np.pi * 105.0, np.array([1.0, 1.2, 0.8]) * 4
KT, KN, MU = 3e4, 4e4, 0.4
FORCES = {0.5: ContactState.STUCK, 12.0: ContactState.STICK_SLIP, 400.0: ContactState.SEPARATING}
# The slowest transient has decayed to 0.2 % after so many periods.
PERIODS, STEPS = 45, 512


@pytest.fixture(scope="module")
def marched():
    """Samples of the relative displacement over a period, by force."""
    M, C, K, Q, load = _structure()
    p = tuple(value * np.ones(3) for value in (MU, KT, KN, N0))
    samples = marched_from_rest(M, C, K, Q, p, np.outer(list(FORCES), load), W, PERIODS, STEPS)
    return dict(zip(FORCES, samples @ Q.T, strict=True))


@pytest.mark.parametrize("force", FORCES)
def test_periodic_response_agrees(marched, force):
    M, C, K, Q, load = _structure()
    linear = from_matrices(M, C, K, Q, {"load": load, "q0": np.eye(5)[0]})
    group = ElementGroup(JenkinsBox(2), friction(3, MU, KT, KN, N0), np.arange(9).reshape(3, 3))
    system = NonlinearSystem(linear, (group,), Harmonics(tuple(range(12))), 256)
    solution = first_point(system, Excitation(linear.row("load"), force), W)
    assert solution.converged
    assert FORCES[force] in contact_states(system, solution.x, W)
    expected = Harmonics((0, 1, 2, 3)).analysis(STEPS) @ marched[force]
    np.testing.assert_allclose(solution.x[:, :7], expected.T, rtol=0, atol=0.005 * np.abs(expected).max())
