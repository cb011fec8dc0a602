"""The laws written out for numba against their definitions in JAX: coefficients and tangents."""

import numpy as np
import pytest
from support.contact_elements import (
    ELEMENTS,
    GRAZING,
    HARMONICS,
    HELD,
    AllEvaluated,
    AtSamples,
    InJax,
    motions,
    of_springs,
    parameters,
)

from updamp.hbm.contact.jenkins_box import JenkinsBox
from updamp.hbm.contact.jenkins_box_sampled import SampledJenkinsBox
from updamp.hbm.contact.law import SEPARATED, SLIP
from updamp.hbm.harmonics import Harmonics
from updamp.hbm.problem.elements import (
    ElementGroup,
    element_forces,
    force_only,
    loop_areas,
    over_period,
)
from updamp.hbm.stability.contact_tangent import _follow_springs
from updamp.hbm.stability.perturbed_forces import in_jax, perturbed_tangent


def both(law, p, motion, samples=128):
    rows = np.arange(3 * ELEMENTS).reshape(-1, 3)
    groups = AllEvaluated(law, p, rows), AllEvaluated(InJax(law), p, rows)
    ours, theirs = (element_forces(group, motion, 1.0, HARMONICS, samples) for group in groups)
    if isinstance(law, SampledJenkinsBox):
        # held at its limit, each sample is a tie between stick and slip, of which JAX takes the mean of both sides
        assert np.isfinite(ours.tangent[HELD]).all()
        ours.tangent[HELD] = theirs.tangent[HELD]
    return ours, theirs


@pytest.mark.parametrize("law", [JenkinsBox(2), SampledJenkinsBox(2)])
def test_coefficients_and_tangents_are_those_of_the_law_in_jax(law):
    p = parameters()
    ours, theirs = both(law, p, motions(p))
    np.testing.assert_allclose(ours.force, theirs.force, rtol=0, atol=1e-13 * np.abs(theirs.force).max())
    np.testing.assert_allclose(ours.tangent, theirs.tangent, rtol=0, atol=1e-11)


@pytest.mark.parametrize("law", [JenkinsBox(3), SampledJenkinsBox(1)])
def test_likewise_where_friction_varies_over_the_period(law):
    p = parameters(mu=0.5 + 0.3 * np.random.default_rng(5).random((ELEMENTS, 1)) * np.cos(HARMONICS.phase(128)))
    ours, theirs = both(law, p, motions(p))
    np.testing.assert_allclose(ours.force, theirs.force, rtol=0, atol=1e-13 * np.abs(theirs.force).max())
    np.testing.assert_allclose(ours.tangent, theirs.tangent, rtol=0, atol=1e-11)


def test_likewise_where_a_contact_closes_between_two_samples_alone():
    """Its force would jump from one moment to the next as the highest point passes a sample."""
    p = parameters(mu=np.full(ELEMENTS, 0.5), n0=np.zeros(ELEMENTS), gap=np.zeros(ELEMENTS))
    motion = motions(p)
    half_a_step = np.pi / 128
    motion[:, 2] = 0.0
    motion[:, 2, 1:3] = np.cos(half_a_step), np.sin(half_a_step)  # highest half way between two samples
    rises = 1 - np.cos(half_a_step)  # from the samples beside it to the highest point
    motion[:, 2, 0] = -1 + np.linspace(0.1, 1.0, ELEMENTS) * rises  # at no sample above zero
    assert ((HARMONICS.synthesis(128) @ motion[:, 2].T).max(axis=0) < 1e-15).all()
    ours, theirs = both(JenkinsBox(2), p, motion)
    assert np.abs(theirs.force[:, 2]).max(axis=1).min() > 0
    scale = np.abs(theirs.force[:, 2]).max()
    np.testing.assert_allclose(ours.force[:, 2], theirs.force[:, 2], rtol=0, atol=1e-9 * scale)
    np.testing.assert_allclose(ours.tangent, theirs.tangent, rtol=0, atol=1e-11)


def test_likewise_where_a_motion_of_a_high_order_turns_often_between_few_samples():
    harmonics, law, p = Harmonics((0, 1, 11)), JenkinsBox(2), parameters()
    motion = np.random.default_rng(6).normal(size=(ELEMENTS, 3, 5))
    rows = np.arange(3 * ELEMENTS).reshape(-1, 3)
    ours, theirs = (force_only(AllEvaluated(each, p, rows), motion, 1.0, harmonics, 64) for each in (law, InJax(law)))
    np.testing.assert_allclose(ours, theirs, rtol=0, atol=1e-13 * np.abs(theirs).max())


@pytest.mark.parametrize("law", [JenkinsBox(2), SampledJenkinsBox(2)])
def test_elements_that_are_not_asked_for_are_left_alone(law):
    p, motion = parameters(), motions(parameters())
    force, tangent = np.full_like(motion, 7.0), np.full((*motion.shape, 3, 7), 7.0)
    rate = np.zeros_like(motion)
    law.compiled(HARMONICS, 128).write_with_tangents(np.array([3, 40]), motion, 1.0, p, force, tangent, rate)
    assert not rate.any()
    others = np.delete(np.arange(ELEMENTS), [3, 40])
    assert (force[others] == 7.0).all()
    assert (tangent[others] == 7.0).all()
    alone = np.full_like(motion, 7.0)
    law.compiled(HARMONICS, 128).write_forces(np.array([3, 40]), motion, 1.0, p, alone)
    np.testing.assert_array_equal(alone, force)


def test_contact_states_are_those_of_the_law_in_jax():
    """At many samples: what is told without them sees the shortest opening too."""
    p, motion, rows = parameters(), motions(parameters()), np.arange(3 * ELEMENTS).reshape(-1, 3)
    ours = JenkinsBox(2).compiled(HARMONICS, 128).contact_states(np.arange(ELEMENTS), motion, p)
    _, states = over_period(ElementGroup(JenkinsBox(2), p, rows), JenkinsBox(2).state, motion, 1.0, HARMONICS, 2048)
    open_, slips = states == SEPARATED, (states == SLIP).any(axis=1)
    theirs = np.where(open_.all(axis=1), 3, np.where(open_.any(axis=1), 2, slips))
    np.testing.assert_array_equal(np.delete(ours, GRAZING), np.delete(theirs, GRAZING))
    assert set(ours) == {0, 1, 2, 3}


@pytest.mark.parametrize("law", [JenkinsBox(2), SampledJenkinsBox(2)])
def test_loop_areas_are_those_of_the_law_in_jax(law):
    p, rows = parameters(), np.arange(3 * ELEMENTS).reshape(-1, 3)
    ours = loop_areas(ElementGroup(law, p, rows), motions(p), 1.0, HARMONICS, 256)
    theirs = loop_areas(ElementGroup(AtSamples(law), p, rows), motions(p), 1.0, HARMONICS, 256)
    np.testing.assert_allclose(ours, theirs, rtol=0, atol=1e-12 * np.abs(theirs).max())


@pytest.mark.long
@pytest.mark.parametrize("s", [0.0, 0.03 + 0.4j, -0.05 + 0.1j])
@pytest.mark.parametrize("law", [JenkinsBox(2), SampledJenkinsBox(2)])
def test_tangents_to_what_grows_are_those_of_the_law_in_jax(law, s):
    """Sliders that were moved in the period before remember a change that was smaller or larger then."""
    p = parameters()
    motion, group = motions(p), ElementGroup(law, p, np.arange(3 * ELEMENTS).reshape(-1, 3))
    numbers = np.delete(np.arange(ELEMENTS), np.r_[HELD])  # held at a limit there are ties
    ours = perturbed_tangent(group, motion, 1.0, s, HARMONICS, 128, numbers)
    theirs = in_jax(group, motion, 1.0, s, HARMONICS, 128, numbers)
    # A slider at rest, where the first of all periods has pushed it, has no tangent of its own (contact_tangent.py).
    at_rest = _follow_springs(group, motion.reshape(-1, 7), 1.0, HARMONICS, 128)[numbers]
    assert 3 < (~at_rest[:, :2]).sum() < at_rest[:, :2].size
    np.testing.assert_allclose(ours[~at_rest], theirs[~at_rest], rtol=0, atol=1e-11)
    np.testing.assert_allclose(ours[at_rest], of_springs(group, numbers)[at_rest], rtol=0, atol=1e-13)
    still = perturbed_tangent(group, motion, 1.0, 0.0, HARMONICS, 128, numbers)
    assert s == 0 or np.abs(ours - still).max() > 0.01, "growth counts"
