"""A curve is complete where the laws of its elements have settled in the cycles that they march through."""

from dataclasses import dataclass
from typing import Any, ClassVar, NamedTuple

import jax
import jax.numpy as jnp
import numpy as np
import pytest

from updamp.hbm.contact.friction import last_cycle
from updamp.hbm.contact.jenkins import Jenkins, JenkinsParameters
from updamp.hbm.continuation.curve import CurveRequest, whole_curve
from updamp.hbm.continuation.response_curve import ResponseCurve
from updamp.hbm.harmonics import Harmonics
from updamp.hbm.problem.elements import ElementGroup
from updamp.hbm.problem.linear_model import from_matrices
from updamp.hbm.problem.system import Excitation, NonlinearSystem


class BoucWenParameters(NamedTuple):
    k: Any
    b: Any


@dataclass(frozen=True)
class BoucWen:
    """z' = u' - b (|u'| z + u' |z|), of force k z, by Euler's method: what it remembers fades in many periods."""

    cycles: int = 2
    parameters: ClassVar[type] = BoucWenParameters
    directions: ClassVar[int] = 1
    rate_dependent: ClassVar[bool] = False

    def force(self, u: jax.Array, _v: jax.Array, p: BoucWenParameters) -> jax.Array:
        steps = u - jnp.roll(u, 1, axis=0)

        def step(z: jax.Array, du: jax.Array) -> tuple[jax.Array, jax.Array]:
            z = z + du - p.b * (jnp.abs(du) * z + du * jnp.abs(z))
            return z, p.k * z

        return last_cycle(step, jnp.zeros(1), steps, self.cycles)

    def reference_stiffness(self, p: BoucWenParameters) -> jax.Array:
        return p.k[None]


def curve_of(group: ElementGroup, force: float) -> ResponseCurve:
    free = from_matrices([[1.0]], [[1.0]], [[1e4]], [[1.0]], {"q": np.array([1.0])})
    system = NonlinearSystem(free, (group,), Harmonics((1, 3, 5)), time_samples=128)
    return whole_curve(system, CurveRequest("m", Excitation(free.row("q"), force), (13.0, 22.0), points=("q",)))


def test_a_slider_that_has_not_settled_makes_no_complete_curve() -> None:
    """Its first period begins where no later one does: the peak was 12 % too high."""
    parameters, rows = JenkinsParameters(np.array([4e3]), np.array([2.0])), np.array([[0]])
    once = curve_of(ElementGroup(Jenkins(cycles=1), parameters, rows), 3.0)
    assert not once.complete
    assert "Jenkins: its force has not settled after cycles = 1" in once.stopped
    assert "such as 2" in once.stopped
    twice = curve_of(ElementGroup(Jenkins(), parameters, rows), 3.0)
    assert twice.complete
    assert once.peak("q")[1] > 1.05 * twice.peak("q")[1]


@pytest.mark.parametrize(("cycles", "complete"), [(2, False), (30, True)])
def test_an_own_law_whose_memory_fades_slowly(cycles: int, complete: bool) -> None:
    parameters = BoucWenParameters(np.array([4e3]), np.array([300.0]))
    curve = curve_of(ElementGroup(BoucWen(cycles), parameters, np.array([[0]])), 0.3)
    assert curve.complete == complete
    assert ("its force has not settled after cycles = 2" in curve.stopped) == (not complete)
