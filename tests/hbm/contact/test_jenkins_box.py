"""The box law with its events between the samples: accuracy, smoothness, the cone, settling."""

from dataclasses import dataclass
from typing import Any, ClassVar

import jax
import jax.numpy as jnp
import numpy as np
import pytest

from updamp.hbm.contact.coulomb_circle import CoulombCircle
from updamp.hbm.contact.friction import FrictionParameters
from updamp.hbm.contact.jenkins_box import JenkinsBox
from updamp.hbm.contact.jenkins_box_sampled import SampledJenkinsBox
from updamp.hbm.contact.law import force_for_analysis
from updamp.hbm.contact.modified.microslip import SubPatchMicroslip
from updamp.hbm.contact.modified.modified_law import with_entries
from updamp.hbm.contact.modified.velocity_friction import VelocityFriction
from updamp.hbm.harmonics import Harmonics
from updamp.hbm.problem.elements import ElementGroup, element_forces, force_only, over_period

HARMONICS = Harmonics((0, 1, 2, 3))
SHARE = np.linspace(0.0, 0.2, 201)
ELEMENTS = 24


@pytest.fixture(scope="module")
def motions():
    """Elements that stick, slip and separate, and for each a direction in which its motion changes."""
    rng = np.random.default_rng(0)
    motion = rng.normal(size=(ELEMENTS, 3, 7)) * np.array([0.4, 2, 2, 0.3, 0.3, 0.2, 0.2])
    motion[:, 2] *= 0.6
    return motion, rng.normal(size=motion.shape)


def group(law):
    every = np.ones(ELEMENTS)
    parameters = FrictionParameters(
        0.6 * every, 1.0 * every, 1.3 * every, every, np.zeros((ELEMENTS, 2)), np.zeros(ELEMENTS)
    )
    return ElementGroup(law, parameters, np.arange(3 * ELEMENTS).reshape(-1, 3))


def forces(law, motion, samples):
    return element_forces(group(law), motion, 1.0, HARMONICS, samples)


def forces_alone(law, motion, samples):
    """Without tangents a law compiles in half the time."""
    return force_only(group(law), motion, 1.0, HARMONICS, samples)


def test_error_falls_with_the_fourth_power_of_the_step_and_that_of_samples_alone_with_the_step(motions):
    exact = forces_alone(JenkinsBox(2), motions[0], 2**12)
    steps = np.array([64, 128, 256, 512])
    orders, errors = [], []
    for law in (JenkinsBox(2), SampledJenkinsBox(2)):
        error = [np.sqrt(np.mean((forces_alone(law, motions[0], n) - exact) ** 2)) for n in steps]
        orders.append(-np.polyfit(np.log(steps), np.log(error), 1)[0])
        errors.append(error)
    assert orders[0] > 3.8
    assert 0.8 < orders[1] < 1.5
    assert errors[0][1] < errors[1][1] / 1e4
    nearly = forces_alone(SampledJenkinsBox(2), motions[0], 2**16)
    np.testing.assert_allclose(nearly, exact, atol=2e-5)  # both come to the same


def test_friction_that_hardly_yields_before_it_slips_needs_no_more_samples(motions):
    """A slider turns and slips back between two samples; the path from one limit to the other is a step."""
    rigid = group(JenkinsBox(2)).parameters._replace(kt=np.full(ELEMENTS, 1e4))
    g = ElementGroup(JenkinsBox(2), rigid, np.arange(3 * ELEMENTS).reshape(-1, 3))
    coarse, fine = (force_only(g, motions[0], 1.0, HARMONICS, n) for n in (128, 2**12))
    np.testing.assert_allclose(coarse[:, :2], fine[:, :2], atol=1e-4)
    # Coulomb's friction: a square wave of the limit where the normal force is constant
    motion = np.zeros((1, 3, 7))
    motion[0, 0, 1] = 2.0
    one = type(rigid)(*(value[:1] for value in rigid))
    g = ElementGroup(JenkinsBox(2), one, np.arange(3).reshape(1, 3))
    force = force_only(g, motion, 1.0, HARMONICS, 128)[0, 0]
    np.testing.assert_allclose(np.hypot(force[1], force[2]), 4 / np.pi * 0.6, rtol=1e-4)


def test_tangent_hardly_jumps_where_events_pass_samples(motions):
    """Along a line of motions: the largest jump of the mean force's slope, against that of the law at its samples."""
    motion, direction = motions
    largest = []
    for law in (JenkinsBox(2), SampledJenkinsBox(2)):
        tangents = [forces(law, motion + s * direction, 128).tangent for s in SHARE]
        slopes = np.array([np.einsum("edabc,ebc->eda", t, direction) for t in tangents])
        jumps = np.abs(np.diff(slopes[..., 0], axis=0)).max(axis=0)[:, :2]
        largest.append(float(np.median(jumps)))
    assert largest[0] < largest[1] / 4


def test_tangent_is_that_of_differences(motions):
    motion, direction = motions
    step = 1e-6
    tangent = np.einsum("edabc,ebc->eda", forces(JenkinsBox(2), motion, 128).tangent, direction)
    ahead, behind = (forces(JenkinsBox(2), motion + s * direction, 128).force for s in (step, -step))
    np.testing.assert_allclose((ahead - behind) / (2 * step), tangent, atol=1e-7)


@dataclass(frozen=True)
class AllAtOnce:
    """The same law without saying which directions act alone."""

    law: Any
    directions: ClassVar[int] = 3
    rate_dependent: ClassVar[bool] = False
    cycles: ClassVar[int] = 2

    def force(self, displacement, velocity, parameters):
        return force_for_analysis(self.law)(displacement, velocity, parameters)

    def reference_stiffness(self, parameters):
        return self.law.reference_stiffness(parameters)


@pytest.mark.parametrize("law", [JenkinsBox(2), SampledJenkinsBox(2)])
def test_tangent_is_the_same_where_directions_that_act_alone_are_differentiated_together(motions, law):
    together, apart = (forces(each, motions[0], 128) for each in (law, AllAtOnce(law)))
    np.testing.assert_allclose(together.force, apart.force, rtol=0, atol=1e-13)
    np.testing.assert_allclose(together.tangent, apart.tangent, rtol=0, atol=1e-13)
    assert np.abs(together.tangent[:, 0, :, 2]).max() > 0.1  # of friction by the normal motion


@dataclass(frozen=True, eq=False)
class AllEvaluated(ElementGroup):
    """Elements of the same law, none of them taken for stuck."""

    def may_slip_or_separate(self, displacement, *_):
        return np.arange(len(displacement))


ENTRIES = {"velocity_drop": 0.4, "reference_speed": 1.0, "limit_spread": 0.8}


@pytest.mark.parametrize(
    "law",
    [
        JenkinsBox(2),
        SampledJenkinsBox(2),
        CoulombCircle(3),
        VelocityFriction(JenkinsBox(2)),
        SubPatchMicroslip(JenkinsBox(2)),
        # in JAX alone, where the samples' law compiles in a tenth of the time; which elements stick is the same rule
        SubPatchMicroslip(VelocityFriction(SampledJenkinsBox(2))),
    ],
)
def test_elements_that_are_not_evaluated_since_they_stick_have_the_forces_of_the_law(law):
    """From motions that stick by far to some that slip and separate: none is taken for stuck that is not."""
    motions = np.random.default_rng(5).normal(size=(400, 3, 7)) * np.geomspace(0.01, 1.0, 400)[:, None, None]
    values = group(JenkinsBox(2)).parameters
    p = type(values)(*(np.repeat(np.asarray(v)[:1], 400, axis=0) for v in values))
    wanted = {name: np.full(400, ENTRIES[name]) for name in law.parameters._fields if name in ENTRIES}
    p = with_entries(p, **wanted) if wanted else p
    some, every = (kind(law, p, np.arange(1200).reshape(400, 3)) for kind in (ElementGroup, AllEvaluated))
    left_out = 400 - len(some.may_slip_or_separate(motions, HARMONICS, 128))
    assert 50 < left_out < 350
    told, evaluated = (element_forces(g, motions, 1.0, HARMONICS, 128) for g in (some, every))
    np.testing.assert_allclose(told.force, evaluated.force, atol=1e-13)
    np.testing.assert_allclose(told.tangent, evaluated.tangent, atol=1e-12)
    np.testing.assert_allclose(force_only(some, motions, 1.0, HARMONICS, 128), evaluated.force, atol=1e-13)


def test_force_stays_within_the_friction_limit_and_vanishes_when_open(motions):
    g = group(JenkinsBox(2))
    _, force = over_period(g, g.law.force, motions[0], 1.0, HARMONICS, 128)
    _, normal = over_period(g, g.law.normal_force, motions[0], 1.0, HARMONICS, 128)
    assert (np.abs(force[..., :2]) <= 0.6 * normal[..., None] * (1 + 1e-12) + 1e-15).all()
    assert (normal == 0).any()


def test_two_cycles_are_settled(motions):
    two, three = (forces_alone(JenkinsBox(cycles), motions[0], 128) for cycles in (2, 3))
    np.testing.assert_allclose(two, three, atol=1e-14)


def test_stuck_element_is_its_springs():
    motion = jnp.zeros((1, 3, 7)).at[0, :, 1].set(jnp.array([0.1, 0.2, 0.05]))
    one = jax.tree.map(lambda value: value[:1], group(JenkinsBox(2)).parameters)
    element = ElementGroup(JenkinsBox(2), one, np.arange(3).reshape(1, 3))
    force = element_forces(element, np.asarray(motion), 1.0, HARMONICS, 64).force
    np.testing.assert_allclose(force[0], np.asarray(motion[0]) * np.array([[1.0], [1.0], [1.3]]), atol=1e-14)
