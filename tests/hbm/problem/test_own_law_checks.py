"""What a user's own law may get wrong, told when its elements are made."""

from dataclasses import dataclass
from typing import Any, NamedTuple

import jax
import jax.numpy as jnp
import numpy as np
import pytest

from updamp.hbm.contact.memoryless import Sampled
from updamp.hbm.problem.elements import ElementGroup
from updamp.hbm.problem.own_law_checks import OwnLawError


class Coefficient(NamedTuple):
    c: Any


def no_stiffness(_):
    return jnp.zeros(1)


@dataclass(frozen=True)
class Own:
    """what, stiffness: functions of displacement, velocity and c, and of c"""

    what: Any
    rate_dependent: bool = False
    stiffness: Any = no_stiffness
    parameters = Coefficient
    directions = 1

    def force(self, displacement, velocity, parameters):
        return self.what(displacement, velocity, parameters.c)

    def reference_stiffness(self, parameters):
        return self.stiffness(parameters.c)


@dataclass(frozen=True)
class WrittenOut(Own):
    """written: `Sampled` of displacement, velocity and c"""

    written: Any = None

    def sampled(self, displacement, velocity, parameters):
        return self.written(displacement, velocity, parameters.c)


def made(law) -> ElementGroup:
    return ElementGroup(law, Coefficient(np.array([2.0, 3.0])), np.array([[0], [1]]))


def cube(u, _, c):
    return c * u**3


RIGHT = [
    Own(cube),
    Own(lambda u, v, c: c * u**2 * v, rate_dependent=True),
    Own(lambda u, _, c: c * u / jnp.sqrt(0.09 - u**2)),  # no number beyond 0.3 m
    Own(lambda u, _, c: c * jnp.maximum(u - 5e-6, 0.0)),
    WrittenOut(cube, written=lambda u, _, c: Sampled(c * u**3, 3 * c * u**2)),
    WrittenOut(
        lambda u, v, c: c * u**2 * v, True, written=lambda u, v, c: Sampled(c * u**2 * v, 2 * c * u * v, c * u**2)
    ),
]
WRONG = [
    (Own(lambda u, v, c: c * u**2 * v), "rate_dependent is False, and force changes with the velocity"),
    (Own(lambda u, _, c: c * u[:, 0]), r"returns shape \(16,\) for a displacement of shape \(16, 1\)"),
    (Own(lambda *_: 1.0), r"returns shape \(\)"),
    (Own(lambda u, _, c: (c * u).astype(jnp.float32)), "returns float32; real numbers in double precision"),
    (Own(lambda u, _, c: 1j * c * u), "returns complex128; real numbers"),
    (Own(cube, stiffness=lambda c: c), "reference_stiffness returns 2.0; 1 finite numbers"),
    (Own(cube, stiffness=lambda c: jnp.full(1, jnp.nan) * c), r"reference_stiffness returns \[nan\]"),
    (WrittenOut(cube, written=lambda u, _, c: Sampled(2 * c * u**3, 6 * c * u**2)), "sampled has another force"),
    (WrittenOut(cube, written=lambda u, _, c: Sampled(c * u**3, 0 * u)), "the slopes by displacement"),
    (
        WrittenOut(lambda u, v, c: c * u**2 * v, True, written=lambda u, v, c: Sampled(c * u**2 * v, 2 * c * u * v)),
        "the slopes by velocity",
    ),
]


@pytest.mark.parametrize("law", RIGHT)
def test_a_law_that_does_what_it_says_is_taken(law):
    assert len(made(law).reference_stiffness()) == 2


@pytest.mark.parametrize(("law", "said"), WRONG, ids=[said for _, said in WRONG])
def test_what_contradicts_itself_is_refused(law, said):
    with pytest.raises(OwnLawError, match=said):
        made(law)


def test_a_law_without_a_hash_is_refused():
    class Changeable(Own):
        __hash__ = None

    with pytest.raises(TypeError, match="Changeable has no hash"):
        made(Changeable(cube))


def test_a_law_is_asked_once_whatever_its_parameters():
    asked = []

    def force(u, _, c):
        asked.append(float(c) if not isinstance(c, jax.core.Tracer) else None)
        return c * u

    law = Own(force)
    for _ in range(3):
        made(law)
    assert len(asked) == 15  # five sizes, with two velocities each, and for a memory


def slider(u, _, c):
    """Of a spring c with the limit 1, marched through two periods"""

    def step(at, there):
        force = jnp.clip(c * (there - at), -1.0, 1.0)
        return there - force / c, force

    at, _ = jax.lax.scan(step, 0.0 * u[0, 0], u[:, 0])
    return jax.lax.scan(step, at, u[:, 0])[1][:, None]


@dataclass(frozen=True)
class Marched(Own):
    cycles: int = 2


def test_a_law_with_a_memory_says_that_it_has_one():
    """Told without, every point of its curve had the stability of a law without memory: unstable."""
    with pytest.raises(OwnLawError, match=r"Own: force at one time depends on the motion at others.* cycles: int = 2"):
        made(Own(slider))
    made(Marched(slider))


def maxwell(u, v, c):
    """A spring c in series with a dashpot, of which the motion is told by the velocities too."""

    def step(at, both):
        there, rate = both
        at = (at + (there + rate / len(u)) / 2) / 1.5
        return at, c * (there - at)

    motion = u[:, 0], v[:, 0]
    at, _ = jax.lax.scan(step, 0.0 * u[0, 0], motion)
    return jax.lax.scan(step, at, motion)[1][:, None]


@pytest.mark.parametrize("what", [maxwell, lambda u, v, c: maxwell(0 * u, v, c) + c * u], ids=["both", "velocities"])
def test_a_law_that_depends_on_the_velocity_says_so_too(what):
    """It passed for one that may remember, and was looked at as one that does not: growth of the wrong sign."""
    with pytest.raises(OwnLawError, match=r"Own: force at one time depends on the motion at others"):
        made(Own(what, rate_dependent=True))
    made(Marched(what, rate_dependent=True))
    made(Own(lambda u, v, c: c * u + v**3, rate_dependent=True))
    made(Own(lambda u, v, c: c * jnp.abs(u - jnp.mean(u, axis=0)) * v, rate_dependent=True))  # counted from the mean
