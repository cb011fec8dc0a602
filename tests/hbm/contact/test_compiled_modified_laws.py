"""Modified laws made of compiled ones inside against their definitions in JAX: coefficients and tangents."""

import jax
import numpy as np
import pytest
from support.contact_elements import (
    ELEMENTS,
    HARMONICS,
    HELD,
    AllEvaluated,
    AtSamples,
    CoupledInJax,
    InJax,
    RateInJax,
    motions,
    of_springs,
    parameters,
)

from updamp.hbm.contact.coulomb_circle import CoulombCircle
from updamp.hbm.contact.friction import FrictionParameters
from updamp.hbm.contact.jenkins_box import JenkinsBox
from updamp.hbm.contact.jenkins_box_sampled import SampledJenkinsBox
from updamp.hbm.contact.law import CompiledLaw, compiled_forces_of
from updamp.hbm.contact.modified.film import FilmForce, ViscousFilm
from updamp.hbm.contact.modified.microslip import SLIDERS, SubPatchMicroslip, evenly
from updamp.hbm.contact.modified.modified_law import with_entries
from updamp.hbm.contact.modified.pressure_stiffness import PressureStiffness
from updamp.hbm.contact.modified.static_share import StaticShare
from updamp.hbm.contact.modified.velocity_friction import VelocityFriction
from updamp.hbm.contact.springs import CubicSpring
from updamp.hbm.problem.elements import (
    ElementGroup,
    compiled_forces,
    compiled_hysteresis,
    departures,
    element_forces,
    force_only,
    loop_areas,
)
from updamp.hbm.problem.elements_together import departures_together
from updamp.hbm.stability.contact_tangent import _follow_springs
from updamp.hbm.stability.perturbed_forces import in_jax, perturbed_tangent

MODIFIED = [
    StaticShare(JenkinsBox(2)), SubPatchMicroslip(JenkinsBox(2)), StaticShare(SubPatchMicroslip(SampledJenkinsBox(2))),
]  # fmt: skip


def modified_parameters():
    """Each element has a share and a spread of its own."""
    p, rng = parameters(), np.random.default_rng(8)
    return with_entries(p, static_share=rng.random(ELEMENTS), limit_spread=rng.random(ELEMENTS))


@pytest.mark.long
@pytest.mark.parametrize("law", MODIFIED)
def test_modified_laws_are_made_of_the_compiled_one_inside(law):
    p = modified_parameters()
    motion = motions(p)
    motion[HELD] += 0.1  # held at its limit a sampled law has ties between stick and slip
    assert_as_in_jax(law, p, motion)


def assert_as_in_jax(law, p, motion):
    """Forces with and without tangents, and loops."""
    rows = np.arange(3 * ELEMENTS).reshape(-1, 3)
    groups = [AllEvaluated(each, p, rows) for each in (law, InJax(law))]
    ours, theirs = (element_forces(group, motion, 1.0, HARMONICS, 128) for group in groups)
    np.testing.assert_allclose(ours.force, theirs.force, rtol=0, atol=1e-13 * np.abs(theirs.force).max())
    np.testing.assert_allclose(ours.tangent, theirs.tangent, rtol=0, atol=1e-11)
    alone = force_only(groups[0], motion, 1.0, HARMONICS, 128)
    np.testing.assert_allclose(alone, ours.force, rtol=0, atol=1e-14 * np.abs(ours.force).max())
    areas = [loop_areas(AllEvaluated(each, p, rows), motion, 1.0, HARMONICS, 128) for each in (law, AtSamples(law))]
    np.testing.assert_allclose(*areas, rtol=0, atol=1e-12 * np.abs(areas[1]).max())


@pytest.mark.long
@pytest.mark.parametrize(("law", "s"), [(MODIFIED[0], 0.0), (MODIFIED[1], 0.0), (MODIFIED[1], 0.03 + 0.4j)])
def test_so_are_their_tangents_to_what_grows(law, s):
    p, rows = modified_parameters(), np.arange(3 * ELEMENTS).reshape(-1, 3)
    motion, group = motions(p), ElementGroup(law, p, rows)
    numbers = np.delete(np.arange(ELEMENTS), np.r_[HELD])
    ours = perturbed_tangent(group, motion, 1.0, s, HARMONICS, 128, numbers)
    third = slice(None, None, 3)  # some of every kind: in JAX six sliders each are marched through five periods
    theirs = in_jax(group, motion, 1.0, s, HARMONICS, 128, numbers[third])
    if isinstance(law, SubPatchMicroslip):  # one slider of an element may be at rest, and another move
        mu = [p.mu * (1 + p.limit_spread * factor) for factor in evenly(SLIDERS)]
        each = [ElementGroup(law.inner, p._replace(mu=one), rows) for one in mu]
        rest = [_follow_springs(one, motion.reshape(-1, 7), 1.0, HARMONICS, 128)[numbers] for one in each]
        some, every = np.any(rest, axis=0), np.all(rest, axis=0)
        assert (some & ~every).sum() > 3
        np.testing.assert_allclose(ours[every], of_springs(group, numbers)[every], rtol=0, atol=1e-13)
    else:
        seen = motion * np.where(np.arange(7) == 0, p.static_share[:, None, None], 1.0)
        inside = ElementGroup(law.inner, p, rows)
        some = _follow_springs(inside, seen.reshape(-1, 7), 1.0, HARMONICS, 128)[numbers]
    np.testing.assert_allclose(ours[third][~some[third]], theirs[~some[third]], rtol=0, atol=1e-11)


@pytest.mark.long
@pytest.mark.parametrize(
    "law",
    [
        ViscousFilm(JenkinsBox(2)), ViscousFilm(SubPatchMicroslip(JenkinsBox(2))),
        StaticShare(ViscousFilm(JenkinsBox(2))), StaticShare(ViscousFilm(VelocityFriction(JenkinsBox(2)))),
    ],
)  # fmt: skip
def test_a_film_is_the_compiled_law_inside_and_dashpots_beside_it(law):
    rng, w = np.random.default_rng(9), 1.7
    entries = ("viscosity", "limit_spread", "static_share", "reference_speed")
    p = with_entries(parameters(), **{name: rng.random(ELEMENTS) for name in entries})
    p = with_entries(p, velocity_drop=0.6 * rng.random(ELEMENTS))
    motion, rows = motions(p), np.arange(3 * ELEMENTS).reshape(-1, 3)
    group = ElementGroup(law, p, rows)
    inside = [part.law for part in group.parts]
    assert len(inside) == 2
    assert all(compiled_forces(a, HARMONICS, 128) for a in inside)
    ours, theirs = (
        element_forces(g, motion, w, HARMONICS, 128) for g in (group, ElementGroup(CoupledInJax(law), p, rows))
    )
    size = np.abs(theirs.force).max()
    np.testing.assert_allclose(ours.force, theirs.force, rtol=0, atol=1e-13 * size)
    np.testing.assert_allclose(ours.tangent, theirs.tangent, rtol=0, atol=1e-10)
    np.testing.assert_allclose(ours.frequency_derivative, theirs.frequency_derivative, rtol=0, atol=1e-12 * size)
    np.testing.assert_allclose(force_only(group, motion, w, HARMONICS, 128), ours.force, rtol=0, atol=1e-13 * size)


@pytest.mark.parametrize("inner", [JenkinsBox(2), PressureStiffness(SubPatchMicroslip(JenkinsBox(2)))])
def test_dashpots_that_open_with_the_contact_are_those_of_the_law_in_jax(inner):
    law, rng, w = FilmForce(inner), np.random.default_rng(12), 1.7
    p = with_entries(pressed_parameters(), viscosity=rng.random(ELEMENTS), limit_spread=rng.random(ELEMENTS))
    motion, rows = motions(p), np.arange(3 * ELEMENTS).reshape(-1, 3)
    motion[19, 2, 0] -= 100.0  # open throughout
    assert compiled_forces(law, HARMONICS, 128) is not None
    groups = [ElementGroup(each, p, rows) for each in (law, RateInJax(law))]
    ours, theirs = (element_forces(each, motion, w, HARMONICS, 128) for each in groups)
    size = np.abs(theirs.force).max()
    np.testing.assert_allclose(ours.force, theirs.force, rtol=0, atol=1e-13 * size)
    np.testing.assert_allclose(ours.tangent, theirs.tangent, rtol=0, atol=1e-10)
    np.testing.assert_allclose(ours.frequency_derivative, theirs.frequency_derivative, rtol=0, atol=1e-12 * size)
    np.testing.assert_allclose(force_only(groups[0], motion, w, HARMONICS, 128), ours.force, rtol=0, atol=1e-13 * size)
    assert not ours.force[19].any()
    opening = np.abs(ours.tangent[:, :2, :, 2]).max(axis=(1, 2, 3)) > 0
    assert 10 < opening.sum() < ELEMENTS


@pytest.mark.parametrize("law", [ViscousFilm(JenkinsBox(2)), VelocityFriction(JenkinsBox(2))])
def test_motions_of_several_frequencies_together_are_those_one_by_one(law):
    rng, w = np.random.default_rng(13), np.array([0.8, 1.7, 3.1])
    entries = ("viscosity", "velocity_drop", "reference_speed")
    p = with_entries(parameters(), **{name: 0.1 + 0.5 * rng.random(ELEMENTS) for name in entries})
    group = ElementGroup(law, p, np.arange(3 * ELEMENTS).reshape(-1, 3))
    motion = np.array([(1 + 0.1 * i) * motions(p) for i in range(3)])
    together = departures_together(group, motion, w, HARMONICS, 128)
    for x, of, found in zip(motion, w, together, strict=True):
        alone = departures(group, x, float(of), HARMONICS, 128)
        for one, other in zip(
            (found.force, found.tangent, found.frequency_derivative),
            (alone.force, alone.tangent, alone.frequency_derivative),
            strict=True,
        ):
            np.testing.assert_allclose(one, other, rtol=0, atol=1e-13 * np.abs(other).max())


@pytest.mark.long
@pytest.mark.parametrize(
    "law",
    [
        VelocityFriction(JenkinsBox(2)), StaticShare(VelocityFriction(JenkinsBox(2))),
        SubPatchMicroslip(VelocityFriction(JenkinsBox(2))), PressureStiffness(VelocityFriction(JenkinsBox(2))),
        PressureStiffness(SubPatchMicroslip(VelocityFriction(JenkinsBox(2)))),
    ],
)  # fmt: skip
def test_friction_that_depends_on_the_speed_is_the_compiled_law_with_friction_that_varies(law):
    rng, w = np.random.default_rng(10), 1.7
    of_speed = {"velocity_drop": 0.6 * rng.random(ELEMENTS), "reference_speed": 0.2 + rng.random(ELEMENTS)}
    p = with_entries(pressed_parameters(), **of_speed, limit_spread=rng.random(ELEMENTS))
    motion, rows = motions(p), np.arange(3 * ELEMENTS).reshape(-1, 3)
    assert compiled_forces(law, HARMONICS, 128) is not None
    groups = [AllEvaluated(each, p, rows) for each in (law, CoupledInJax(law))]
    ours, theirs = (element_forces(each, motion, w, HARMONICS, 128) for each in groups)
    size = np.abs(theirs.force).max()
    np.testing.assert_allclose(ours.force, theirs.force, rtol=0, atol=1e-13 * size)
    np.testing.assert_allclose(ours.tangent, theirs.tangent, rtol=0, atol=1e-10)
    np.testing.assert_allclose(ours.frequency_derivative, theirs.frequency_derivative, rtol=0, atol=1e-11 * size)
    assert np.abs(ours.frequency_derivative).max() > 0.01
    some = element_forces(ElementGroup(law, p, rows), motion, w, HARMONICS, 128)  # without those that surely stick
    np.testing.assert_allclose(some.tangent, theirs.tangent, rtol=0, atol=1e-10)
    np.testing.assert_allclose(force_only(groups[0], motion, w, HARMONICS, 128), ours.force, rtol=0, atol=1e-13 * size)


def pressed_parameters():
    rng = np.random.default_rng(11)
    exponent, share = 0.6 * rng.random(ELEMENTS), rng.random(ELEMENTS)
    return with_entries(
        parameters(), pressure_exponent=exponent, mean_force=0.3 + rng.random(ELEMENTS), static_share=share
    )


@pytest.mark.long
@pytest.mark.parametrize(
    "law",
    [
        PressureStiffness(JenkinsBox(2)), StaticShare(PressureStiffness(JenkinsBox(3))),
        PressureStiffness(SubPatchMicroslip(JenkinsBox(2))),
    ],
)  # fmt: skip
def test_stiffness_that_depends_on_the_pressure_is_that_of_the_law_in_jax(law):
    p = with_entries(pressed_parameters(), limit_spread=np.random.default_rng(14).random(ELEMENTS))
    assert compiled_forces_of(law, HARMONICS, 128) is not None
    assert_as_in_jax(law, p, motions(p))


@pytest.mark.long
@pytest.mark.parametrize("s", [0.0, 0.03 + 0.4j])
def test_so_is_its_tangent_to_what_grows(s):
    law, p = PressureStiffness(JenkinsBox(2)), pressed_parameters()
    motion, group = motions(p), ElementGroup(law, p, np.arange(3 * ELEMENTS).reshape(-1, 3))
    numbers = np.delete(np.arange(ELEMENTS), np.r_[HELD])  # held at a limit there are ties
    ours = perturbed_tangent(group, motion, 1.0, s, HARMONICS, 128, numbers)
    theirs = in_jax(group, motion, 1.0, s, HARMONICS, 128, numbers)
    still = element_forces(group, motion, 1.0, HARMONICS, 128).tangent[numbers]
    # a slider at rest, where the first of all periods has pushed it, follows its spring
    inside = ElementGroup(JenkinsBox(2), settled(p), group.rows)
    at_rest = _follow_springs(inside, motion.reshape(-1, 7), 1.0, HARMONICS, 128)[numbers]
    assert 3 < (~at_rest[:, :2]).sum() < at_rest[:, :2].size
    np.testing.assert_allclose(ours[~at_rest], theirs[~at_rest], rtol=0, atol=1e-11)
    assert s == 0 or np.abs(ours - still).max() > 0.01, "growth counts"


def settled(p):
    """Parameters of the law inside."""
    each = jax.vmap(lambda one: PressureStiffness(JenkinsBox(2)).inner_arguments(None, None, one)[2])(p)
    return FrictionParameters(*(np.asarray(value) for value in each[:6]))


def test_a_law_inside_that_is_not_compiled_leaves_them_to_jax():
    assert compiled_forces_of(SubPatchMicroslip(CoulombCircle(3)), HARMONICS, 128) is None
    assert compiled_forces_of(VelocityFriction(SampledJenkinsBox(2)), HARMONICS, 128) is None


def test_loops_and_what_grows_are_left_to_jax_where_a_law_depends_on_the_rate_or_has_no_memory():
    assert compiled_hysteresis(StaticShare(JenkinsBox(2)), HARMONICS, 128) is not None
    for law in (StaticShare(VelocityFriction(JenkinsBox(2))), FilmForce(JenkinsBox(2)), CubicSpring()):
        assert compiled_forces(law, HARMONICS, 128) is not None
        assert compiled_hysteresis(law, HARMONICS, 128) is None


def test_a_modified_law_is_not_taken_for_the_one_inside():
    assert isinstance(JenkinsBox(2), CompiledLaw)
    assert not isinstance(ViscousFilm(JenkinsBox(2)), CompiledLaw)
