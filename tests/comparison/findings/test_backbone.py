"""Tops read off points: of an oscillator however they lie about it, of a sweep that jumps not across the jump."""

import numpy as np
import pytest
from support.jumping_beam import Joint, Mode, swept

from updamp.comparison.findings.backbone import read_resonance, summit, summit_deviation

BEAM = Mode(50.0, 0.01, 1.0)
HALF_WIDTH = 0.25  # [Hz]


def recorded(receptance: np.ndarray, phase: bool) -> np.ndarray:
    return receptance if phase else np.abs(receptance) + 0j


@pytest.mark.parametrize("phase", [True, False], ids=["phase", "amplitude alone"])
@pytest.mark.parametrize("points", [0.5, 1, 3, 10], ids="{:g} in a half-width".format)
def test_no_oscillators_points_are_taken_for_a_jump(points: float, phase: bool) -> None:
    """The place that a parabola gives is between the points, wherever the top lies among them."""
    step = HALF_WIDTH / points
    for offset in np.linspace(-0.49, 0.49, 11) * step:
        f = 50.0 + offset + step * np.arange(-8, 9)
        found = read_resonance(f, recorded(BEAM.receptance(2 * np.pi * f), phase), np.ones(17))
        assert found.frequency == pytest.approx(50.0, abs=0.2 * step)
        height = abs(BEAM.receptance(2 * np.pi * np.array([50.0]))[0])
        assert found.receptance == pytest.approx(height, rel=1e-2), "however far apart the points are"
        assert np.abs(f - found.frequency).min() > 0 or abs(offset) < 1e-12


@pytest.mark.parametrize("apart", [0.3, 1.0, 2.0], ids="{:g} half-widths".format)
def test_a_top_is_known_as_well_as_is_said(apart: float) -> None:
    rng, noise, read, said = np.random.default_rng(5), 0.01, [], []
    for _ in range(1500):
        f = apart * (np.arange(-2, 3) - rng.uniform(-0.5, 0.5))
        size = -np.log1p(f**2) / 2 + noise * rng.standard_normal(5)
        if size.argmax() == 2:
            read.append(summit(f, size - 1j * np.arctan(f), 2))
            said.append(summit_deviation(f, size, 2))
    of_reading, of_saying = np.std(read, axis=0), noise * np.sqrt(np.mean(np.square(said), axis=0))
    assert of_reading == pytest.approx(of_saying, rel=0.06)


def test_a_top_between_points_beyond_its_half_power_points_is_told_no_higher_than_they_can_tell() -> None:
    f = 50.0 + 8 * HALF_WIDTH * (np.arange(-8, 9) + 0.5)
    receptance = BEAM.receptance(2 * np.pi * f) * np.where(np.arange(17) % 2, 1.01, 0.99)
    found = read_resonance(f, receptance, np.ones(17))
    assert found.frequency == pytest.approx(50.0, abs=HALF_WIDTH)
    assert found.receptance == pytest.approx(np.sqrt(2) * np.abs(receptance).max(), rel=1e-9)


@pytest.mark.parametrize("phase", [True, False], ids=["phase", "amplitude alone"])
@pytest.mark.parametrize("upwards", [True, False])
def test_a_resonance_beside_a_jump_is_the_highest_point(upwards: bool, phase: bool) -> None:
    """A parabola across the jump lay two steps and more beside it."""
    joint = Joint(cubic=1e10 if upwards else -1e10)
    f = np.linspace(48.0, 52.0, 81)[:: 1 if upwards else -1]
    receptance = swept((BEAM,), joint, f, 0.5) / 0.5
    top = int(np.abs(receptance).argmax())
    jump = int(np.abs(np.diff(np.log(receptance))).argmax())
    assert 0 <= jump - top <= 1  # right after the highest point, or the next
    found = read_resonance(f, recorded(receptance, phase), np.full(81, 0.5))
    assert found.frequency == pytest.approx(f[top], abs=1e-12)
    assert found.receptance == pytest.approx(abs(receptance[top]))
