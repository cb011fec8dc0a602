"""Resonances read off curves are those of the oscillator that made them."""

import numpy as np
import pytest

from updamp.diagnosis.backbone import resonance


@pytest.mark.parametrize("sign", [1, -1])
@pytest.mark.parametrize(("loss_factor", "points"), [(0.003, 41), (0.003, 201), (0.014, 21), (0.014, 201)])
def test_of_a_linear_oscillator(loss_factor: float, sign: int, points: int) -> None:
    """At the driving point or opposite to it, swept either way; at least five points in the width of the resonance."""
    f = np.linspace(79.07, 81.0, points)[::sign]
    receptance = sign * 0.5 / ((2 * np.pi * 80) ** 2 * (1 + 1j * loss_factor) - (2 * np.pi * f) ** 2)
    found = resonance(f, receptance, np.full(points, 3.0))
    assert found.loss_factor == pytest.approx(loss_factor, rel=0.02)
    assert found.frequency == pytest.approx(80, abs=0.03)
    assert found.receptance == pytest.approx(0.5 / ((2 * np.pi * 80) ** 2 * loss_factor), rel=0.03)
    assert found.amplitude == pytest.approx(3 * found.receptance)


def test_no_damping_is_told_where_the_phase_does_not_turn_as_an_oscillator_does() -> None:
    """Height flattened at the top, phase as it was: the width tells another damping than the phase."""
    f = np.linspace(79.0, 81.0, 201)
    receptance = 0.5 / ((2 * np.pi * 80) ** 2 * (1 + 0.003j) - (2 * np.pi * f) ** 2)
    size = np.abs(receptance)
    flat = receptance / np.sqrt(1 + (size / (0.5 * size.max())) ** 2)
    assert np.isnan(resonance(f, flat, np.ones(201)).loss_factor)
    assert resonance(f, flat, np.ones(201)).frequency == pytest.approx(80, abs=0.02)
