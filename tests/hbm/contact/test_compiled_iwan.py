"""Iwan's sliders written out for numba against their definition in JAX: coefficients, tangents and loops."""

from dataclasses import dataclass
from typing import Any, ClassVar

import jax
import numpy as np
import pytest
from numpy.typing import NDArray

from updamp.hbm.contact.iwan import REFERENCE_DISPLACEMENT, IwanMicroslip, IwanParameters
from updamp.hbm.contact.law import CompiledLaw
from updamp.hbm.harmonics import Harmonics
from updamp.hbm.problem.elements import ElementGroup, element_forces, force_only, loop_areas
from updamp.hbm.stability.perturbed_forces import in_jax, perturbed_tangent

HARMONICS, SAMPLES, ELEMENTS = Harmonics((0, 1, 2, 3)), 128, 40
AT_REST = 5
LAW = IwanMicroslip()


@dataclass(frozen=True)
class InJax:
    """The law without what is compiled."""

    law: IwanMicroslip
    directions: ClassVar[int] = 1
    rate_dependent: ClassVar[bool] = False
    parameters: ClassVar[type] = IwanParameters
    cycles: ClassVar[int] = 2

    def force(self, displacement: jax.Array, velocity: jax.Array, parameters: Any) -> jax.Array:
        return self.law.force(displacement, velocity, parameters)

    def reference_stiffness(self, parameters: Any) -> jax.Array:
        return self.law.reference_stiffness(parameters)


def group(law: Any) -> ElementGroup:
    """All different; of a third gross slip is within reach."""
    rng = np.random.default_rng(3)
    lost, exponent = 1e3 * (1 + rng.random(ELEMENTS)), rng.uniform(-0.8, 0.8, ELEMENTS)
    nearness = np.where(np.arange(ELEMENTS) % 3 > 0, 0, rng.random(ELEMENTS))
    return ElementGroup(law, IwanParameters(lost, exponent, nearness), np.arange(ELEMENTS)[:, None])  # type: ignore[arg-type]


def motions() -> NDArray[np.float64]:
    """From a micrometre to a millimetre, away from the mean too; one element at rest."""
    motion = np.random.default_rng(4).normal(size=(ELEMENTS, 1, 7)) * np.array([0.3, 2, 2, 0.3, 0.3, 0.2, 0.2])
    motion *= np.geomspace(1e-6, 1e-3, ELEMENTS)[:, None, None]
    motion[AT_REST] = 0.0
    return motion


def slips_grossly(motion: NDArray[np.float64]) -> NDArray[np.bool_]:
    largest = np.abs(motion[:, 0] @ HARMONICS.synthesis(SAMPLES).T).max(axis=1)
    found: NDArray[np.bool_] = largest * group(LAW).values.nearness > REFERENCE_DISPLACEMENT
    assert 3 < found.sum() < ELEMENTS / 2
    return found


def of_each(tangent: NDArray[Any]) -> NDArray[np.float64]:
    """(n_elements,) largest entry"""
    return np.asarray(np.abs(tangent).max(axis=(1, 2, 3, 4)))


@pytest.mark.parametrize("cycles", [1, 2, 3])
def test_coefficients_and_tangents_are_those_of_the_law_in_jax(cycles: int) -> None:
    law = IwanMicroslip(cycles)
    ours, theirs = (element_forces(group(each), motions(), 1.0, HARMONICS, SAMPLES) for each in (law, InJax(law)))
    assert isinstance(law, CompiledLaw)
    size = np.abs(theirs.force).max(axis=(1, 2))
    assert (np.abs(ours.force - theirs.force).max(axis=(1, 2)) <= 1e-13 * size).all()
    assert (of_each(ours.tangent - theirs.tangent) <= 1e-12 * of_each(theirs.tangent)).all()
    assert not ours.tangent[AT_REST].any()
    np.testing.assert_array_equal(force_only(group(law), motions(), 1.0, HARMONICS, SAMPLES), ours.force)


def test_tangents_are_those_of_differences() -> None:
    """Where a step changes which sample is the largest, or which one moves a slider, it crosses a corner; such steps
    are small, and few."""
    motion = motions()
    tangent = element_forces(group(LAW), motion, 1.0, HARMONICS, SAMPLES).tangent[:, 0, :, 0]
    moving = np.delete(np.arange(ELEMENTS), AT_REST)
    for c in range(7):
        step = np.zeros_like(motion)
        step[:, 0, c] = 1e-7 * np.abs(motion).max(axis=(1, 2))
        after, before = (
            force_only(group(LAW), motion + sign * step, 1.0, HARMONICS, SAMPLES)[moving, 0] for sign in (1, -1)
        )
        difference = (after - before) / (2 * step[moving, 0, c, None])
        size = np.abs(tangent[moving]).max(axis=(1, 2))
        off = np.abs(difference - tangent[moving, :, c]).max(axis=1) / size
        assert np.median(off) < 1e-7
        assert off.max() < 1e-3


def test_loop_areas_are_those_of_the_law_in_jax() -> None:
    ours, theirs = (loop_areas(group(each), motions(), 1.0, HARMONICS, 256) for each in (LAW, InJax(LAW)))
    np.testing.assert_allclose(ours, theirs, rtol=1e-12)


def test_elements_that_are_not_asked_for_are_left_alone() -> None:
    motion = motions()
    force, tangent = np.full_like(motion, 7.0), np.full((*motion.shape, 1, 7), 7.0)
    rate, some = np.zeros_like(motion), np.array([3, 30])
    LAW.compiled(HARMONICS, SAMPLES).write_with_tangents(some, motion, 1.0, group(LAW).values, force, tangent, rate)
    others = np.delete(np.arange(ELEMENTS), [3, 30])
    assert (force[others] == 7.0).all()
    assert (tangent[others] == 7.0).all()
    assert (force[[3, 30]] != 7.0).all()


@pytest.mark.parametrize("s", [0.0, 0.03 + 0.4j, -0.05 + 0.1j])
def test_tangents_to_what_grows_are_those_of_the_law_in_jax(s: complex) -> None:
    """Where all sliders slip. Below, where they follow the largest displacement, the law in JAX takes the mean of that
    of all periods marched, which grow; here it is the last one before the sample. At s = 0 there is no difference."""
    motion = motions()
    everywhere = np.arange(ELEMENTS)
    ours = perturbed_tangent(group(LAW), motion, 1.0, s, HARMONICS, SAMPLES)
    theirs = in_jax(group(LAW), motion, 1.0, s, HARMONICS, SAMPLES, everywhere)
    still = element_forces(group(LAW), motion, 1.0, HARMONICS, SAMPLES).tangent
    compared = everywhere if s == 0 else np.flatnonzero(slips_grossly(motion))
    assert (of_each(ours - theirs)[compared] <= 1e-12 * of_each(still)[compared]).all()
    assert s == 0 or of_each(ours - still).max() > 0.01 * of_each(still).max(), "growth counts"
