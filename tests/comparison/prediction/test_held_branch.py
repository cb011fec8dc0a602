"""Where the branch of a held response turns back in frequency."""

from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest

from updamp.comparison.prediction.held_branch import trace_held
from updamp.hbm.contact.springs import CubicParameters, CubicSpring
from updamp.hbm.harmonics import Harmonics
from updamp.hbm.problem.elements import ElementGroup
from updamp.hbm.problem.linear_model import from_matrices
from updamp.hbm.problem.system import NonlinearSystem

MASS, SPRING, DASHPOT, CUBIC, LEVEL = 0.05, 500.0, 0.6, 5e8, 1e-4


def folds() -> tuple[float, float]:
    """[Hz] between which a hardening absorber on a mass whose motion is held has three motions: by one harmonic
    ((k + 3/4 c X^2 - m w^2)^2 + (d w)^2) X^2 = (m w^2 LEVEL)^2."""
    frequency, three = np.arange(15.0, 28.0, 0.002), []
    for w in 2 * np.pi * frequency:
        k, b = SPRING - MASS * w**2, 0.75 * CUBIC
        roots = np.roots([b**2, 2 * b * k, k**2 + (DASHPOT * w) ** 2, -((MASS * w**2 * LEVEL) ** 2)])
        three.append(np.count_nonzero(np.abs(roots.imag) < 1e-9 * np.abs(roots)) == 3)
    return float(frequency[three].min()), float(frequency[three].max())


@pytest.mark.parametrize("upwards", [True, False])
def test_an_absorber_on_the_held_mass_folds_over_and_it_is_said_where(upwards: bool) -> None:
    K = [[1e4 + SPRING, -SPRING], [-SPRING, SPRING]]
    C = [[2 + DASHPOT, -DASHPOT], [-DASHPOT, DASHPOT]]
    free = from_matrices(np.diag([1.0, MASS]), C, K, [[-1.0, 1.0]], {"a": np.array([1.0, 0.0])})
    absorber = ElementGroup(CubicSpring(), CubicParameters(np.array([CUBIC])), np.array([[0]]))
    system = NonlinearSystem(free, (absorber,), Harmonics((1,)), time_samples=128)
    there: Any = SimpleNamespace(system=system, model=SimpleNamespace(excitation="a"))
    control = SimpleNamespace(point="a", amplitude=lambda _: LEVEL)
    condition: Any = SimpleNamespace(wider=(10.0, 30.0), upwards=upwards, control=control)
    points, why = trace_held(there, condition)
    assert points[-1].frequency == pytest.approx(folds()[upwards], abs=0.01)
    assert f"is followed to {points[-1].frequency:.3f}"[:-2] in why
    assert "turns back in frequency there, where a controlled sweep jumps" in why
