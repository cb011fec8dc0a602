"""Derivatives of solved points against central differences of re-solved points, with slip and separation."""

from collections.abc import Callable
from dataclasses import dataclass, replace
from typing import Any

import numpy as np
import pytest
import scipy.linalg
from scipy.optimize import brentq
from support.peers import blades_and_damper_system

from updamp.hbm.analysis.held_quantities import FixedArc, FixedFrequency, FixedPhase
from updamp.hbm.analysis.sensitivity import sensitivities
from updamp.hbm.analysis.sensitivity_parameters import (
    ContactParameter,
    ExcitationForce,
    Parameter,
    ParameterSum,
    hysteretic_scale,
    mode_frequency,
    mode_loss_factor,
    of_element,
    same_for_all,
    scaled,
    viscous_scale,
)
from updamp.hbm.analysis.sensitivity_patches import Dashpot, Mass, Spring, patch_direction
from updamp.hbm.contact.coulomb_circle import CoulombCircle
from updamp.hbm.contact.jenkins_box import JenkinsBox
from updamp.hbm.continuation.branch import branch_point
from updamp.hbm.continuation.continuation import first_point
from updamp.hbm.newton.newton import Arc, NewtonOptions, Solution, solve
from updamp.hbm.newton.observe import ContactState, contact_states, response
from updamp.hbm.problem.elements import ElementGroup
from updamp.hbm.problem.linear_model import LinearModel, add_springs
from updamp.hbm.problem.system import Excitation, NonlinearSystem

TIGHT = NewtonOptions(tolerance=1e-13)
POINTS = ("tip", "excitation")
MODE = 5  # of a blade
TIP_TO_EXCITATION = {"tip": 1.0, "excitation": -0.7}


@dataclass(frozen=True)
class Point:
    system: NonlinearSystem
    excitation: Excitation
    solution: Solution


def damped(system: NonlinearSystem) -> NonlinearSystem:
    """With hysteretic damping beside the viscous, not diagonal in the modes."""
    free = system.free
    coupling = 1e-3 * np.outer(np.sqrt(free.omega_squared), np.sqrt(free.omega_squared))
    return replace(system, free=replace(free, hysteretic=0.002 * np.diag(free.omega_squared) + coupling))


def low_modes(system: NonlinearSystem, with_residual: bool, kept: int = 24) -> NonlinearSystem:
    """The lowest modes, with or without the static residual flexibility of the others.

    The others reach up to 176 kHz, and re-solving a changed model carries their round-off: 1e-10 in the low modes'
    frequencies, 1e-3 in a difference over a step of 1e-6. What is compared here is the same with 24 modes.
    """
    free, low, high = system.free, slice(kept), slice(kept, None)
    residual = free.phi[:, high] / free.omega_squared[high] @ free.phi[:, high].T * with_residual
    part = replace(
        free,
        omega_squared=free.omega_squared[low],
        phi=free.phi[:, low],
        residual=residual,
        hysteretic=free.hysteretic[low, low],
        viscous=free.viscous[low, low],
    )
    return replace(system, free=part)


def solved_point(system: NonlinearSystem, force: float = 40.0, frequency: float = 232.0) -> Point:
    excitation = Excitation(system.free.row("excitation"), force)
    solution = first_point(system, excitation, 2 * np.pi * frequency, TIGHT)
    assert solution.converged
    states = set(contact_states(system, solution.x, solution.w))
    assert {ContactState.STICK_SLIP, ContactState.SEPARATING} <= states
    return Point(system, excitation, solution)


MODELS = {
    "box": lambda: low_modes(damped(blades_and_damper_system(JenkinsBox(2))), with_residual=False),
    "circle": lambda: low_modes(damped(blades_and_damper_system(CoulombCircle(3))), with_residual=False),
    "residual": lambda: low_modes(damped(blades_and_damper_system(JenkinsBox(2))), with_residual=True),
}


@pytest.fixture(scope="module", params=MODELS)
def point(request) -> Point:
    return solved_point(MODELS[request.param]())


# Each case: the parameter, and the problem with the parameter raised by a value.
Problem = tuple[NonlinearSystem, Excitation]


def contact(system: NonlinearSystem, entry: str, change: np.ndarray) -> NonlinearSystem:
    group = system.groups[0]
    parameters = group.parameters._replace(**{entry: np.asarray(getattr(group.parameters, entry)) + change})
    return replace(system, groups=(ElementGroup(group.law, parameters, group.rows),))


def structure(system: NonlinearSystem, **changes: Any) -> NonlinearSystem:
    return replace(system, free=replace(system.free, **changes))


def raise_contact(make: Callable[[NonlinearSystem], ContactParameter]) -> Callable[[Point, float], Problem]:
    def changed(p: Point, value: float) -> Problem:
        parameter = make(p.system)
        return contact(p.system, parameter.entry, value * parameter.pattern), p.excitation

    return changed


def raise_mode(p: Point, value: float) -> Problem:
    omega_squared = p.system.free.omega_squared.copy()
    omega_squared[MODE] = (np.sqrt(omega_squared[MODE]) + value) ** 2
    return structure(p.system, omega_squared=omega_squared), p.excitation


def raise_loss(p: Point, value: float) -> Problem:
    hysteretic = p.system.free.hysteretic.copy()
    hysteretic[MODE, MODE] += value * p.system.free.omega_squared[MODE]
    return structure(p.system, hysteretic=hysteretic), p.excitation


def raise_hysteretic(p: Point, value: float) -> Problem:
    return structure(p.system, hysteretic=(1 + value) * p.system.free.hysteretic), p.excitation


def raise_viscous(p: Point, value: float) -> Problem:
    return structure(p.system, viscous=(1 + value) * p.system.free.viscous), p.excitation


def raise_force(p: Point, value: float) -> Problem:
    return p.system, replace(p.excitation, force=p.excitation.force + value)


def raise_spring(p: Point, value: float) -> Problem:
    d = patch_direction(p.system.free, TIP_TO_EXCITATION)
    return replace(p.system, free=add_springs(p.system.free, d[:, None], np.array([value]))), p.excitation


def raise_mass(p: Point, value: float) -> Problem:
    """Without residual flexibility: M -> 1 + m b b^T in modal coordinates, b the patch's modal participation."""
    free = p.system.free
    b = free.phi.T @ patch_direction(free, TIP_TO_EXCITATION)
    return replace(p.system, free=in_new_modes(free, np.eye(len(b)) + value * np.outer(b, b))), p.excitation


def in_new_modes(free: LinearModel, mass: np.ndarray) -> LinearModel:
    omega_squared, X = scipy.linalg.eigh(np.diag(free.omega_squared), mass)
    turned = {name: X.T @ getattr(free, name) @ X for name in ("hysteretic", "viscous")}
    return replace(free, omega_squared=omega_squared, phi=free.phi @ X, **turned)


def raise_dashpot(p: Point, value: float) -> Problem:
    b = p.system.free.phi.T @ patch_direction(p.system.free, TIP_TO_EXCITATION)
    return structure(p.system, viscous=p.system.free.viscous + value * np.outer(b, b)), p.excitation


def raise_pull(p: Point, value: float) -> Problem:
    """A preload and a spring at once."""
    system, excitation = raise_spring(p, 200.0 * value)
    return contact(system, "n0", 0.3 * value * np.asarray(system.groups[0].parameters.n0)), excitation


def pattern(system: NonlinearSystem) -> ContactParameter:
    values = np.asarray(system.groups[0].parameters.t0)
    return ContactParameter(system, "t0", np.random.default_rng(3).normal(size=values.shape))


def contact_case(
    make: Callable[[NonlinearSystem], ContactParameter], step: float
) -> tuple[Callable[[NonlinearSystem], Parameter], Callable[[Point, float], Problem], float]:
    return make, raise_contact(make), step


CASES = {
    "mu, same_for_all": contact_case(lambda s: same_for_all(s, "mu"), 1e-6),
    "kt, scaled": contact_case(lambda s: scaled(s, "kt"), 1e-4),
    "kn, scaled": contact_case(lambda s: scaled(s, "kn"), 1e-5),
    "n0, scaled": contact_case(lambda s: scaled(s, "n0"), 1e-6),
    "n0, one element": contact_case(lambda s: of_element(s, "n0", 7), 1e-5),
    "gap, same_for_all": contact_case(lambda s: same_for_all(s, "gap"), 1e-10),
    "t0, a pattern": contact_case(pattern, 1e-5),
    "frequency of a mode": (lambda s: mode_frequency(s.free, MODE), raise_mode, 1e-4),
    "loss factor of a mode": (lambda s: mode_loss_factor(s.free, MODE), raise_loss, 1e-6),
    "hysteretic damping": (lambda s: hysteretic_scale(s.free), raise_hysteretic, 1e-4),
    "viscous damping": (lambda s: viscous_scale(s.free), raise_viscous, 1e-4),
    "excitation": (lambda _: ExcitationForce(), raise_force, 1e-4),
    "spring": (lambda s: Spring(patch_direction(s.free, TIP_TO_EXCITATION)), raise_spring, 1.0),
    "mass": (lambda s: Mass(patch_direction(s.free, TIP_TO_EXCITATION)), raise_mass, 1e-7),
    "dashpot": (lambda s: Dashpot(patch_direction(s.free, TIP_TO_EXCITATION)), raise_dashpot, 1e-4),
    "pull": (
        lambda s: ParameterSum(((0.3, scaled(s, "n0")), (200.0, Spring(patch_direction(s.free, TIP_TO_EXCITATION))))),
        raise_pull,
        1e-5,
    ),
}
# Where residual flexibility takes part, the differences of these two need another linear model than modes and residual.
WITHOUT_RESIDUAL = {"mass", "dashpot"}


def central(p: Point, changed: Callable[[Point, float], Problem], step: float, again: Callable[..., Solution]) -> Any:
    """Differences of displacement, angular frequency and response."""
    ends = []
    for sign in (1, -1):
        system, excitation = changed(p, sign * step)
        end = again(system, excitation)
        assert end.converged
        rows = np.array([system.free.row(name) for name in POINTS])
        ends.append((end.x, end.w, response(end.equation, excitation, rows)))
    return tuple((a - b) / (2 * step) for a, b in zip(*ends, strict=True))


def assert_agree(found: Any, expected: Any, tolerance: float = 1e-5) -> None:
    dx, dw, dy = expected
    np.testing.assert_allclose(found.displacement[0], dx, rtol=0, atol=tolerance * np.abs(dx).max())
    np.testing.assert_allclose(found.response[0], dy, rtol=0, atol=tolerance * np.abs(dy).max())
    if dw:
        assert found.w[0] == pytest.approx(dw, rel=tolerance)


@pytest.mark.parametrize("name", CASES)
def test_at_fixed_frequency(point, name):
    make, changed, step = CASES[name]
    if name in WITHOUT_RESIDUAL and point.system.free.residual.any():
        pytest.skip("checked without residual flexibility")
    found = sensitivities(point.solution, point.excitation, [make(point.system)], FixedFrequency(), POINTS)
    start = point.solution

    def again(system: NonlinearSystem, excitation: Excitation) -> Solution:
        return solve(system, excitation, start.x, start.w, TIGHT)

    expected = central(point, changed, step, again)
    assert np.abs(expected[0]).max() > 0
    assert_agree(found, expected)
    assert found.w[0] == 0


CASES_ELSEWHERE = ("mu, same_for_all", "kt, scaled", "frequency of a mode", "spring")


@pytest.mark.parametrize("name", CASES_ELSEWHERE)
def test_at_fixed_arc(point, name):
    make, changed, step = CASES[name]
    scale_w = 2 * np.pi * 10.0
    start = point.solution
    place = branch_point(point.system, point.excitation, start.x, start.w, scale_w, (0 * start.x, 1.0))
    found = sensitivities(point.solution, point.excitation, [make(point.system)], FixedArc.at(place), POINTS)
    arc = Arc(start.x, start.w, place.tangent, place.metric)

    def again(system: NonlinearSystem, excitation: Excitation) -> Solution:
        return solve(system, excitation, start.x, start.w, TIGHT, arc)

    expected = central(point, changed, step, again)
    assert abs(expected[1]) > 0
    assert_agree(found, expected)


@pytest.mark.parametrize("name", CASES_ELSEWHERE)
def test_at_fixed_phase(point, name):
    """The resonance by phase moves with the parameter; the differences find it anew by bisection."""
    make, changed, step = CASES[name]
    start, row = point.solution, point.system.free.row("tip")
    held = FixedPhase.at(start.equation, point.excitation, row)
    found = sensitivities(point.solution, point.excitation, [make(point.system)], held, POINTS)

    def again(system: NonlinearSystem, excitation: Excitation) -> Solution:
        def at(w: float) -> Solution:
            return solve(system, excitation, start.x, w, TIGHT)

        def off_phase(w: float) -> float:
            y = response(at(w).equation, excitation, np.array([row]))[0]
            return float(np.angle(system.harmonics.amplitude(y, 1) / held.amplitude))

        return at(brentq(off_phase, start.w - 0.05, start.w + 0.05, xtol=1e-11))

    assert_agree(found, central(point, changed, step, again), 1e-4)


def test_all_at_once_is_one_by_one(point):
    parameters = [CASES[name][0](point.system) for name in CASES]
    held = FixedPhase.at(point.solution.equation, point.excitation, point.system.free.row("tip"))
    together = sensitivities(point.solution, point.excitation, parameters, held, POINTS)
    for i, parameter in enumerate(parameters):
        alone = sensitivities(point.solution, point.excitation, [parameter], held, POINTS)
        np.testing.assert_allclose(together.displacement[i], alone.displacement[0], rtol=1e-7, atol=1e-20)
        np.testing.assert_allclose(together.w[i], alone.w[0], rtol=1e-7)


def test_size_of_the_amplitude(point):
    """d|Y|/dp, against differences of the size itself."""
    found = sensitivities(point.solution, point.excitation, [ExcitationForce()], points=POINTS)
    step, row = 1e-4, np.array([point.system.free.row("excitation")])
    sizes = []
    for sign in (1, -1):
        excitation = replace(point.excitation, force=point.excitation.force + sign * step)
        end = solve(point.system, excitation, point.solution.x, point.solution.w, TIGHT)
        sizes.append(abs(point.system.harmonics.amplitude(response(end.equation, excitation, row)[0], 1)))
    assert found.size("excitation")[0] == pytest.approx((sizes[0] - sizes[1]) / (2 * step), rel=1e-6)


def test_refusals(point):
    system, excitation, start = point.system, point.excitation, point.solution
    with pytest.raises(ValueError, match=r"FrictionParameters.mu has shape \(3,\): give one of \(20,\)"):
        ContactParameter(system, "mu", np.ones(3))
    with pytest.raises(KeyError, match="there are excitation, tip"):
        patch_direction(system.free, {"root": 1.0})
    unsolved = solve(system, excitation, 0.5 * start.x, start.w, NewtonOptions(tolerance=1e-13, iterations=1))
    with pytest.raises(ValueError, match="not solved"):
        sensitivities(unsolved, excitation, [ExcitationForce()])
    with pytest.raises(ValueError, match="there are tip"):
        sensitivities(start, excitation, [ExcitationForce()], points=("tip",)).amplitude("root")
