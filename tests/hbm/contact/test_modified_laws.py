"""Modified friction laws: unchanged at null, exact tangents, one order, and all of them against a plain march."""

from dataclasses import replace

import jax.numpy as jnp
import numpy as np
import pytest
from support.amplitude_damper import AmplitudeDamper, AmplitudeDamperParameters

from updamp.hbm.contact.coulomb_circle import CoulombCircle
from updamp.hbm.contact.friction import FrictionParameters
from updamp.hbm.contact.jenkins_box import JenkinsBox
from updamp.hbm.contact.jenkins_box_sampled import SampledJenkinsBox
from updamp.hbm.contact.law import FrictionLaw
from updamp.hbm.contact.modified.film import ViscousFilm, closed_share
from updamp.hbm.contact.modified.microslip import SLIDERS, SubPatchMicroslip
from updamp.hbm.contact.modified.modified_law import with_entries
from updamp.hbm.contact.modified.pressure_stiffness import PressureStiffness
from updamp.hbm.contact.modified.static_share import StaticShare
from updamp.hbm.contact.modified.velocity_friction import VelocityFriction
from updamp.hbm.contact.paired_amplitude_damper import PairedAmplitudeDamper, PairedAmplitudeDamperParameters
from updamp.hbm.contact.springs import CubicSpring
from updamp.hbm.harmonics import Harmonics
from updamp.hbm.problem.elements import ElementGroup, element_forces, force_only, over_period

HARMONICS = Harmonics((0, 1, 2))
ELEMENTS = 12
MODIFICATIONS = (StaticShare, ViscousFilm, PressureStiffness, SubPatchMicroslip, VelocityFriction)
NULL = {
    "static_share": 1.0, "viscosity": 0.0, "pressure_exponent": 0.0, "mean_force": 1.1, "limit_spread": 0.0,
    "velocity_drop": 0.0, "reference_speed": 1.0,
}  # fmt: skip
STRONG = NULL | {
    "static_share": 0.6, "viscosity": 0.05, "pressure_exponent": 0.3, "limit_spread": 0.7, "velocity_drop": 0.4,
}  # fmt: skip


@pytest.fixture(scope="module")
def motions():
    """Elements that stick, slip and separate; the last ones are open at rest."""
    rng = np.random.default_rng(4)
    motion = rng.normal(size=(ELEMENTS, 3, 5)) * np.array([0.4, 2, 2, 0.3, 0.3])
    motion[:, 2] *= 0.6
    return motion


def friction():
    every = np.ones(ELEMENTS)
    open_ = np.arange(ELEMENTS) >= ELEMENTS - 3
    n0, gap = np.where(open_, 0.0, every), np.where(open_, 0.2, 0.0)
    return FrictionParameters(0.6 * every, 1.0 * every, 1.3 * every, n0, np.zeros((ELEMENTS, 2)), gap)


def group(law, **entries):
    each = {name: np.full(ELEMENTS, value) for name, value in entries.items()}
    rows = np.arange(3 * ELEMENTS).reshape(-1, 3)
    return ElementGroup(law, with_entries(friction(), **each) if each else friction(), rows)


def fully_modified(law, order=MODIFICATIONS):
    for modification in order:
        law = modification.modify(law)
    return law


def test_the_order_in_which_a_law_is_modified_does_not_matter():
    law = fully_modified(JenkinsBox(2))
    assert fully_modified(JenkinsBox(2), MODIFICATIONS[::-1]) == law
    assert fully_modified(law) == law
    assert isinstance(law, FrictionLaw)
    assert law.parameters._fields[:6] == FrictionParameters._fields
    assert set(NULL) == set(law.parameters._fields[6:])


def test_cycles_reach_the_innermost_law():
    law = replace(fully_modified(JenkinsBox(2)), cycles=4)
    assert law.cycles == 4
    while not isinstance(law, JenkinsBox):
        law = law.inner
    assert law.cycles == 4


def test_only_friction_can_be_put_inside():
    with pytest.raises(ValueError, match="law of friction"):
        ViscousFilm.modify(CubicSpring())


@pytest.mark.parametrize("base", [SampledJenkinsBox(2), CoulombCircle(3)])
def test_all_at_null_are_the_law_inside(motions, base):
    inside = force_only(group(base), motions, 0.8, HARMONICS, 64)
    outside = force_only(group(fully_modified(base), **NULL), motions, 0.8, HARMONICS, 64)
    np.testing.assert_allclose(outside, inside, atol=1e-13)


def test_force_state_and_tangent_of_all_together(motions):
    """The tangent is that of differences; the forces respect what the states say."""
    g, step = group(fully_modified(SampledJenkinsBox(2)), **STRONG), 1e-6
    direction = np.random.default_rng(5).normal(size=motions.shape)
    exact = element_forces(g, motions, 0.8, HARMONICS, 64)
    ahead, behind = (force_only(g, motions + s * direction, 0.8, HARMONICS, 64) for s in (step, -step))
    np.testing.assert_allclose(
        np.einsum("edabc,ebc->eda", exact.tangent, direction), (ahead - behind) / (2 * step), atol=2e-6
    )
    faster, slower = (force_only(g, motions, 0.8 + s, HARMONICS, 64) for s in (step, -step))
    np.testing.assert_allclose(exact.frequency_derivative, (faster - slower) / (2 * step), atol=2e-6)
    assert np.abs(exact.frequency_derivative).max() > 0.01
    _, normal = over_period(g, g.law.normal_force, motions, 0.8, HARMONICS, 64)
    _, state = over_period(g, g.law.state, motions, 0.8, HARMONICS, 64)
    np.testing.assert_array_equal(state == 2, normal <= 0)
    assert all((state == s).any() for s in range(3))


@pytest.mark.long
def test_all_together_are_a_plain_march_of_their_equations(motions):
    """Written out again with numpy at 2^12 samples."""
    w = 0.8
    wanted = np.einsum("ct,ted->edc", HARMONICS.analysis(2**12), marched(motions, w, 2**12))
    law, size = fully_modified(JenkinsBox(2)), np.abs(wanted).max()
    forces = [force_only(group(law, **STRONG), motions, w, HARMONICS, n) for n in (128, 256)]
    error = [np.sqrt(np.mean((force - wanted) ** 2)) / size for force in forces]
    assert error[0] < 1e-3
    assert error[1] < error[0]


def marched(motions, w, n_time):
    """(n_time, elements, 3) force over the second period."""
    f, s = friction(), STRONG
    u = np.einsum("tc,edc->ted", HARMONICS.synthesis(n_time), motions)
    v = w * np.einsum("tc,edc->ted", HARMONICS.synthesis_rate(n_time), motions)
    u = u - (1 - s["static_share"]) * u.mean(axis=0)
    m, mean = s["pressure_exponent"], s["mean_force"]
    linear = f.n0 ** (1 - m) + (1 - m) * f.kn * mean**-m * (u[..., 2] - f.gap)
    normal = np.maximum(linear, 0.0) ** (1 / (1 - m))
    kt = f.kt * (normal / mean) ** m
    speed = np.hypot(v[..., 0], v[..., 1])
    limit = f.mu * (1 - s["velocity_drop"] * speed / (speed + s["reference_speed"])) * normal
    strength = 1 + s["limit_spread"] * (2 * (np.arange(SLIDERS) + 0.5) / SLIDERS - 1)
    force, slider = np.zeros_like(u), np.zeros((ELEMENTS, 2, SLIDERS))
    for i in [*range(n_time)] * 2:
        stiffness, bound = kt[i, :, None, None], limit[i, :, None, None] * strength
        trial = np.clip(stiffness * (u[i, :, :2, None] - slider), -bound, bound)
        slider = u[i, :, :2, None] - trial / np.where(stiffness > 0, stiffness, 1.0)
        force[i, :, :2] = trial.mean(axis=-1)
    force[..., 2] = normal - np.where(f.gap > 0, 0.0, f.n0)
    return force + s["viscosity"] * v * (normal > 0)[..., None]


def test_stiffness_with_pressure_is_the_slope_of_the_normal_force():
    """dN/du = kn (N / N_m)^m, the law that its closed form integrates."""
    law = PressureStiffness(JenkinsBox(2))
    p = law.parameters(*(jnp.asarray(a[0]) for a in friction()), jnp.asarray(0.3), jnp.asarray(1.1))
    u = np.linspace(-0.5, 0.5, 2001)
    normal = np.asarray(law.normal_force(jnp.zeros((2001, 3)).at[:, 2].set(u), jnp.zeros((2001, 3)), p))
    slope = np.gradient(normal, u)[1:-1]
    np.testing.assert_allclose(slope, 1.3 * (normal[1:-1] / 1.1) ** 0.3, rtol=1e-3)
    assert normal[1000] == pytest.approx(1.0)


@pytest.mark.parametrize("exponent", [0.2, 1 / 3, 0.5])
def test_stiffness_with_pressure_has_no_corner_where_a_sample_opens(exponent):
    """The sample's compression above zero by less and less: the power of it is steep there. By 1e-8 the tangent was 15
    times what it is now for an exponent of 0.2, and branches of jumping rigs turned back at each such place."""
    given = FrictionParameters(np.full(1, 0.6), np.ones(1), np.ones(1), np.ones(1), np.array([[0.0, 0.0]]), np.zeros(1))
    p = with_entries(given, pressure_exponent=np.full(1, exponent), mean_force=np.ones(1))
    one = ElementGroup(PressureStiffness(JenkinsBox(2)), p, np.arange(3)[None])
    rest, swing = 1 / (1 - exponent), 2.0 / (1 - exponent)  # of the linear compression
    opens = swing * np.cos(2 * np.pi * 40 / 128)
    found = []
    for above in (1e-3, 1e-5, 1e-7, 1e-9):
        motion = np.zeros((1, 3, 5))
        motion[0, 0, 2], motion[0, 1, 1] = 0.8, 0.3
        motion[0, 2, :2] = above - rest - opens, swing
        found.append(element_forces(one, motion, 1.0, HARMONICS, 128).tangent)
    size = np.abs(found[0]).max()
    for tangent in found[1:]:
        np.testing.assert_allclose(tangent, found[0], rtol=0, atol=0.02 * size)


@pytest.mark.parametrize("exponent", [0.2, 0.4])
def test_stiffness_with_pressure_converges_where_contacts_open(motions, exponent):
    """Coefficients with 128 samples against 2,048: off by as little as those of the box law (1e-4 of the force)."""
    pressed = group(PressureStiffness(JenkinsBox(2)), pressure_exponent=exponent, mean_force=1.0)
    few, many = (force_only(pressed, motions, 1.0, HARMONICS, n) for n in (128, 2048))
    assert np.abs(few - many).max() < 3e-4 * np.abs(many).max()


def test_microslip_is_sliders_side_by_side():
    """Limits spread from 0 to 2 mu N: loading from rest would give T = k u - (k u)^2 / (4 mu N), and unloading is that
    curve at twice the scale (Masing)."""
    limit, kt, amplitude = 1.0, 3.0, 0.5
    one = FrictionParameters(
        np.full(1, 0.5), np.full(1, kt), np.ones(1), np.full(1, limit / 0.5), np.zeros((1, 2)), np.zeros(1)
    )
    g = ElementGroup(
        SubPatchMicroslip(SampledJenkinsBox(2)), with_entries(one, limit_spread=np.ones(1)), np.zeros((1, 3))
    )
    motion = np.zeros((1, 3, 5))
    motion[0, 0, 1] = amplitude  # cosine: the top is the first sample
    u, force = (value[0, :, 0] for value in over_period(g, g.law.force, motion, 1.0, HARMONICS, 512))
    loaded, unloaded = kt * amplitude, kt * (amplitude - u[:257])
    masing = loaded - loaded**2 / (4 * limit) - unloaded + unloaded**2 / (8 * limit)
    np.testing.assert_allclose(force[:257], masing, atol=0.01 * limit)
    alone = ElementGroup(SampledJenkinsBox(2), one, np.zeros((1, 3)))
    _, one_slider = over_period(alone, alone.law.force, motion, 1.0, HARMONICS, 512)
    assert np.abs(one_slider[0, :257, 0] - masing).max() > 0.2 * limit


def test_which_directions_are_decoupled():
    """Friction that falls with the speed couples the directions, and so does a limit that is a circle."""
    for modification in MODIFICATIONS:
        law = modification(JenkinsBox(2))
        assert getattr(law, "decoupled_directions", ()) == (() if modification is VelocityFriction else (0, 1))
        twice = SubPatchMicroslip.modify(law)
        assert getattr(twice, "decoupled_directions", ()) == getattr(law, "decoupled_directions", ())
        assert getattr(modification(CoulombCircle(3)), "decoupled_directions", ()) == ()


@pytest.mark.parametrize(
    "law",
    [
        *(modification(SampledJenkinsBox(2)) for modification in MODIFICATIONS),
        pytest.param(
            fully_modified(JenkinsBox(2), [each for each in MODIFICATIONS if each is not VelocityFriction]),
            marks=pytest.mark.long,
        ),
    ],
    ids=[*(modification.__name__ for modification in MODIFICATIONS), "four modifications, events between samples"],
)
def test_directions_are_decoupled_where_the_law_says_so(motions, law):
    """The tangent without a word of it is the same."""

    class Coupled(type(law)):
        decoupled_directions = ()

    entries = {name: STRONG[name] for name in law.parameters._fields if name in STRONG}
    together, apart = (
        element_forces(group(each, **entries), motions, 2.0, HARMONICS, 64) for each in (law, Coupled(law.inner))
    )
    np.testing.assert_allclose(together.force, apart.force, rtol=0, atol=1e-13)
    np.testing.assert_allclose(together.tangent, apart.tangent, rtol=0, atol=1e-12)
    assert np.abs(together.tangent[:, 0, :, 2]).max() > 0.1  # of friction by the normal motion


def test_share_of_the_time_closed_is_continuous():
    """A sinusoid's share of the period, as the samples pass its zeros."""
    offsets = np.linspace(0, 2 * np.pi / 32, 50)
    phase = 2 * np.pi * np.arange(32) / 32
    mean = [np.asarray(closed_share(jnp.asarray(np.sin(phase + o) - 0.4))).mean() for o in offsets]
    np.testing.assert_allclose(mean, np.arccos(0.4) / np.pi, atol=3e-3)
    assert np.abs(np.diff(mean)).max() < 1e-3


def test_amplitude_damper_takes_the_cube_of_the_amplitude():
    """4/3 c w A^3 a cycle, whatever the mean position."""
    g = ElementGroup(AmplitudeDamper(), AmplitudeDamperParameters(np.array([3.0])), np.array([[0]]))
    for amplitude in (1.0, 2.0):
        motion = np.array([[[5.0, amplitude, 0.0, 0.0, 0.0]]])
        u, force = over_period(g, g.law.force, motion, 0.7, HARMONICS, 256)
        _, speed = over_period(g, lambda u, v, p: v, motion, 0.7, HARMONICS, 256)  # noqa: ARG005
        work = (force * speed).mean() * 2 * np.pi / 0.7
        assert work == pytest.approx(4 / 3 * 3.0 * 0.7 * amplitude**3, rel=1e-3)
        assert u.mean() == pytest.approx(5.0)


def test_paired_dampers_tell_in_phase_from_out_of_phase():
    """Each mode of two equal places is damped by its own coefficient; equal coefficients make two single dampers."""
    rows, motion = np.array([[0, 1]]), np.array([[[5.0, 2.0, 0.0, 0.3, 0.0], [1.0, 1.0, 0.5, 0.0, 0.0]]])
    alike = ElementGroup(PairedAmplitudeDamper(), PairedAmplitudeDamperParameters(*np.full((2, 1), 3.0)), rows)
    _, both = over_period(alike, alike.law.force, motion, 0.7, HARMONICS, 64)
    for i in range(2):
        single = ElementGroup(AmplitudeDamper(), AmplitudeDamperParameters(np.array([3.0])), np.array([[0]]))
        _, force = over_period(single, single.law.force, motion[:, [i]], 0.7, HARMONICS, 64)
        np.testing.assert_allclose(both[..., i], force[..., 0], rtol=1e-12, atol=1e-12)
    apart = ElementGroup(PairedAmplitudeDamper(), PairedAmplitudeDamperParameters(*np.array([[3.0], [4.0]])), rows)
    for sign, c in ((1.0, 3.0), (-1.0, 4.0)):
        together = np.stack([motion[0, 0], sign * motion[0, 0]])[None]
        _, force = over_period(apart, apart.law.force, together, 0.7, HARMONICS, 64)
        np.testing.assert_allclose(force[..., 0], both[..., 0] * c / 3.0, rtol=1e-12, atol=1e-12)
