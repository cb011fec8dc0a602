"""What grows by more than a tenth of the angular frequency is found, beside contacts with memory too."""

from dataclasses import dataclass
from typing import Any, ClassVar, NamedTuple

import jax.numpy as jnp
import numpy as np
import pytest

from updamp.hbm.contact.jenkins import Jenkins, JenkinsParameters
from updamp.hbm.continuation.curve import CurveRequest, whole_curve
from updamp.hbm.continuation.response_curve import ResponseCurve
from updamp.hbm.harmonics import Harmonics
from updamp.hbm.problem.elements import ElementGroup
from updamp.hbm.problem.linear_model import from_matrices
from updamp.hbm.problem.system import Excitation, NonlinearSystem
from updamp.hbm.stability.stability import stability

COUPLING, STIFFNESS, DAMPING = 3e5, (2 * np.pi * np.array([10.0, 20.2])) ** 2, np.array([0.4, 0.6])


class Coupling(NamedTuple):
    g: Any


@dataclass(frozen=True)
class ProductLaw:
    """Of the potential g a^2 b: b, driven at twice the frequency of a, makes a grow (Mathieu)."""

    parameters: ClassVar[type] = Coupling
    directions: ClassVar[int] = 2
    rate_dependent: ClassVar[bool] = False

    def force(self, u: Any, _v: Any, p: Coupling) -> Any:
        return jnp.stack([2 * p.g * u[:, 0] * u[:, 1], p.g * u[:, 0] ** 2], axis=1)

    def reference_stiffness(self, _p: Coupling) -> Any:
        return jnp.zeros(2)


@pytest.fixture(scope="module")
def pumped() -> tuple[NonlinearSystem, ResponseCurve]:
    """With a slider that hardly does anything, but has a memory."""
    relative = [[1.0, 0.0], [0.0, 1.0], [0.0, 1.0]]
    free = from_matrices(np.eye(2), np.diag(DAMPING), np.diag(STIFFNESS), relative, {"b": np.array([0.0, 1.0])})
    slider = JenkinsParameters(np.array([20.0]), np.array([2e-4]))
    groups = (
        ElementGroup(ProductLaw(), Coupling(np.array([COUPLING])), np.array([[0, 1]])),
        ElementGroup(Jenkins(), slider, np.array([[2]])),
    )
    system = NonlinearSystem(free, groups, Harmonics((0, 1, 2, 3, 4, 5)), time_samples=128)
    driven = Excitation(free.row("b"), 3.0)
    return system, whole_curve(system, CurveRequest("b", driven, (18.0, 23.0), points=("b",)))


def growth_of_a(curve: ResponseCurve, point: int) -> float:
    """[1/s] of a'' + c a' + (k + 2 g b(t)) a = 0 over a period, by Runge and Kutta of the fourth order"""
    w, n = 2 * np.pi * curve.frequency[point], 400
    b, step = curve.response[point, 0] @ curve.harmonics.synthesis(2 * n).T, 2 * np.pi / w / n
    at = [np.array([[0, 1], [-(STIFFNESS[0] + 2 * COUPLING * one), -DAMPING[0]]]) for one in [*b, b[0]]]
    turned = np.eye(2)
    for i in range(0, 2 * n, 2):
        k1 = at[i] @ turned
        k2 = at[i + 1] @ (turned + step / 2 * k1)
        k3 = at[i + 1] @ (turned + step / 2 * k2)
        k4 = at[i + 2] @ (turned + step * k3)
        turned = turned + step / 6 * (k1 + 2 * k2 + 2 * k3 + k4)
    return float(np.log(np.abs(np.linalg.eigvals(turned)).max()) * w / (2 * np.pi))


def test_a_mode_that_another_one_pumps(pumped: tuple[NonlinearSystem, ResponseCurve]) -> None:
    """At a rate of 0.3 w in the middle of the tongue, where only its rim was told unstable."""
    system, curve = pumped
    assert curve.complete
    places = np.unique(
        np.append(np.linspace(0, len(curve) - 1, 9).astype(int), np.argmax(np.abs(curve.receptance("b"))))
    )
    rates = []
    for i in places:
        w, true = 2 * np.pi * curve.frequency[i], growth_of_a(curve, i)
        found = stability(system, curve.displacement[i], w)
        assert found.stable is bool(true < 0)
        if true > 0:
            assert found.decisive.real == pytest.approx(true, rel=1e-3)
        rates.append(true / w)
    assert max(rates) > 0.25
    assert min(rates) < 0


@pytest.mark.parametrize("damping", [-5.0, -30.0, -100.0])
def test_a_damper_that_drives(damping: float) -> None:
    """By half of its rate over mass in any motion, be it 0.5 of the angular frequency."""
    with pytest.warns(UserWarning, match="negative damping"):
        free = from_matrices([[1.0]], [[damping]], [[1e4]], [[1.0]], {"q": np.array([1.0])})
    slider = ElementGroup(Jenkins(), JenkinsParameters(np.array([400.0]), np.array([0.05])), np.array([[0]]))
    system = NonlinearSystem(free, (slider,), Harmonics((1, 3, 5)), time_samples=128)
    curve = whole_curve(system, CurveRequest("m", Excitation(free.row("q"), 20.0), (12.0, 20.0), points=("q",)))
    for i in range(0, len(curve), 8):
        found = stability(system, curve.displacement[i], 2 * np.pi * curve.frequency[i])
        assert found.stable is False
        assert found.decisive.real == pytest.approx(-damping / 2, rel=0.05)  # the slider takes a little
