"""Peaks followed in force: against response curves, closed forms, and each other."""

import weakref
from dataclasses import replace
from itertools import pairwise

import numpy as np
import pytest
from scipy.special import ellipk
from support.peers import blades_and_damper_system, friction, one_degree_of_freedom, solved

from updamp.hbm.contact.jenkins_box import JenkinsBox
from updamp.hbm.contact.springs import CubicParameters, CubicSpring
from updamp.hbm.continuation.continuation import ContinuationOptions
from updamp.hbm.continuation.curve import CurveRequest, trace
from updamp.hbm.harmonics import Harmonics
from updamp.hbm.newton.newton import NewtonOptions, Status
from updamp.hbm.problem.elements import ElementGroup
from updamp.hbm.problem.linear_model import from_matrices
from updamp.hbm.problem.system import Excitation, NonlinearSystem
from updamp.hbm.resonance import conditions, resonance_curve
from updamp.hbm.resonance.backbone import (
    ResonanceOptions,
    ResonanceStoppedError,
    first_resonance,
    follow_resonance,
    log_forces_passed,
)
from updamp.hbm.resonance.conditions import MaximumResonance, PhaseResonance
from updamp.hbm.resonance.linear_peak import linear_peak
from updamp.hbm.resonance.resonance import ResonanceProblem, at_phase, constant_force_plane
from updamp.hbm.resonance.resonance_curve import ResonanceRequest, trace_resonance, whole_resonance

FINE = ContinuationOptions(first_step=0.02, largest_step=0.05)
FORCES = (0.1, 20.0, 40.0, 80.0, 200.0)
WINDOW = (220.0, 250.0)
DUFFING_WINDOW = (0.5 / 2 / np.pi, 2.0 / 2 / np.pi)


@pytest.fixture(scope="module")
def blades():
    return blades_and_damper_system(JenkinsBox(2))


@pytest.fixture(scope="module")
def peaks(blades):
    *_, curve = trace_resonance(blades, ResonanceRequest("1", "excitation", "tip", WINDOW, FORCES, MaximumResonance()))
    return curve


@pytest.fixture(scope="module")
def duffing():
    d = solved("a_duffing_1dof")["definition"]
    group = ElementGroup(CubicSpring(), CubicParameters(np.array([d["g"]])), np.array([[0]]))
    return one_degree_of_freedom(d["c"], group, tuple(range(8)), 128), d


def _problem(system, excited="excitation", observed="tip"):
    return ResonanceProblem(system, system.free.row(excited), system.free.row(observed))


def test_the_mode_that_is_asked_for_is_followed_where_another_one_responds_more(blades):
    modes = blades.stuck.frequencies[:2]
    both = (0.9 * modes[0], 1.1 * modes[1])
    problem = _problem(blades)
    begun = [linear_peak(problem, both, 0.0, mode).w / (2 * np.pi) for mode in modes]
    np.testing.assert_allclose(begun, modes, rtol=1e-3)
    request = ResonanceRequest("1", "excitation", "tip", both, (1e-3, 1e-2), MaximumResonance())
    for mode in modes:
        curve = whole_resonance(blades, replace(request, mode_frequency=mode))
        np.testing.assert_allclose(curve.frequency, mode, rtol=1e-3)


def test_what_a_resonance_ends_with_is_all_that_is_kept(blades, monkeypatch):
    alive, most = weakref.WeakSet(), 0

    class State:
        pass

    def states(*_):
        nonlocal most
        for _ in range(10):
            state = State()
            alive.add(state)
            most = max(most, len(alive))
            yield state

    monkeypatch.setattr(resonance_curve, "trace_resonance", states)
    whole_resonance(blades, ResonanceRequest("1", "excitation", "tip", WINDOW, (1.0,), MaximumResonance()))
    assert most <= 3


def test_all_forces_are_met_and_every_point_is_converged(peaks):
    assert peaks.complete
    np.testing.assert_allclose(peaks.at_forces().force, FORCES)
    assert (peaks.error < NewtonOptions().tolerance).all()


@pytest.mark.parametrize("force", [20.0, 40.0, 80.0, 200.0])
def test_peak_is_that_of_the_response_curve(blades, peaks, force):
    """From first slip to separation at many contacts; the curve is traced in steps four times finer than usual."""
    *_, curve = trace(
        blades,
        CurveRequest("1", Excitation(blades.free.row("excitation"), force), (222.0, 236.0), ("tip",), options=FINE),
    )
    frequency, receptance = curve.peak("tip")
    i = FORCES.index(force)
    at = peaks.at_forces()
    assert np.abs(at.receptance[i]) == pytest.approx(receptance, rel=1e-3)
    assert at.frequency[i] == pytest.approx(frequency, rel=1e-4)


def test_duffing_peaks_of_three_codes(duffing):
    """Peak and phase resonance of the overhanging branch, and the first harmonic's closed form at phase resonance."""
    system, d = duffing
    w, amplitude = solved("a_duffing_1dof")["peak"]["tmdsimpy_parabola"]
    problem = _problem(system, "mass", "mass")
    top = first_resonance(problem, MaximumResonance(), DUFFING_WINDOW, d["P"])
    assert abs(top.amplitude) == pytest.approx(amplitude, rel=1e-5)
    assert top.w == pytest.approx(w, rel=1e-4)


def test_phase_resonance_of_the_duffing_oscillator(duffing):
    """At a quarter period's lag; the dashpot takes what the force gives, pi F a_1 = pi c w sum k^2 a_k^2."""
    system, d = duffing
    request = ResonanceRequest("1", "mass", "mass", DUFFING_WINDOW, (1e-3, 0.3), PhaseResonance())
    *_, curve = trace_resonance(system, request)
    np.testing.assert_allclose(np.angle(curve.amplitude()), -np.pi / 2, atol=1e-6)
    squares = sum(k**2 * np.abs(curve.amplitude(k)) ** 2 for k in curve.orders)
    w = 2 * np.pi * curve.frequency
    np.testing.assert_allclose(d["c"] * w * squares, curve.force * np.abs(curve.amplitude()), rtol=1e-8)
    np.testing.assert_allclose(curve.loss_factor, d["c"] / w, rtol=1e-7)


def test_a_resonance_that_ends_early_says_why(duffing):
    request = ResonanceRequest(
        "1", "mass", "mass", DUFFING_WINDOW, (1e-3, 0.3), PhaseResonance(), options=ResonanceOptions(max_points=3)
    )
    curve = whole_resonance(duffing[0], request)
    assert not curve.complete
    assert curve.stopped.startswith(f"max_points = 3 were used up at {curve.force[-1]:.4g} N")
    assert resonance_curve._why_short([0.1, 0.2, 0.25, 0.15, 0.09], request) == (
        "the resonance turned back in force, beyond 0.25 N"
    )


def test_maximum_is_a_maximum(blades):
    """Neighbours in phase, at the same force and solved afresh, are lower on both sides."""
    top = first_resonance(_problem(blades), MaximumResonance(1e-4), WINDOW, 40.0)
    for turn in (-0.05, 0.05):
        beside = at_phase(
            top.problem,
            replace(top.state, phase=top.state.phase + turn),
            constant_force_plane(top.state),
            NewtonOptions(),
        )
        assert beside.converged
        assert abs(beside.amplitude) < abs(top.amplitude)


def test_the_largest_response_that_was_tried_is_no_maximum(blades):
    """Two phases tried, both on the same side of the maximum."""
    problem = _problem(blades)
    top = first_resonance(problem, MaximumResonance(), WINDOW, 40.0)
    condition = MaximumResonance(tries=2, followed=top.state.phase + 0.7)
    found = condition.at_force(problem, top.state, NewtonOptions())
    assert found.status is Status.TOO_MANY_ITERATIONS
    assert abs(found.linearised.lag_to_maximum) > condition.tolerance


def test_what_lies_elsewhere_however_small_the_turn_is_not_taken(blades, monkeypatch):
    """A corrector that always ends on another branch, twice as large."""
    top = first_resonance(_problem(blades), MaximumResonance(), WINDOW, 0.1)
    elsewhere = replace(top, state=replace(top.state, z=2 * top.state.z))
    monkeypatch.setattr(conditions, "at_phase", lambda *_: elsewhere)
    assert elsewhere.converged
    found = conditions.turned(_problem(blades), top, 0.1, NewtonOptions(), ResonanceOptions())
    assert found.status is Status.OFF_BRANCH


def test_a_maximum_beyond_the_half_power_points_is_not_what_is_followed(blades):
    """A linear resonance, the phase followed 60 degrees off that of its maximum, and 30 degrees."""
    problem = _problem(blades)
    peak = linear_peak(problem, WINDOW, np.log(0.1))
    far, near = (MaximumResonance(followed=peak.phase + np.radians(off)) for off in (60.0, 30.0))
    assert far.at_force(problem, peak, NewtonOptions()).status is Status.NO_MAXIMUM
    assert near.at_force(problem, peak, NewtonOptions()).w == pytest.approx(peak.w, rel=1e-6)
    curve = whole_resonance(blades, ResonanceRequest("1", "excitation", "tip", WINDOW, (0.1, 0.2), far))
    assert "no maximum of the response between the half-power points" in curve.stopped
    assert "trace the response curve" in curve.stopped


def test_where_there_is_no_maximum_at_the_force_wanted_that_is_said_at_once(monkeypatch):
    """An oscillator with a nonlinear energy sink: beside its quasiperiodic zone the response at the phase followed is
    no maximum. It was asked for again from a thousand points 1e-4 apart, for 20 minutes."""
    relative = np.array([1.0, -1.0])
    sink = 0.002 * np.outer(relative, relative)
    K = np.diag([1.0, 0.0]) + 1e-9 * np.eye(2)
    points = {"mass": np.array([1.0, 0.0])}
    linear = from_matrices(np.diag([1.0, 0.05]), np.diag([0.002, 0.0]) + 2.5 * sink, K, relative[None], points)
    group = ElementGroup(CubicSpring(), CubicParameters(np.array([0.025])), np.array([[0]]))
    system, asked, at_force = (
        NonlinearSystem(linear, (group,), Harmonics((1, 3, 5)), 128),
        [],
        MaximumResonance.at_force,
    )

    def counted(condition, problem, guess, options):
        asked.append(guess)
        return at_force(condition, problem, guess, options)

    monkeypatch.setattr(MaximumResonance, "at_force", counted)
    curve = whole_resonance(
        system, ResonanceRequest("1", "mass", "mass", (0.1, 0.24), (0.01, 0.03), MaximumResonance())
    )
    assert "no maximum of the response between the half-power points" in curve.stopped
    assert curve.at_forces().force == pytest.approx([0.01])
    assert len(asked) < 20


def test_with_modes_close_together_the_peak_has_another_phase(blades):
    """Two stuck modes within 2 %: at a quarter period's lag the response is 0.7 % below its peak."""
    problem = _problem(blades)
    quarter = first_resonance(problem, PhaseResonance(), WINDOW, 0.1)
    top = first_resonance(problem, MaximumResonance(), WINDOW, 0.1)
    assert np.degrees(top.state.phase) == pytest.approx(-83.4, abs=0.1)
    assert abs(quarter.amplitude) / abs(top.amplitude) == pytest.approx(0.9933, abs=1e-4)
    turned = first_resonance(problem, PhaseResonance(top.state.phase), WINDOW, 0.1)
    assert turned.w == pytest.approx(top.w, rel=1e-7)


def test_down_and_up_are_the_same_branch(blades, peaks):
    request = ResonanceRequest("1", "excitation", "tip", WINDOW, (200.0, 80.0), MaximumResonance())
    *_, down = trace_resonance(blades, request)
    assert down.complete
    up = peaks.at_forces()
    np.testing.assert_allclose(np.abs(down.at_forces().receptance), np.abs(up.receptance[[4, 3]]), rtol=1e-4)


def test_damping_of_a_linear_oscillator_two_ways(duffing):
    system, d = duffing
    request = ResonanceRequest("1", "mass", "mass", DUFFING_WINDOW, (1e-4, 2e-4), MaximumResonance())
    *_, curve = trace_resonance(system, request)
    w = 2 * np.pi * curve.frequency
    np.testing.assert_allclose(curve.loss_factor, d["c"] / w, rtol=1e-8)
    np.testing.assert_allclose(curve.damping_from_phase, d["c"] / 2, rtol=1e-3)


def test_damping_with_friction(peaks):
    """Energy and phase slope agree at the peak within the disturbance by the neighbouring mode; the friction's share
    rises from nothing."""
    at = peaks.at_forces()
    np.testing.assert_allclose(at.damping_from_phase, at.damping_ratio, rtol=0.08)
    share = at.friction_loss / at.work_in
    assert share[0] < 1e-9
    assert (np.diff(share) > 0).all()
    np.testing.assert_array_equal(at.states.sum(axis=1), 20)
    np.testing.assert_array_equal(at.states[0], [20, 0, 0, 0])
    assert (at.states[-1, 1:3] > 0).all()


def test_equivalent_frequency_against_amplitude(duffing):
    """The backbone is the frequency of free vibration at that amplitude, an elliptic integral in closed form."""
    system, d = duffing
    request = ResonanceRequest("1", "mass", "mass", DUFFING_WINDOW, (1e-3, 0.3), PhaseResonance())
    *_, curve = trace_resonance(system, request)
    largest = np.abs(curve.response @ system.harmonics.synthesis(2048).T).max(axis=1)
    stiffening = d["g"] * largest**2
    exact = np.pi * np.sqrt(1 + stiffening) / (2 * ellipk(stiffening / (2 * (1 + stiffening))))
    np.testing.assert_allclose(2 * np.pi * curve.frequency, exact, rtol=1e-4)
    assert exact[-1] > 1.4
    assert abs(curve.amplitude(3)[-1] / curve.amplitude()[-1]) > 0.02


@pytest.mark.parametrize("rising", [True, False])
def test_a_force_met_exactly_is_met_once_whichever_way(rising):
    """A step of continuation may end on a force that is asked for to the last digit."""
    path = [0.0, 0.5, 1.0, 1.5] if rising else [1.5, 1.0, 0.5, 0.0]
    met = [level for here, there in pairwise(path) for level in log_forces_passed(path[1:], here, there)]
    assert met == path[1:]


def test_what_cannot_be_followed_says_where(blades):
    hopeless = ResonanceOptions(
        first_step=0.4, smallest_step=0.39, largest_step=0.4, newton=NewtonOptions(tolerance=1e-13, iterations=1)
    )
    problem = _problem(blades)
    with pytest.raises(ResonanceStoppedError, match=r"N, .* Hz: .*residual"):
        list(follow_resonance(problem, PhaseResonance(), WINDOW, (5.0, 100.0), hopeless))


def test_steps_that_are_solved_elsewhere_are_not_told_as_too_few_samples(blades):
    no_step_counts = ResonanceOptions(straight=1.0)
    with pytest.raises(ResonanceStoppedError, match=r"N, .* Hz: solved, but off the branch; each step") as stop:
        list(follow_resonance(_problem(blades), PhaseResonance(), WINDOW, (5.0, 100.0), no_step_counts))
    assert stop.value.error < 1e-6


def test_a_resonance_that_ends_before_its_force_says_so(blades):
    """Begun at a smaller force, since at this one it is not met from the linear peak, and given two points."""
    short = ResonanceOptions(max_points=2, newton=NewtonOptions(iterations=4))
    with pytest.raises(ResonanceStoppedError, match=r"ended before the force asked for; .* trace the response curve"):
        first_resonance(_problem(blades), PhaseResonance(), WINDOW, 200.0, short)


@pytest.mark.parametrize(
    ("call", "message"),
    [
        (lambda p: list(follow_resonance(p, PhaseResonance(), WINDOW, ())), "give one, or several"),
        (lambda p: list(follow_resonance(p, PhaseResonance(), WINDOW, (1.0, 3.0, 2.0))), "rise, or fall"),
        (lambda p: first_resonance(p, PhaseResonance(), WINDOW, 0.0), "force = 0"),
        (lambda p: linear_peak(p, (1.0, 2.0), 0.0), "no mode between 1 and 2 Hz"),
        (lambda _: MaximumResonance(tolerance=1.0), "tolerance = 1.0"),
        (lambda _: ResonanceOptions(first_step=1.0), "first_step"),
        (lambda _: ResonanceOptions(max_points=1), "max_points"),
    ],
)
def test_bad_input_is_named(blades, call, message):
    with pytest.raises(ValueError, match=message):
        call(_problem(blades))


def test_a_resonance_that_does_not_begin_has_no_point_and_says_why(blades):
    hopeless = ResonanceOptions(newton=NewtonOptions(iterations=1), lowest_start=0.9)
    request = ResonanceRequest("1", "excitation", "tip", WINDOW, (200.0,), MaximumResonance(), options=hopeless)
    curve = whole_resonance(blades, request)
    assert len(curve) == len(curve.receptance) == len(curve.at_forces()) == len(curve.passes(200.0)) == 0
    assert curve.amplitude().shape == (0,)
    assert "too many iterations" in curve.stopped


def test_a_resonance_begins_with_contacts_as_they_are_at_rest():
    """A mass on a spring beside a contact that is open at rest: the resonance begins as that of the spring alone, at
    half of the frequency with the contact closed, which lies in the window too."""
    gap = friction(1, mu=0.1, kt=3.0, kn=3.0, n0=np.zeros(1))._replace(gap=np.ones(1))
    one = np.eye(3)
    linear = from_matrices(one, 0.01 * one, one, one, {"mass": one[2]})
    contact = ElementGroup(JenkinsBox(2), gap, np.array([[0, 1, 2]]))
    system = NonlinearSystem(linear, (contact,), Harmonics((0, 1, 2, 3)), 256)
    assert system.stuck.frequencies[0] == pytest.approx(2 / 2 / np.pi)
    window = (0.5 / 2 / np.pi, 2.5 / 2 / np.pi)
    request = ResonanceRequest("1", "mass", "mass", window, (1e-3, 0.009, 0.02), MaximumResonance())
    curve = whole_resonance(system, request)
    assert curve.complete, curve.stopped
    at = curve.at_forces()
    assert at.frequency[:2] == pytest.approx(1 / 2 / np.pi, rel=1e-4), "amplitudes of 0.1 and 0.9 of the gap"
    assert np.abs(at.receptance[:2]) == pytest.approx(100, rel=1e-4), "1 / c"
    assert at.frequency[2] > 1.05 * at.frequency[0], "the contact closes"


def test_a_mode_without_damping_has_no_resonance_to_begin_at():
    group = ElementGroup(CubicSpring(), CubicParameters(np.ones(1)), np.array([[0]]))
    request = ResonanceRequest("1", "mass", "mass", DUFFING_WINDOW, (0.1,), MaximumResonance())
    with pytest.raises(ValueError, match="has no damping"):
        whole_resonance(one_degree_of_freedom(0.0, group, (1, 3), 64), request)


def test_gyroscopic_terms_are_refused_with_what_can_be_done():
    """Two masses, coupled by their velocities; curves of them are traced."""
    C = 0.02 * np.eye(2) + 0.3 * np.array([[0.0, 1.0], [-1.0, 0.0]])
    linear = from_matrices(np.eye(2), C, np.eye(2), np.array([[1.0, 0.0]]), {"mass": np.array([1.0, 0.0])})
    group = ElementGroup(CubicSpring(), CubicParameters(np.ones(1)), np.array([[0]]))
    system = NonlinearSystem(linear, (group,), Harmonics((1, 3)), 64)
    request = ResonanceRequest("1", "mass", "mass", (0.1, 0.3), (0.01,), MaximumResonance())
    with pytest.raises(ValueError, match=r"not symmetric .*trace the response curve"):
        whole_resonance(system, request)


def test_a_window_that_no_curve_can_have_is_refused_of_a_resonance_too():
    with pytest.raises(ValueError, match=r"window = 0 to 2 Hz: .* above 0"):
        ResonanceRequest("1", "excitation", "tip", (0.0, 2.0), (1.0,), MaximumResonance())
