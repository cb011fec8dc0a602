"""A second peak that the model has not is told as that, and chance makes none."""

from dataclasses import replace

import numpy as np
import pytest
from support.held_beam import held_beam, of_beam

from updamp.comparison.findings.several_peaks import _peaks
from updamp.measurement.measurement import MeasuredRun, Measurement

RESONANCE, LOSS = 80.40, 0.003
SOUND = held_beam((RESONANCE,) * 3, (LOSS,) * 3)


def with_absorber(measurement: Measurement, mass: float) -> Measurement:
    """mass: of a resonator tuned to the mode, of the same loss, over the modal mass. The response without it is that of
    one mode, so that what the absorber takes follows from it: no code of updamp."""

    def changed(run: MeasuredRun) -> MeasuredRun:
        r2 = (run.frequency / RESONANCE) ** 2
        own = 1 + 1j * LOSS
        dynamic = own - r2  # of the mode, over its stiffness
        held = mass * r2 * own / (own - r2)  # what the absorber's foot takes, likewise
        return replace(run, response=run.response * dynamic / (dynamic - held))

    return replace(measurement, runs=tuple(changed(run) for run in measurement.runs))


def test_two_peaks_where_the_model_has_one_are_told_with_their_frequencies() -> None:
    first, *others = of_beam(with_absorber(SOUND, 4e-5)).findings
    apart = RESONANCE * np.sqrt(4e-5) / 2
    lower, upper = (float(word) for word in first.text.split(" at ")[1].split(" Hz")[0].split(" and "))
    assert lower == pytest.approx(RESONANCE - apart, abs=0.05)
    assert upper == pytest.approx(RESONANCE + apart, abs=0.05)
    assert "two peaks were measured" in first.text
    assert "the model has one, at " in first.text
    assert not [f for f in others if f.quantity in ("frequency", "damping")], "nothing is read off either of them"


@pytest.mark.parametrize("noise", [0.003, 0.03, 0.2])
def test_chance_makes_none(noise: float) -> None:
    """One resonance in 25 and 60 points, whose flanks are flat over the noise or not."""
    rng = np.random.default_rng(5)
    for n, width in ((25, 4.0), (60, 20.0)):
        f = np.linspace(-1, 1, n)
        size = -0.5 * np.log1p((width * f) ** 2)
        found = [len(_peaks(f, size + noise * rng.standard_normal(n), np.full(n, noise))[0]) for _ in range(2000)]
        assert np.mean(np.array(found) > 1) < 0.01


def test_a_second_one_is_seen_where_the_dip_stands_out_of_the_noise() -> None:
    f = np.linspace(-1, 1, 41)
    size = np.log(1 / (1 + (10 * (f - 0.4)) ** 2) + 1 / (1 + (10 * (f + 0.4)) ** 2))
    peaks, prominence = _peaks(f, size, np.full(41, 0.05))
    assert peaks == pytest.approx([-0.4, 0.4], abs=0.03)
    top, dip = np.median(size[26:31]), np.median(size[18:23])  # about 0.4 and 0
    assert prominence == pytest.approx(float(top - dip), rel=1e-9)
    assert len(_peaks(f, size, np.full(41, 0.5))[0]) < 2


def test_two_readings_of_one_height_are_no_two_peaks() -> None:
    """A top in rounded numbers: 99, 100, 99, 100, 99."""
    size = np.log([50.0, 80, 99, 100, 99, 100, 99, 80, 50])
    assert len(_peaks(np.arange(9.0), size, np.full(9, 0.005))[0]) == 1


@pytest.mark.parametrize(("places", "factor"), [([20, 21], 0.4), ([12, 13], 3.0), ([21], 0.3), ([30, 31], 1.6)])
def test_one_or_two_bad_points_are_no_peak(places: list[int], factor: float) -> None:
    """They were "two peaks were measured, at 98.1 and 100 Hz, where the model has one"."""
    f = np.linspace(-1, 1, 41)
    size = -0.5 * np.log1p((6 * f) ** 2)
    size[places] += np.log(factor)
    assert len(_peaks(f, size, np.full(41, 0.005))[0]) == 1
