"""Exponents against closed forms, turning points, and multipliers found by marching in time."""

from dataclasses import dataclass, replace
from typing import ClassVar

import jax.numpy as jnp
import numpy as np
import pytest
from support.peers import friction, one_degree_of_freedom, solved
from support.time_march import multipliers

from updamp.hbm.contact.jenkins import Jenkins, JenkinsParameters
from updamp.hbm.contact.jenkins_box import JenkinsBox
from updamp.hbm.contact.jenkins_box_sampled import SampledJenkinsBox
from updamp.hbm.contact.power_law_damper import PowerLawDamper, PowerLawParameters
from updamp.hbm.contact.springs import CubicParameters, CubicSpring
from updamp.hbm.continuation.continuation import first_point
from updamp.hbm.continuation.curve import CurveRequest, trace
from updamp.hbm.continuation.sweeps import turning_points
from updamp.hbm.harmonics import Harmonics
from updamp.hbm.newton.observe import ContactState, contact_states, response
from updamp.hbm.problem.elements import ElementGroup, element_forces
from updamp.hbm.problem.linear_model import from_matrices
from updamp.hbm.problem.system import Excitation, NonlinearSystem
from updamp.hbm.stability.branch_stability import (
    NOT_COMPUTED,
    State,
    between_turning_points,
    branch_stability,
    parts_of,
)
from updamp.hbm.stability.condensed_structure import condense
from updamp.hbm.stability.hill import HillProblem
from updamp.hbm.stability.perturbed_forces import perturbed_tangent
from updamp.hbm.stability.stability import StabilityOptions, stability
from updamp.hbm.stability.strip import Strip

ROW = np.array([[0]])
WINDOW = (0.5 / 2 / np.pi, 2.0 / 2 / np.pi)


def _curve(system, force):
    *_, curve = trace(system, CurveRequest("1", Excitation(system.free.row("mass"), force), WINDOW, ("mass",)))
    assert curve.complete
    return curve


@pytest.fixture(scope="module")
def duffing():
    d = solved("a_duffing_1dof")["definition"]
    group = ElementGroup(CubicSpring(), CubicParameters(np.array([d["g"]])), ROW)
    system = one_degree_of_freedom(d["c"], group, tuple(range(8)), 128)
    return system, _curve(system, d["P"]), d["c"]


def test_duffing_is_unstable_between_its_turning_points_and_stable_elsewhere(duffing):
    system, curve, c = duffing
    turns, against = turning_points(curve.frequency), between_turning_points(curve.frequency)
    assert 3 < against.sum() < len(curve) // 2
    for i in range(len(curve)):
        point = stability(system, curve.displacement[i], 2 * np.pi * curve.frequency[i], against=bool(against[i]))
        assert point.trusted, point.reason
        assert point.exponents.sum().real == pytest.approx(-c, rel=1e-9)
        if i not in turns:
            assert point.stable != against[i]
            assert (abs(point.decisive.imag) < 1e-9 and point.decisive.real > 0) == against[i]


def test_a_dashpot_as_an_element_is_the_same_as_in_the_structure():
    """Far below resonance all exponents decay faster than those that are looked for: stable, not unknown."""
    c, one = 0.3, np.eye(1)
    spring = ElementGroup(CubicSpring(), CubicParameters(np.array([1.0])), ROW)
    inside = one_degree_of_freedom(c, spring, tuple(range(6)), 128)
    dashpot = ElementGroup(PowerLawDamper(1.0), PowerLawParameters(np.array([c]), np.ones(1)), ROW + 1)
    linear = from_matrices(one, 0 * one, one, np.ones((2, 1)), {"mass": one[0]})
    outside = NonlinearSystem(linear, (spring, dashpot), inside.harmonics, 128)
    fast = []
    for w in (0.3, 0.5, 0.7, 1.2, 1.6, 1.9):
        x = first_point(inside, Excitation(inside.free.row("mass"), 0.6), w).x
        expected, found = stability(inside, x, w), stability(outside, np.vstack([x, x]), w)
        assert found.trusted
        assert found.stable == expected.stable
        fast.append(not len(found.exponents))
        if not fast[-1]:
            assert found.decisive.real == pytest.approx(expected.decisive.real, rel=1e-6)
    assert any(fast)
    assert not all(fast)


@dataclass(frozen=True)
class CentralSpring:
    """f = k |u|^2 u in two directions."""

    parameters: ClassVar[type] = CubicParameters
    directions: ClassVar[int] = 2
    rate_dependent: ClassVar[bool] = False

    def force(self, displacement, _velocity, parameters):
        return parameters.coefficient * jnp.sum(displacement**2, axis=1, keepdims=True) * displacement

    def reference_stiffness(self, _parameters):
        return jnp.zeros(2)


def test_a_direction_that_does_not_move_counts_all_the_same():
    """Driven along one direction alone, the spring acts on a motion of the other all the same."""
    k, w, a, c = 0.3, 1.26, 0.9, 0.02
    linear = from_matrices(np.eye(2), c * np.eye(2), np.diag([1.0, 1.02]), np.eye(2), {"drive": np.eye(2)[0]})
    group = ElementGroup(CentralSpring(), CubicParameters(np.array([k])), np.array([[0, 1]]))
    system = NonlinearSystem(linear, (group,), Harmonics((0, 1, 2, 3)), 128, as_a_whole=True)
    x = np.zeros((2, 7))
    x[0, 1] = a
    nudged = x.copy()
    nudged[1, 1] = 1e-7  # that way it is seen anyhow
    found, expected = (np.sort(stability(system, each, w).exponents.imag) for each in (x, nudged))
    np.testing.assert_allclose(found, expected, atol=1e-6)
    assert not np.isclose(np.abs(found), np.sqrt(1.02), atol=1e-3).any(), "as if the spring were not there"


@pytest.mark.parametrize("held", [1.0, 0.0])
def test_motions_without_damping_and_free_ones_do_not_grow(held):
    stiffness = np.array([[1.0, -1.0], [-1.0, 1.0]]) + held * np.eye(2)
    linear = from_matrices(np.eye(2), np.zeros((2, 2)), stiffness, np.array([[1.0, -1.0]]), {"drive": np.eye(2)[0]})
    parameters = JenkinsParameters(np.array([0.5]), np.array([100.0]))
    system = NonlinearSystem(linear, (ElementGroup(Jenkins(), parameters, ROW),), Harmonics((1, 3)), 64)
    found = stability(system, np.full((1, 4), 1e-3), 0.7)
    assert found.stable
    assert abs(found.decisive.real) < 1e-6


def test_a_curve_of_another_system_is_refused(duffing):
    system, curve, _ = duffing
    with pytest.raises(ValueError, match="give the system that it was traced on"):
        branch_stability(replace(system, harmonics=Harmonics((1, 3))), curve, "mass")


def test_the_determinant_tells_the_same_as_turning_points(duffing):
    system, curve, _ = duffing
    turns, against = turning_points(curve.frequency), between_turning_points(curve.frequency)
    for i in sorted(set(range(len(curve))) - set(turns)):
        problem = HillProblem(system, curve.displacement[i], 2 * np.pi * curve.frequency[i], 7, 128)
        assert (problem.determinant_sign < 0) == against[i]


def test_of_a_small_system_every_point_is_computed_but_between_turning_points(duffing):
    system, curve, _ = duffing
    found, against = branch_stability(system, curve, "mass"), between_turning_points(curve.frequency)
    assert found.computed[~against].all()
    assert 0 < found.computed[against].sum() < against.sum()
    for i in np.flatnonzero(found.computed):
        point = stability(system, curve.displacement[i], 2 * np.pi * curve.frequency[i], against=bool(against[i]))
        assert found.growth[i] == point.decisive.real


def test_a_branch_is_judged_from_some_of_its_points_as_from_all(duffing, monkeypatch):
    monkeypatch.setattr("updamp.hbm.stability.branch_stability.WHOLE", 0)
    system, curve, _ = duffing
    shares = []
    found = branch_stability(system, curve, "mass", report=shares.append)
    turns, against = turning_points(curve.frequency), between_turning_points(curve.frequency)
    assert found.computed.sum() < len(curve)
    assert shares == sorted(shares)
    # at a turning point, which is solved, an exponent is zero: neither stable nor unstable
    for i in sorted(set(range(len(curve))) - set(turns)):
        assert found.state[i] == (State.UNSTABLE if against[i] else State.STABLE)
    low, high = found.ranges(curve.frequency, State.UNSTABLE)[0]
    inside = np.setdiff1d(np.flatnonzero(against), turns)
    assert curve.frequency[inside].min() == pytest.approx(low, rel=1e-2)
    assert curve.frequency[inside].max() == pytest.approx(high, rel=1e-2)


def test_what_cannot_be_computed_is_unknown_with_the_reason(duffing, monkeypatch):
    system, curve, _ = duffing

    def broken(*_, **__):
        raise ValueError("no exponents today")

    monkeypatch.setattr("updamp.hbm.stability.branch_stability.stability", broken)
    found = branch_stability(system, curve, "mass")
    assert (found.state == State.UNKNOWN).all()
    reasons = [found.reasons[i] for i in found.why]
    assert {reason for reason, here in zip(reasons, found.computed, strict=True) if here} == {
        "ValueError: no exponents today"
    }
    assert set(reasons) <= {"ValueError: no exponents today", NOT_COMPUTED}
    assert np.isnan(found.growth).all()


def test_beyond_a_gap_it_is_not_known_where_turning_points_are(duffing):
    _, curve, _ = duffing
    gap = np.zeros(len(curve), dtype=bool)
    gap[len(curve) // 2] = True
    parts = parts_of(replace(curve, after_gap=gap))
    assert {part.against is None for part in parts if part.start >= len(curve) // 2} == {True}
    assert {part.against is None for part in parts if part.last < len(curve) // 2} == {False}


def test_too_few_harmonics_are_noticed():
    """A response in the first harmonic that its third makes unstable: three harmonics do not see it, eleven do."""
    d = solved("a_duffing_1dof")["definition"]
    group = ElementGroup(CubicSpring(), CubicParameters(np.array([40 * d["g"]])), ROW)
    system = one_degree_of_freedom(d["c"], group, (0, 1), 128)
    solution = first_point(system, Excitation(system.free.row("mass"), 2.0), 0.7)
    coarse, fine = (stability(system, solution.x, 0.7, StabilityOptions(order=order)) for order in (0, 11))
    assert fine.trusted
    assert not fine.stable
    assert not coarse.trusted
    assert "too few harmonics" in coarse.reason


@pytest.fixture(scope="module")
def friction_system():
    """Five degrees of freedom, three contacts with all directions coupled: that of test_time_integration."""
    rng = np.random.default_rng(4)
    omega = 2 * np.pi * np.array([80.0, 110.0, 190.0, 260.0, 420.0])
    M, K = np.eye(5), np.diag(omega**2)
    C = np.diag(2 * omega * np.array([0.03, 0.04, 0.05, 0.06, 0.08]))
    Q, load = rng.normal(size=(9, 5)), np.array([1.0, 0.4, 0.2, 0.1, 0.3])
    n0, kt, kn, mu = np.array([1.0, 1.2, 0.8]) * 4, 3e4, 4e4, 0.4
    points = {"load": load, **{f"q{i}": np.eye(5)[i] for i in range(5)}}
    linear = from_matrices(M, C, K, Q, points)
    group = ElementGroup(JenkinsBox(2), friction(3, mu, kt, kn, n0), np.arange(9).reshape(3, 3))
    system = NonlinearSystem(linear, (group,), Harmonics(tuple(range(12))), 256)
    every = np.ones(3)
    return system, (M, C, K, Q, (mu * every, kt * every, kn * every, n0), load)


def _by_both(friction_system, force, steps, w=2 * np.pi * 105.0):
    """Stability of the response, and exponents from multipliers marched in time; imaginary parts modulo w."""
    system, (M, C, K, Q, p, load) = friction_system
    excitation = Excitation(system.free.row("load"), force)
    solution = first_point(system, excitation, w)
    assert solution.converged
    y = response(solution.equation, excitation, np.arange(10, 15))
    q, v = y @ system.harmonics.synthesis(64)[0], w * y @ system.harmonics.synthesis_rate(64)[0]
    values, _ = multipliers(M, C, K, Q, p, force * load, w, np.concatenate([q, v, np.zeros(6)]), steps, 12, 1e-6)
    moving = values[np.abs(np.abs(values) - 1) > 1e-4]  # sliders at rest have multiplier 1
    marched = np.log(moving[:2].astype(complex)) * w / (2 * np.pi)
    return stability(system, solution.x, w), marched, contact_states(system, solution.x, w)


def test_exponents_of_stuck_contacts_are_those_of_the_modes(friction_system):
    system, w = friction_system[0], 2 * np.pi * 105.0
    point = stability(system, first_point(system, Excitation(system.free.row("load"), 0.5), w).x, w)
    stuck = system.stuck
    A = np.block([[np.zeros((5, 5)), np.eye(5)], [-np.diag(stuck.omega_squared), -stuck.viscous]])
    exact = np.linalg.eigvals(A)
    assert point.stable
    assert point.trusted
    assert np.abs(exact - point.decisive).min() < 1e-8 * abs(point.decisive)
    assert point.decisive.real == pytest.approx(exact.real.max(), rel=1e-9)


def test_exponents_with_nothing_active_and_residual_flexibility_are_those_of_the_modes(friction_system):
    """All contacts stick: the residual flexibility, which only moves with what slips, changes no exponent."""
    system, w = friction_system[0], 2 * np.pi * 105.0
    free = replace(system.free, residual=1e-6 * np.eye(system.free.n_rows))
    flexible = replace(system, free=free)
    point = stability(flexible, first_point(flexible, Excitation(free.row("load"), 0.5), w).x, w)
    stuck = flexible.stuck
    assert stuck.has_residual
    A = np.block([[np.zeros((5, 5)), np.eye(5)], [-np.diag(stuck.omega_squared), -stuck.viscous]])
    assert point.stable
    assert point.trusted
    assert point.decisive.real == pytest.approx(np.linalg.eigvals(A).real.max(), rel=1e-9)


def test_what_is_not_known_is_not_called_stable(friction_system, monkeypatch):
    system, w = friction_system[0], 2 * np.pi * 105.0
    x = first_point(system, Excitation(system.free.row("load"), 400.0), w).x
    monkeypatch.setattr(Strip, "_settled", lambda *_: None)
    point = stability(system, x, w)
    assert point.stable is None
    assert not point.trusted
    assert "did not settle" in point.reason
    assert np.isnan(point.decisive)


@pytest.fixture(scope="module")
def flexible(friction_system):
    """With residual flexibility as soft as the contacts, and the response to a load at which they slip and separate."""
    system = friction_system[0]
    spread = np.random.default_rng(7).normal(size=(system.free.n_rows, 20))
    residual = 1e-6 * spread @ spread.T
    system = replace(system, free=replace(system.free, residual=residual), harmonics=Harmonics(tuple(range(6))))
    w = 2 * np.pi * 105.0
    return system, first_point(system, Excitation(system.free.row("load"), 400.0), w).x, w


def test_residual_flexibility_is_that_of_a_massless_part_in_full(flexible):
    """Against the equations in all unknowns, forces on the flexibility included, without any elimination."""
    system, x, w = flexible
    problem = HillProblem(system, x, w, 5, 256)
    s = complex(-3.0, 40.0)
    c, stuck, T = problem.harmonics.n_coefficients, system.stuck, problem.tangent(s)
    n, m = stuck.n_relative, len(stuck.omega_squared)
    blocks = T.apply(np.eye(n * c).reshape(n, c, n * c)).reshape(n * c, n * c)
    by_s, constant = problem.linear
    phi, R = np.kron(stuck.phi[:n], np.eye(c)), np.kron(stuck.residual[:n, :n], np.eye(c))
    L = s**2 * np.eye(m * c) + s * by_s + constant
    full = np.block([[L, phi.T], [-blocks @ phi, np.eye(n * c) + blocks @ R]])
    eliminated = L + problem.contact_at(s)
    load = np.random.default_rng(8).normal(size=m * c)
    wanted = np.linalg.solve(full, np.concatenate([load, np.zeros(n * c)]))[: m * c]
    np.testing.assert_allclose(np.linalg.solve(eliminated, load), wanted, rtol=0, atol=1e-9 * np.abs(wanted).max())
    sign, _ = np.linalg.slogdet(np.eye(n * c) + HillProblem(system, x, w, 5, 256).still.onto(R[::c, ::c], np.float64))
    assert np.sign(sign) * np.linalg.slogdet(constant + problem.contact)[0] == problem.determinant_sign


def test_the_decisive_exponent_solves_the_problem_with_memory(flexible):
    system, x, w = flexible
    problem = HillProblem(system, x, w, 5, 256)
    strip = Strip.of(problem, 1e-7)
    found, lost = strip.exponents()
    assert lost == -np.inf
    exact = strip.corrected(found[0], problem)
    values, _ = problem.eigen(problem.contact_at(exact.s))
    assert np.abs(values - exact.s).min() < 1e-4 * w
    assert abs(exact.s - found[0].s) < 0.02 * w  # so far is what is read between the nodes off


def test_stiff_modes_may_lose_their_mass(flexible):
    """Modes far above the harmonics, made flexibility, change the decisive exponent by little: (w / omega)^2."""
    system, x, w = flexible
    model, rng = system.free, np.random.default_rng(9)
    omega = 2 * np.pi * np.linspace(20e3, 60e3, 10)
    stiff = 0.03 * omega * rng.normal(size=(model.n_rows, 10))
    zeros = np.zeros((5, 10))
    more = replace(
        model,
        omega_squared=np.concatenate([model.omega_squared, omega**2]),
        phi=np.hstack([model.phi, stiff]),
        residual=0 * model.residual,
        hysteretic=np.zeros((15, 15)),
        viscous=np.block([[model.viscous, zeros], [zeros.T, 1e-3 * np.diag(omega)]]),
    )
    heavy = replace(system, free=more)
    x = first_point(heavy, Excitation(more.row("load"), 400.0), w).x
    own = HillProblem(heavy, x, w, 5, 256)
    assert len(own.structure) < 15
    every = condense(heavy.stuck, own.still.mean(), 1e9)
    assert len(every) == 15
    fast, slow = (
        Strip.of(HillProblem(heavy, x, w, 5, 256, kept), 1e-7).exponents()[0][0].s for kept in (own.structure, every)
    )
    assert fast == pytest.approx(slow, rel=1e-3)


def test_exponents_with_slip_and_separation_are_those_of_time_marching(friction_system):
    """The sliders' memory is in both: without it the decay is 25 % slower. 5 % are left between them because the march
    takes closing and reversal at its steps: in the sampled law that alone moves the rate between 23.4 and 26.8 1/s from
    256 to 2048 samples, in the law that follows events between samples by 0.01 1/s."""
    point, marched, states = _by_both(friction_system, 400.0, 256)
    w = 2 * np.pi * 105.0
    assert ContactState.SEPARATING in states
    assert point.stable
    assert point.trusted, point.reason
    assert point.change < 0.001 * abs(point.decisive.real)
    assert point.decisive.real == pytest.approx(marched[0].real, rel=0.05)
    folded = [abs((sign * point.decisive.imag - marched[0].imag + w / 2) % w - w / 2) for sign in (1, -1)]
    assert min(folded) < 2e-3 * w


@pytest.mark.long
def test_just_touching_contacts_make_rates_uncertain_and_it_is_said(friction_system):
    """At 12 N one slider is caught slipping or not, depending on the samples: marching in 256 and in 512 steps gives
    rates 12 % apart, and so do exponents of the sampled law; the sign is not in doubt. Followed between the samples the
    same contact leaves no doubt."""
    system, definition = friction_system
    sampled = replace(system, groups=(replace(system.groups[0], law=SampledJenkinsBox(2)),))
    (point, coarse, _), (_, fine, _) = (_by_both((sampled, definition), 12.0, steps) for steps in (256, 512))
    gap = abs(coarse[0].real - fine[0].real)
    assert gap > 0.1 * abs(coarse[0].real)
    assert point.stable
    assert point.change == pytest.approx(gap, rel=0.1)
    followed, *_ = _by_both(friction_system, 12.0, 256)
    assert followed.change < 0.01 * gap


def test_tangent_without_growth_is_that_of_the_harmonic_balance(friction_system):
    system, _ = friction_system
    solution = first_point(system, Excitation(system.free.row("load"), 400.0), 2 * np.pi * 105.0)
    group = system.groups[0]
    x = solution.x[group.rows]
    still = perturbed_tangent(group, x, solution.w, 0.0, system.harmonics, system.time_samples)
    expected = element_forces(group, x, solution.w, system.harmonics, system.time_samples).tangent
    np.testing.assert_allclose(still, expected, atol=1e-9 * np.abs(expected).max())


def test_folds_with_friction():
    """A hardening spring beside a Jenkins element: one real exponent grows between the turning points, with memory."""
    linear = from_matrices(np.eye(1), 0.02 * np.eye(1), np.eye(1), np.ones((2, 1)), {"mass": np.ones(1)})
    groups = (
        ElementGroup(CubicSpring(), CubicParameters(np.array([0.1])), np.array([[0]])),
        ElementGroup(Jenkins(), JenkinsParameters(np.array([0.3]), np.array([0.02])), np.array([[1]])),
    )
    system = NonlinearSystem(linear, groups, Harmonics(tuple(range(6))), 256)
    curve = _curve(system, 0.15)
    turns, against = turning_points(curve.frequency), between_turning_points(curve.frequency)
    assert len(turns) == 2
    between = (turns[0] + turns[1]) // 2
    places = [turns[0] // 2, turns[0] - 1, turns[0] + 1, between, turns[1] - 1, turns[1] + 1, turns[1] + 5]
    for i in places:
        point = stability(system, curve.displacement[i], 2 * np.pi * curve.frequency[i], against=None)
        assert point.stable != against[i], f"{curve.frequency[i]} Hz"
        assert point.trusted, point.reason


@pytest.mark.parametrize(
    ("options", "name"),
    [({"order": -1}, "order"), ({"tolerance": 1.0}, "tolerance"), ({"agreement": 2.0}, "agreement")],
)
def test_options_refuse_bad_values_by_name(options, name):
    with pytest.raises(ValueError, match=name):
        StabilityOptions(**options)
