"""A sweep without stops as time signals."""

from pathlib import Path

import numpy as np
import pytest
from numpy.typing import NDArray
from scipy.integrate import cumulative_simpson
from scipy.signal import lsim
from support.measured_oscillator import TOML

from updamp.measurement.load import load_measurement
from updamp.measurement.measurement import MeasurementError
from updamp.measurement.swept_fit import fit_swept, phase_of_sweep

Floats = NDArray[np.float64]
RATE, RESONANCE, LOSS = 4000.0, 100.0, 0.02  # 1/s, Hz; half-power bandwidth 2 Hz
OPTIONS = 'repeat = 1\nreader = "time_csv"\nchannels = ["laser"]\noptions = {{ {} }}\n'


def receptance(frequency: Floats) -> NDArray[np.complex128]:
    w, w0 = 2 * np.pi * frequency, 2 * np.pi * RESONANCE
    return np.asarray(1e3 / (w0**2 + 1j * LOSS * w0 * w - w**2))


def chirp(start: float, rate: float, seconds: float) -> tuple[Floats, Floats, Floats]:
    """(n,) time [s], frequency [Hz], phase [rad]"""
    time = np.arange(0, seconds, 1 / RATE)
    return time, start + rate * time, 2 * np.pi * (start * time + rate * time**2 / 2)


def test_the_phase_is_the_integral_of_the_frequency() -> None:
    time = np.linspace(0.0, 3.0, 400)
    frequency = 50 + 20 * np.sin(time)
    expected = 2 * np.pi * cumulative_simpson(frequency, x=time, initial=0)
    np.testing.assert_allclose(phase_of_sweep(time, frequency), expected, atol=2 * np.pi * 1e-3)


@pytest.mark.parametrize("clock", [0.0, 2e-4])
def test_amplitudes_that_change_linearly_are_exact(clock: float) -> None:
    """With harmonics, offset and drift, and a generator whose clock is off."""
    time, frequency, _ = chirp(99.0, 0.5, 0.2)
    middle = time - time.mean()
    phase = phase_of_sweep(time, frequency) + 2 * np.pi * clock * 99.0 * middle
    amplitude = np.array([[1.0 + 0.2j, 0.1j], [2.0 - 1j, 0.3]])
    change = np.array([[0.3j, 0.0], [0.5, 1.0]])
    signals = 0.7 + 3 * time + 0.0 * amplitude.real[:, :1]
    phase -= np.interp(time.mean(), time, phase)
    for i, k in enumerate((1, 2)):
        factor = amplitude[:, i, None] + change[:, i, None] * middle
        signals = signals + np.real(factor * np.exp(1j * k * phase))
    found = fit_swept(time, signals, frequency, (1, 2))
    tolerance = 1e-9 if clock == 0 else 1e-3
    np.testing.assert_allclose(found.amplitude, amplitude, atol=tolerance)
    apparent = np.imag(change[0, 0] / amplitude[0, 0]) / (2 * np.pi)  # the force's own phase turns too
    assert found.frequency == pytest.approx(frequency.mean() + apparent + clock * 99.0, abs=1e-3)


def test_the_stated_deviation_is_the_true_one() -> None:
    rng, off = np.random.default_rng(7), []
    time, frequency, phase = chirp(99.0, 0.5, 0.2)
    phase = phase - np.interp(time.mean(), time, phase)
    for _ in range(200):
        signal = np.real((1 + 2j) * np.exp(1j * phase)) + 0.1 * rng.standard_normal(len(time))
        found = fit_swept(time, np.array([np.cos(phase), signal]), frequency, (1,))
        off.append((found.amplitude[1, 0] - (1 + 2j)) / found.deviation[1, 0])
    assert 0.7 < np.sqrt(np.mean(np.abs(off) ** 2) / 2) < 1.1


def loaded(folder: Path, rate: float, seconds: float, options: str = ""):
    time, frequency, phase = chirp(RESONANCE - rate * seconds / 2, rate, seconds)
    force = np.cos(phase)
    w0 = 2 * np.pi * RESONANCE
    _, velocity, _ = lsim(([1e3, 0.0], [1.0, LOSS * w0, w0**2]), force, time)
    rows = [
        f"{t:.9g},{f:.9g},{a:.9g},{-1e3 * v:.9g}" for t, f, a, v in zip(time, frequency, force, velocity, strict=True)
    ]
    (folder / "data.csv").write_text("\n".join(["time_s,frequency_Hz,force,laser", *rows, ""]), encoding="utf-8")
    toml = TOML.replace('amplitude = "rms"', 'amplitude = "peak"').replace('level = "17 N"', 'level = "1 N"')
    toml = toml.replace('sweep = "up"', f'sweep = "{"up" if rate > 0 else "down"}"')
    path = folder / "measurement.toml"
    path.write_text(toml + OPTIONS.format(options), encoding="utf-8")
    return load_measurement(path)


@pytest.mark.parametrize(("rate", "most"), [(0.05, 0.01), (-0.05, 0.01), (2.0, 0.4)])
def test_a_resonance_that_was_swept_through(tmp_path: Path, rate: float, most: float) -> None:
    """By the equation of motion: slow, the steady response; fast, not, and the bandwidth that is needed is told."""
    found = loaded(tmp_path, rate, 12.0 / rate if rate > 1 else 60.0)
    (run,) = found.runs
    assert np.all(np.sign(np.diff(run.frequency)) == np.sign(rate))
    expected = receptance(run.frequency)
    seen = slice(5, -5)  # it begins from rest
    off = np.abs(run.response[0, 0] / run.force - expected)[seen].max() / np.abs(expected).max()
    assert off < most
    assert off > (0.05 if rate > 1 else 0.0)
    (note,) = (text for text in found.assumptions if "swept without stops" in text)
    assert f"bandwidth below {np.sqrt(abs(rate) / 0.9):.2g} Hz" in note


def test_windows_are_as_long_as_stated(tmp_path: Path) -> None:
    runs = [loaded(tmp_path, 0.1, 8.0, options).runs[0] for options in ("", "periods = 40")]
    assert len(runs[0].frequency) == pytest.approx(8 * RESONANCE / 20, abs=2)
    assert len(runs[1].frequency) == pytest.approx(8 * RESONANCE / 40, abs=2)


def test_steps_of_a_measured_frequency_are_no_sweep(tmp_path: Path) -> None:
    time = np.arange(0, 4.0, 1 / RATE)
    measured = 99.0 + np.floor(time) + 1e-3 * np.random.default_rng(1).standard_normal(len(time))
    rows = [f"{t:.9g},{f:.9g},{np.cos(2 * np.pi * f * t):.6g},0.1" for t, f in zip(time, measured, strict=True)]
    (tmp_path / "data.csv").write_text("\n".join(["time_s,frequency_Hz,force,laser", *rows, ""]), encoding="utf-8")
    path = tmp_path / "measurement.toml"
    path.write_text(TOML.replace('amplitude = "rms"', 'amplitude = "peak"') + OPTIONS.format(""), encoding="utf-8")
    with pytest.raises(MeasurementError, match="as commanded, not as measured"):
        load_measurement(path)


@pytest.mark.parametrize(
    ("options", "words"),
    [('settle = "0.1 s"', "nothing settles"), ("periods = 9000", "less than one window"), ("periods = 5", "periods")],
)
def test_what_cannot_be_cut_into_windows(tmp_path: Path, options: str, words: str) -> None:
    with pytest.raises(MeasurementError, match=words):
        loaded(tmp_path, 0.1, 4.0, options)
