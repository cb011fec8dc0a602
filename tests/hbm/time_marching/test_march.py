"""The march against closed forms, its own energy balance, and the harmonic balance with many harmonics."""

import numpy as np
import pytest
from support.peers import friction, one_degree_of_freedom, solved

from updamp.hbm.contact.jenkins import Jenkins, JenkinsParameters
from updamp.hbm.contact.jenkins_box import JenkinsBox
from updamp.hbm.contact.springs import CubicParameters, CubicSpring
from updamp.hbm.continuation.continuation import first_point
from updamp.hbm.harmonics import Harmonics
from updamp.hbm.newton.observe import ContactState, contact_states
from updamp.hbm.problem.elements import ElementGroup
from updamp.hbm.problem.linear_model import from_matrices
from updamp.hbm.problem.system import Excitation, NonlinearSystem
from updamp.hbm.time_marching.march import March

ROW = np.array([[0]])


def _marched(march, state, periods):
    for _ in range(periods):
        state, samples = march.period(state)
    return state, samples


@pytest.mark.parametrize("steps", [64, 128])
def test_a_free_decay_converges_with_the_square_of_the_step(steps):
    """A linear oscillator pushed off its periodic motion: what is added decays as e^(-c t / 2) cos(w_d t)."""
    c, w = 0.06, 1.3
    group = ElementGroup(CubicSpring(), CubicParameters(np.zeros(1)), ROW)
    system = one_degree_of_freedom(c, group, (0, 1), 16)
    excitation = Excitation(system.free.row("mass"), 1.0)
    x = first_point(system, excitation, w).x

    def off(n):
        march = March.of(system, excitation, excitation.row, w, n)
        start = march.start(system, x)
        pushed = start._replace(v=start.v + 0.5, a=start.a - c * 0.5, x=start.x, dx=0 * start.dx)
        end, _ = _marched(march, pushed, 3)
        t, damped = 3 * n * march.h, np.sqrt(1 - c**2 / 4)
        exact = 0.5 / damped * np.exp(-c * t / 2) * np.sin(damped * t)
        return float(end.q[0] * system.free.phi[0, 0] - start.q[0] * system.free.phi[0, 0]) - exact

    assert abs(off(steps)) < 40 / steps**2
    assert off(steps) / off(2 * steps) == pytest.approx(4, rel=0.05)


def test_forced_linear_motion_is_exact():
    group = ElementGroup(CubicSpring(), CubicParameters(np.zeros(1)), ROW)
    system = one_degree_of_freedom(0.01, group, (0, 1), 16)
    excitation = Excitation(system.free.row("mass"), 1.0)
    march = March.of(system, excitation, excitation.row, 1.0, 32)
    start = march.start(system, first_point(system, excitation, 1.0).x)
    end, samples = _marched(march, start, 5)
    np.testing.assert_allclose(end.q, start.q, atol=1e-9 * 100)
    assert np.abs(samples).max() == pytest.approx(100, rel=1e-6)


def test_jenkins_oscillator_is_that_of_many_harmonics():
    """The problem that another code has solved (tests/hbm/reference), near its resonance, settled."""
    d = solved("b_jenkins_1dof")["definition"]
    group = ElementGroup(Jenkins(), JenkinsParameters(np.array([d["kt"]]), np.array([d["muN"]])), ROW)
    system = one_degree_of_freedom(d["c"], group, tuple(range(20)), 1024)
    excitation = Excitation(system.free.row("mass"), d["P"])
    w = 1.3
    solution = first_point(system, excitation, w)
    slip = d["muN"] / d["kt"]
    assert np.hypot(*solution.x[0, 1:3]) > 1.2 * slip, "it slips"
    march = March.of(system, excitation, excitation.row, w, 512)
    _, samples = _marched(march, march.start(system, solution.x), 60)
    expected = system.harmonics.amplitude(solution.x[0], 1)
    assert abs(np.exp(-2j * np.pi * np.arange(512) / 512) @ samples / 256 - expected) < 1e-3 * abs(expected)


@pytest.fixture(scope="module")
def contacts():
    """Five degrees of freedom, three contacts with all directions coupled: that of test_time_integration."""
    rng = np.random.default_rng(4)
    omega = 2 * np.pi * np.array([80.0, 110.0, 190.0, 260.0, 420.0])
    C = np.diag(2 * omega * np.array([0.03, 0.04, 0.05, 0.06, 0.08]))
    Q, load = rng.normal(size=(9, 5)), np.array([1.0, 0.4, 0.2, 0.1, 0.3])
    linear = from_matrices(np.eye(5), C, np.diag(omega**2), Q, {"load": load})
    parameters = friction(3, 0.4, 3e4, 4e4, np.array([1.0, 1.2, 0.8]) * 4)
    group = ElementGroup(JenkinsBox(2), parameters, np.arange(9).reshape(3, 3))
    return NonlinearSystem(linear, (group,), Harmonics(tuple(range(12))), 256)


@pytest.mark.parametrize(("force", "state"), [(12.0, ContactState.STICK_SLIP), (400.0, ContactState.SEPARATING)])
def test_energy_balance_of_every_step(contacts, force, state):
    """Average acceleration: the change of energy is the work of the mean forces, to round-off, while contacts slip,
    open and close."""
    w, model = 2 * np.pi * 105.0, contacts.free
    excitation = Excitation(model.row("load"), force)
    x = first_point(contacts, excitation, w).x
    assert state in contact_states(contacts, x, w)
    march = March.of(contacts, excitation, excitation.row, w, 64)
    old, f_old, before = march.start(contacts, x), None, 1.0
    for i in range(1, 3 * 64 + 1):
        cosine = np.cos(2 * np.pi * i / 64)
        new, f, _ = march.step(old, cosine)
        if f_old is not None:
            dq, v = new.q - old.q, (new.v + old.v) / 2
            load = force * (cosine + before) / 2 * model.phi[excitation.row]
            work = dq @ (load - model.phi[:9].T @ (f + f_old) / 2) - march.h * v @ model.viscous @ v
            stored = [0.5 * (s.v @ s.v + model.omega_squared @ s.q**2) for s in (old, new)]
            assert stored[1] - stored[0] == pytest.approx(work, abs=1e-9 * stored[0])
        old, f_old, before = new, f, cosine


@pytest.mark.parametrize("force", [12.0, 400.0])
def test_steps_do_not_depend_on_the_inverse_that_is_kept(contacts, force):
    """Made anew for every step, or as the march goes."""
    w = 2 * np.pi * 105.0
    excitation = Excitation(contacts.free.row("load"), force)
    x = first_point(contacts, excitation, w).x
    kept, anew = (March.of(contacts, excitation, excitation.row, w, 64) for _ in range(2))
    one = other = kept.start(contacts, x)
    for i in range(128):
        cosine = np.cos(2 * np.pi * (i + 1) / 64)
        anew.equilibrium.tangents = []
        one, other = kept.step(one, cosine)[0], anew.step(other, cosine)[0]
    np.testing.assert_allclose(one.x, other.x, rtol=0, atol=1e-9 * np.abs(other.x).max())
