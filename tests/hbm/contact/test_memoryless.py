"""Springs and dampers as written out in NumPy against their definitions in JAX: coefficients and tangents."""

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

import jax
import jax.numpy as jnp
import numpy as np
import pytest

from updamp.hbm.contact.iwan import IwanMicroslip, IwanParameters
from updamp.hbm.contact.law import ContactLaw, force_for_analysis
from updamp.hbm.contact.memoryless import MemorylessForces, MemorylessLaw
from updamp.hbm.contact.power_law_damper import PowerLawDamper, PowerLawParameters
from updamp.hbm.contact.springs import (
    CubicParameters,
    CubicSpring,
    QuinticSpring,
    SquareSpring,
    UnilateralParameters,
    UnilateralSpring,
)
from updamp.hbm.contact.stops import Clearance, Stop
from updamp.hbm.contact.threshold_damper import ThresholdDamper, ThresholdDamperParameters
from updamp.hbm.harmonics import Harmonics
from updamp.hbm.problem.elements import ElementGroup, departures

ELEMENTS, N_TIME, W = 6, 64, 3.3
HARMONICS = Harmonics((0, 1, 2, 3))
RNG = np.random.default_rng(11)
SIZES, GAPS = RNG.random(ELEMENTS), RNG.random(ELEMENTS)
LAWS: list[tuple[Any, Any]] = [
    (CubicSpring(), CubicParameters(SIZES)),
    (SquareSpring(), CubicParameters(SIZES)),
    (QuinticSpring(), CubicParameters(SIZES)),
    (UnilateralSpring(), UnilateralParameters(SIZES, GAPS - 0.5)),
    (Stop(), UnilateralParameters(-SIZES, GAPS - 0.5)),
    (Clearance(), UnilateralParameters(SIZES, GAPS)),
    (PowerLawDamper(0.3), PowerLawParameters(SIZES, 1 + 2 * GAPS)),
    (ThresholdDamper(), ThresholdDamperParameters(SIZES, GAPS)),
]


def by_definition(law: ContactLaw, parameters: Any) -> Callable[[Any, Any], jax.Array]:
    """Coefficients of the force (n_elements, n_coefficients), from those of the motion and the angular frequency."""
    force_samples, analysis = force_for_analysis(law), HARMONICS.analysis(N_TIME)

    def of_one(x: jax.Array, w: jax.Array, p: Any) -> jax.Array:
        displacement, velocity = HARMONICS.synthesis(N_TIME) @ x, w * (HARMONICS.synthesis_rate(N_TIME) @ x)
        return analysis @ force_samples(displacement[:, None], velocity[:, None], p)[:, 0]

    return lambda x, w: jax.vmap(of_one, in_axes=(0, None, 0))(x, w, parameters)


@pytest.mark.parametrize(("law", "parameters"), LAWS, ids=lambda value: type(value).__name__)
def test_forces_and_tangents_are_those_of_the_definition(law: MemorylessLaw, parameters: Any) -> None:
    x = RNG.normal(size=(ELEMENTS, HARMONICS.n_coefficients))
    defined = by_definition(law, parameters)
    force = np.zeros((ELEMENTS, 1, HARMONICS.n_coefficients))
    tangent = np.zeros((*force.shape, *force.shape[1:]))
    rate, alone = np.zeros_like(force), np.zeros_like(force)
    forces, every = MemorylessForces(law, HARMONICS, N_TIME), np.arange(ELEMENTS)
    forces.write_with_tangents(every, x[:, None], W, parameters, force, tangent, rate)
    forces.write_forces(every, x[:, None], W, parameters, alone)
    scale = np.abs(force).max()
    by_motion = jax.vmap(jax.jacfwd(lambda one, p: by_one(law, p)(one)))(x, parameters)
    assert np.array_equal(force, alone)
    assert np.abs(force[:, 0] - defined(x, W)).max() < 1e-13 * scale
    assert np.abs(tangent[:, 0, :, 0] - by_motion).max() < 1e-12 * scale
    by_w = jax.jacfwd(lambda w: defined(x, w))(W)
    assert np.abs(rate[:, 0] - by_w).max() < 1e-12 * scale
    assert law.rate_dependent == bool(np.any(np.asarray(by_w)))


def by_one(law: ContactLaw, parameters: Any) -> Callable[[jax.Array], jax.Array]:
    one = type(parameters)(*(value[None] for value in parameters))
    return lambda x: by_definition(law, one)(x[None], W)[0]


@pytest.mark.parametrize(("law", "parameters"), LAWS, ids=lambda value: type(value).__name__)
def test_elements_of_some_numbers_are_written_alone(law: MemorylessLaw, parameters: Any) -> None:
    """Those that surely do nothing are left out, and the others are what they are among all."""
    x = RNG.normal(size=(ELEMENTS, 1, HARMONICS.n_coefficients))
    some = type(parameters)(*(value.copy() for value in parameters))
    some[0][::2] = 0.0
    found = departures(ElementGroup(law, some, np.arange(ELEMENTS)[:, None]), x, W, HARMONICS, N_TIME)
    whole = departures(ElementGroup(law, parameters, np.arange(ELEMENTS)[:, None]), x, W, HARMONICS, N_TIME)
    # but for the last digits: products of matrices sum in another order where these have other sizes
    for part, expected in ((found.force, whole.force), (found.tangent, whole.tangent)):
        np.testing.assert_allclose(part[1::2], expected[1::2], rtol=0, atol=1e-13 * np.abs(expected).max())
    assert not found.force[::2].any()
    assert not found.tangent[::2].any()


@dataclass(frozen=True)
class Saturating(CubicSpring):
    """A user's law that takes all but the force from another one."""

    def force(self, displacement: jax.Array, velocity: jax.Array, parameters: CubicParameters) -> jax.Array:
        return parameters.coefficient * jnp.tanh(displacement + 0 * velocity)


@dataclass(frozen=True)
class Doubled(IwanMicroslip):
    def force(self, displacement: jax.Array, velocity: jax.Array, parameters: IwanParameters) -> jax.Array:
        return 2 * super().force(displacement, velocity, parameters)


def test_a_law_with_a_force_of_its_own_does_not_take_what_is_written_out_for_the_one_it_is_made_of() -> None:
    x, every = RNG.normal(size=(ELEMENTS, 1, HARMONICS.n_coefficients)), np.arange(ELEMENTS)[:, None]
    found = departures(ElementGroup(Saturating(), CubicParameters(SIZES), every), x, W, HARMONICS, N_TIME)
    defined = by_definition(Saturating(), CubicParameters(SIZES))(x[:, 0], W)
    assert np.abs(found.force[:, 0] - defined).max() < 1e-13
    sliders = IwanParameters(SIZES, 0.5 * GAPS, 0 * GAPS)
    once, twice = (
        departures(ElementGroup(law, sliders, every), 1e-4 * x, W, HARMONICS, N_TIME)
        for law in (IwanMicroslip(), Doubled())
    )
    assert np.abs(twice.force - 2 * once.force).max() < 1e-12 * np.abs(once.force).max()
