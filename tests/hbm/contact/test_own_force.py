"""A user's law that takes all but the force from one of the friction laws."""

from dataclasses import dataclass
from typing import Any

import jax
import numpy as np

from updamp.hbm.contact.friction import FrictionParameters
from updamp.hbm.contact.jenkins_box import JenkinsBox
from updamp.hbm.contact.jenkins_box_sampled import SampledJenkinsBox
from updamp.hbm.contact.modified.film import ViscousFilm
from updamp.hbm.contact.modified.pressure_stiffness import PressureStiffness
from updamp.hbm.harmonics import Harmonics
from updamp.hbm.problem.elements import ElementGroup, departures

HARMONICS, ROWS = Harmonics((0, 1)), np.arange(6).reshape(2, 3)
FRICTION = FrictionParameters(*(np.full(2, value) for value in (0.5, 1.0, 1.0, 1.0)), np.zeros((2, 2)), np.zeros(2))


@dataclass(frozen=True)
class Skew(SampledJenkinsBox):
    """A motion in one direction makes a force in the next one too, as long as the contact sticks."""

    def force(self, displacement: jax.Array, velocity: jax.Array, parameters: Any) -> jax.Array:
        return super().force(displacement, velocity, parameters) + 0.25 * displacement[:, [2, 0, 1]]


@dataclass(frozen=True)
class DoubledBox(JenkinsBox):
    def averaged_force(self, displacement: jax.Array, velocity: jax.Array, parameters: Any) -> jax.Array:
        return 2 * super().averaged_force(displacement, velocity, parameters)


@dataclass(frozen=True)
class DoubledFilm(ViscousFilm):
    def force(self, displacement: jax.Array, velocity: jax.Array, parameters: Any) -> jax.Array:
        return 2 * super().force(displacement, velocity, parameters)


def test_it_is_evaluated_where_the_other_law_would_surely_stick_and_its_directions_are_not_taken_for_decoupled() -> (
    None
):
    x = 1e-3 * np.random.default_rng(2).normal(size=(2, 3, 3))
    assert not len(ElementGroup(SampledJenkinsBox(2), FRICTION, ROWS).may_slip_or_separate(x, HARMONICS, 64))
    found = departures(ElementGroup(Skew(2), FRICTION, ROWS), x, 1.0, HARMONICS, 64)
    np.testing.assert_allclose(found.force, 0.25 * x[:, [2, 0, 1]], rtol=0, atol=1e-15)
    skew = 0.25 * np.einsum("df,ab->dafb", np.eye(3)[[2, 0, 1]], np.eye(3))
    np.testing.assert_allclose(found.tangent, [skew, skew], rtol=0, atol=1e-14)


def test_it_is_no_sum_of_the_other_laws_parts_and_not_compiled_where_the_pressure_stiffens_it() -> None:
    assert ElementGroup(ViscousFilm(JenkinsBox(2)), _filmed(), ROWS).parts
    assert not ElementGroup(DoubledFilm(JenkinsBox(2)), _filmed(), ROWS).parts
    assert PressureStiffness(JenkinsBox(2)).compiled(HARMONICS, 64) is not None
    assert PressureStiffness(DoubledBox(2)).compiled(HARMONICS, 64) is None


def _filmed() -> Any:
    return ViscousFilm(JenkinsBox(2)).parameters(*FRICTION, np.ones(2))
