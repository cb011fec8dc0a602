"""A top that was cut off at one value is found and left out, and none that is merely flat."""

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from support.measured_oscillator import FREQUENCY, TOML, recorded

from updamp.measurement.load import load_measurement
from updamp.measurement.overload import overloaded
from updamp.measurement.readers.long_csv import write_long_csv
from updamp.measurement.recorded import RecordedChannel


def oscillator(points: int, width: float = 20.0) -> np.ndarray:
    """Within so many half-widths of its resonance, of height 1."""
    return 1 / (1 + 1j * np.linspace(-width / 2, width / 2, points))


def cut_at(share: float, response: np.ndarray) -> np.ndarray:
    size = np.abs(response)
    return response / size * np.minimum(size, share)


def rounded(response: np.ndarray, digits: int) -> np.ndarray:
    def of(part: np.ndarray) -> np.ndarray:
        return np.array([float(f"{value:.{digits - 1}e}") for value in part])

    return of(response.real) + 1j * of(response.imag)


@pytest.mark.parametrize("points", [81, 400])
@pytest.mark.parametrize("share", [0.5, 0.9])
@pytest.mark.parametrize("digits", [4, 6, 17])
def test_a_top_that_is_cut_off_is_found_whole(points: int, share: float, digits: int) -> None:
    whole = oscillator(points)
    cut = np.abs(whole) > share
    for response in (rounded(cut_at(share, whole), digits), rounded(np.abs(cut_at(share, whole)) + 0j, digits)):
        found = overloaded(RecordedChannel(response[None]))
        assert found[cut].all()
        assert np.abs(whole)[found].min() > share - 10.0 ** (2 - digits)


@pytest.mark.parametrize("points", [21, 41, 401, 4001, 40001])
@pytest.mark.parametrize("digits", [2, 3, 4, 6, 17])
@pytest.mark.parametrize("height", [1.0, 0.99, 1.01, 0.3])
def test_a_flat_top_is_none(points: int, digits: int, height: float) -> None:
    """As few digits make it, or points next to each other."""
    response = height * oscillator(points) * np.exp(0.3j)
    for one in (rounded(response, digits), rounded(np.abs(response) + 0j, digits)):
        assert not overloaded(RecordedChannel(one[None])).any()
    amplitudes = rounded(np.abs(response) + 0j, digits).real * np.exp(1j * np.angle(response))
    assert not overloaded(RecordedChannel(amplitudes[None])).any()


def test_a_jump_beside_a_flat_top_is_none() -> None:
    response = rounded(np.abs(oscillator(401)) + 0j, 3)
    response[206:] *= 0.4
    assert not overloaded(RecordedChannel(response[None])).any()


@pytest.mark.parametrize("values", [[0.0] * 5, [1.0] * 5, [np.nan, 1.0, 1.0, 1.0, 0.5], [1.0, 1.0, 0.5]])
def test_what_is_none_or_no_curve(values: list[float]) -> None:
    assert not overloaded(RecordedChannel(np.array([values], dtype=complex))).any()


def test_the_points_are_left_out_of_all_channels_and_it_is_asked_about(tmp_path: Path) -> None:
    sweep = recorded()
    label = next(label for label, channel in sweep.channels.items() if len(channel.harmonics) > 1)
    channel = sweep.channels[label]
    top = float(np.abs(channel.amplitude[0]).max())
    amplitude = channel.amplitude.copy()
    amplitude[0] = cut_at(0.7 * top, channel.amplitude[0])
    changed = replace(sweep, channels={**sweep.channels, label: replace(channel, amplitude=amplitude)})
    write_long_csv(tmp_path / "data.csv", [changed])
    (tmp_path / "measurement.toml").write_text(TOML)
    measurement = load_measurement(tmp_path / "measurement.toml")
    (run,) = measurement.runs
    left_out = FREQUENCY[np.abs(channel.amplitude[0]) > 0.7 * top]
    assert len(left_out) > 2
    assert sorted({*FREQUENCY} - {*run.frequency}) == pytest.approx(left_out)
    assert run.response.shape[-1] == len(run.force) == len(FREQUENCY) - len(left_out)
    (question,) = measurement.questions
    assert (
        f"its {len(left_out)} highest values, {left_out[0]:g} to {left_out[-1]:g} Hz, are one and the same" in question
    )
    assert question in measurement.stated
