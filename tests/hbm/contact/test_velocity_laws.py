"""Forces of the velocity alone: what they take a cycle in closed form, exact tangents, a derivative at rest."""

import jax
import jax.numpy as jnp
import numpy as np
import pytest
from scipy.special import gamma

from updamp.hbm.contact.between_points import BetweenPoints
from updamp.hbm.contact.coulomb_friction import CoulombFriction
from updamp.hbm.contact.dry_friction import DryFriction, DryFrictionParameters
from updamp.hbm.contact.power_law_damper import PowerLawDamper, PowerLawParameters
from updamp.hbm.contact.threshold_damper import ThresholdDamper, ThresholdDamperParameters
from updamp.hbm.harmonics import Harmonics
from updamp.hbm.problem.elements import ElementGroup, departures, element_forces, force_only, loop_areas

HARMONICS = Harmonics((1, 2, 3))
W, A = 500.0, 2e-4  # rad/s, m: 0.1 m/s
FORCE, REFERENCE, CREEP = 0.3, 0.07, 2e-3


def damper(exponent: float, force: float = FORCE) -> ElementGroup:
    parameters = PowerLawParameters(np.array([force]), np.array([exponent]))
    return ElementGroup(PowerLawDamper(REFERENCE), parameters, np.array([[0]]))


def friction(force: float = FORCE) -> ElementGroup:
    return ElementGroup(DryFriction(CREEP), DryFrictionParameters(np.array([force])), np.array([[0]]))


def coulomb(force: float = FORCE) -> ElementGroup:
    return ElementGroup(CoulombFriction(), DryFrictionParameters(np.array([force])), np.array([[0]]))


def threshold(place: float = A / 2) -> ElementGroup:
    parameters = ThresholdDamperParameters(np.array([2.0]), np.array([place]))
    return ElementGroup(ThresholdDamper(), parameters, np.array([[0]]))


def across(group: ElementGroup) -> ElementGroup:
    return ElementGroup(BetweenPoints(group.law), group.parameters, np.array([[0, 1]]))


def between_two(force: float = FORCE) -> ElementGroup:
    return ElementGroup(BetweenPoints(DryFriction(CREEP)), DryFrictionParameters(np.array([force])), np.array([[0, 1]]))


GROUPS = {
    "power 1": damper(1.0), "power 1.8": damper(1.8), "power 3": damper(3.0), "friction": friction(),
    "threshold": threshold(), "coulomb": coulomb(),
    "power between two": across(damper(1.8)), "friction between two": between_two(),
}  # fmt: skip
EACH = pytest.mark.parametrize("group", GROUPS.values(), ids=GROUPS)


def harmonic(amplitude: float, phase: float = 0.4) -> np.ndarray:
    motion = np.zeros((1, 1, 6))
    motion[0, 0, :2] = amplitude * np.cos(phase), amplitude * np.sin(phase)
    return motion


def motion_of(group: ElementGroup, seed: int = 3) -> np.ndarray:
    return A * np.random.default_rng(seed).normal(size=(1, group.law.directions, 6)) / np.repeat([1, 4, 9], 2)


@pytest.mark.parametrize("exponent", [1.0, 1.5, 1.8, 2.0, 3.0])
def test_power_law_takes_what_the_gamma_function_says(exponent: float) -> None:
    for amplitude in (A, 3 * A):
        expected = FORCE * amplitude * (W * amplitude / REFERENCE) ** exponent * 2 * np.sqrt(np.pi)
        expected *= gamma(exponent / 2 + 1) / gamma(exponent / 2 + 1.5)
        found = loop_areas(damper(exponent), harmonic(amplitude), W, HARMONICS, 2048)
        assert found[0] == pytest.approx(expected, rel=1e-5)


def test_power_law_at_one_and_two_is_a_dashpot_and_a_square_law() -> None:
    v = jnp.linspace(-1.0, 1.0, 41)[:, None]
    for exponent, expected in ((1.0, v / REFERENCE), (2.0, v * jnp.abs(v) / REFERENCE**2)):
        found = PowerLawDamper(REFERENCE).force(v, v, PowerLawParameters(jnp.array(1.0), jnp.array(exponent)))
        np.testing.assert_allclose(found, expected, rtol=1e-9, atol=1e-12)


def test_beyond_a_threshold_what_is_lost_is_the_closed_form_and_below_it_nothing() -> None:
    for amplitude in (1.01 * A, 3 * A, 1e3 * A):
        t = np.arccos(A / amplitude)
        expected = t / 2 - np.sin(2 * t) / 4 - A / amplitude * (np.arctanh(np.sin(t)) - np.sin(t))
        found = loop_areas(threshold(A), harmonic(amplitude), W, HARMONICS, 16384)
        assert found[0] == pytest.approx(4 * 2.0 * W * amplitude**2 * expected, rel=1e-3)
    assert loop_areas(threshold(A), harmonic(0.99 * A), W, HARMONICS, 256)[0] == 0


def test_friction_takes_four_times_force_and_amplitude_less_what_creeps() -> None:
    for amplitude in (A, 5 * A):
        expected = 4 * FORCE * amplitude * (1 - np.pi**2 / 24 * (CREEP / (W * amplitude)) ** 2)
        found = loop_areas(friction(), harmonic(amplitude), W, HARMONICS, 16384)
        assert found[0] == pytest.approx(expected, rel=1e-6)


@pytest.mark.parametrize("amplitude", [1e-3 * A, A, 1e3 * A])
def test_coulombs_friction_takes_four_times_force_and_amplitude_whatever_that_is(amplitude: float) -> None:
    group = coulomb()
    found = loop_areas(group, harmonic(amplitude), W, HARMONICS, 16384)
    assert found[0] == pytest.approx(4 * FORCE * amplitude * (1 - np.pi**2 / 24 * group.law.share**2), rel=1e-5)


def test_friction_that_turns_round_between_samples_is_seen() -> None:
    """At 128 samples within 0.2 % of what a hundred times as many say, in motions with some per cent of higher
    harmonics; taken at the samples it is off by more than ten times as much."""
    group, errors = friction(), []
    for seed in range(20):
        x = 10 * motion_of(group, seed) / np.repeat([1, 4, 9], 2)
        fine, seen = (force_only(group, x, W, HARMONICS, n)[0, 0] for n in (12800, 128))
        u, v = (
            jnp.asarray(m @ x[0, 0])[:, None] for m in (HARMONICS.synthesis(128), W * HARMONICS.synthesis_rate(128))
        )
        at_samples = HARMONICS.analysis(128) @ np.asarray(group.law.force(u, v, group.parameters))[:, 0]
        errors.append([np.linalg.norm(f - fine) / FORCE for f in (seen, at_samples)])
    between, at_the_samples = np.sqrt(np.mean(np.square(errors), axis=0))
    assert between < 2e-3
    assert at_the_samples > 10 * between


@EACH
def test_tangents_are_those_of_differences(group: ElementGroup) -> None:
    """By the motion and by the frequency."""
    x = motion_of(group)
    found, h = element_forces(group, x, W, HARMONICS, 128), 1e-6
    dx = A * np.random.default_rng(4).normal(size=x.shape)
    ahead, behind = (force_only(group, x + s * h * dx, W, HARMONICS, 128) for s in (1, -1))
    expected = (ahead - behind) / (2 * h)
    tangent = np.einsum("eicjd,ejd->eic", found.tangent, dx)
    np.testing.assert_allclose(tangent, expected, atol=1e-6 * np.abs(expected).max())
    ahead, behind = (force_only(group, x, W * (1 + s * h), HARMONICS, 128) for s in (1, -1))
    expected = (ahead - behind) / (2 * h * W)
    size = max(np.abs(expected).max(), 1e-3 * FORCE / W)  # Coulomb's friction does not know how fast it slides
    np.testing.assert_allclose(found.frequency_derivative, expected, atol=1e-6 * size)


@EACH
def test_at_rest_there_is_a_derivative_and_no_force(group: ElementGroup) -> None:
    found = element_forces(group, np.zeros((1, group.law.directions, 6)), W, HARMONICS, 64)
    assert not found.force.any()
    assert np.isfinite(found.tangent).all()
    for name in group.parameters._fields:
        p = group.parameters._replace(**{name: jnp.asarray(getattr(group.parameters, name)[0])})
        scalars = type(p)(*(jnp.asarray(v).reshape(()) for v in p))
        still = jnp.zeros((8, group.law.directions))
        by = jax.jacfwd(lambda value: group.law.force(still, still, scalars._replace(**{name: value})))(  # noqa: B023
            getattr(scalars, name)
        )
        assert np.isfinite(np.asarray(by)).all()


def test_force_enters_linearly_and_nothing_is_evaluated_without_it() -> None:
    for make in (friction, lambda force: damper(1.8, force)):
        one, two, none = make(FORCE), make(2 * FORCE), make(0.0)
        x = motion_of(one)
        np.testing.assert_allclose(
            force_only(two, x, W, HARMONICS, 64), 2 * force_only(one, x, W, HARMONICS, 64), rtol=1e-12
        )
        assert not departures(none, x, W, HARMONICS, 64).tangent.any()
        assert len(none.may_slip_or_separate(x, HARMONICS, 64)) == 0
        assert len(across(none).may_slip_or_separate(np.concatenate([x, x], axis=1), HARMONICS, 64)) == 0


def test_between_two_points_the_relative_motion_counts_and_forces_are_opposite() -> None:
    single, pair = friction(), between_two()
    x = motion_of(pair)
    found, expected = (
        element_forces(pair, x, W, HARMONICS, 128),
        element_forces(single, x[:, :1] - x[:, 1:], W, HARMONICS, 128),
    )
    np.testing.assert_allclose(found.force, np.concatenate([expected.force, -expected.force], axis=1), atol=1e-14)
    together = np.repeat(motion_of(single), 2, axis=1)
    assert np.abs(force_only(pair, together, W, HARMONICS, 128)).max() < 1e-12 * FORCE


@pytest.mark.parametrize("creep", [0.0, -1.0, np.nan, np.inf])
def test_friction_needs_a_creep(creep: float) -> None:
    """With 0 it divided by it, and below 0 it drove the motion."""
    with pytest.raises(ValueError, match=f"DryFriction: creep = {creep:g} m/s must be positive"):
        DryFriction(creep)
    with pytest.raises(ValueError, match=f"CoulombFriction: share = {creep:g} must be positive"):
        CoulombFriction(creep)


def test_friction_that_drives_is_refused() -> None:
    for make in (friction, coulomb, between_two):
        with pytest.raises(ValueError, match=r"force = \[-0.01\] must be 0 or more"):
            make(-0.01)
