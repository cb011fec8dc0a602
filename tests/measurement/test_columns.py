"""Amplitudes, phases and imaginary parts in columns of their own that cannot be meant as they are stated."""

from pathlib import Path

import numpy as np
import pytest
from support.measured_oscillator import FREQUENCY, TOML, recorded

from updamp.measurement.load import load_measurement
from updamp.measurement.measurement import Measurement, MeasurementError

FORCE, LASER = (recorded().channels[name].amplitude[0] for name in ("force", "laser"))
PHASES = 'phase = { laser = "angle" }, phase_unit = "deg"'


def load(folder: Path, options: str, toml: str = TOML, **columns: np.ndarray) -> Measurement:
    names, rows = ",".join(("frequency_Hz", *columns)), np.column_stack((FREQUENCY, *columns.values()))
    (folder / "data.csv").write_text("\n".join([names, *(",".join(map(repr, row)) for row in rows.tolist()), ""]))
    path = folder / "measurement.toml"
    tail = f'repeat = 1\nreader = "csv_columns"\nchannels = ["laser"]\noptions = {{ {options} }}\n'
    path.write_text(toml + tail)
    return load_measurement(path)


def refused(folder: Path, options: str, toml: str = TOML, **columns: np.ndarray) -> str:
    with pytest.raises(MeasurementError) as error:
        load(folder, options, toml, **columns)
    return str(error.value)


def test_an_imaginary_part_of_the_force_that_is_not_named_is_asked_about(tmp_path: Path) -> None:
    parts = {"force": FORCE.real, "fi": FORCE.imag, "laser": LASER.real, "li": LASER.imag}
    toml = TOML.replace('held = "force"\nlevel = "17 N"', 'held = "nothing"')
    said = load(tmp_path, 'imaginary = { laser = "li" }', toml, **parts).assumptions
    assert any("columns not used, fi, its imaginary part?" in a and '{ "force" = "fi" }' in a for a in said)
    said = load(tmp_path, 'imaginary = { laser = "li", force = "fi" }', toml, **parts).assumptions
    assert not any("imaginary part?" in a for a in said)


def test_negative_amplitudes_are_refused(tmp_path: Path) -> None:
    size, angle, force = np.abs(LASER), np.degrees(np.angle(LASER / FORCE)), np.abs(FORCE)
    load(tmp_path, PHASES, force=force, laser=size, angle=angle)
    spoilt = np.where(np.arange(41) == 6, -size, size)
    message = refused(tmp_path, PHASES, force=force, laser=spoilt, angle=angle)
    for word in ("data.csv: line 8", f"laser = {-size[6]:g}", "not negative", "1 of 41", "dB"):
        assert word in message, message
    assert "line 2: force = -" in refused(tmp_path, PHASES, force=-force, laser=size, angle=angle)
    toml = TOML.replace("[channels.laser]", '[channels.laser]\nphase = "none"')
    message = refused(tmp_path, "", toml, force=force, laser=spoilt)
    for word in ("data.csv", "'B 17 N'", "'laser'", "1 of 41 are negative", f"{FREQUENCY[6]:g} Hz"):
        assert word in message, message


def test_degrees_that_are_called_radians(tmp_path: Path) -> None:
    """Wrapped or not; unwrapped radians over many turns are such."""
    size, angle, force = np.abs(LASER), np.angle(LASER / FORCE), np.abs(FORCE)
    radians = PHASES.replace("deg", "rad")
    for phase in (np.degrees(angle), np.degrees(np.unwrap(angle))):
        message = refused(tmp_path, radians, force=force, laser=size, angle=phase)
        for word in ("data.csv: angle goes from", "steps of up to", 'phase_unit = "deg"'):
            assert word in message, message
    delayed = np.unwrap(angle) - 2 * np.pi * FREQUENCY * 1.5
    for phase in (angle, delayed - delayed[0], np.angle(np.exp(1j * delayed)) - np.angle(np.exp(2j * delayed))):
        load(tmp_path, radians, force=force, laser=size, angle=phase)


def test_a_phase_that_is_the_amplitude_itself(tmp_path: Path) -> None:
    message = refused(tmp_path, PHASES.replace("angle", "laser"), force=np.abs(FORCE), laser=np.abs(LASER))
    assert 'options.phase: "laser" = "laser" is the column of the amplitude itself' in message


def test_a_phase_beside_the_statement_that_there_is_none(tmp_path: Path) -> None:
    toml = TOML.replace("[channels.laser]", '[channels.laser]\nphase = "none"')
    columns = {"force": np.abs(FORCE), "laser": np.abs(LASER), "angle": np.degrees(np.angle(LASER / FORCE))}
    said = load(tmp_path, PHASES, toml, **columns).assumptions
    assert any('options.phase is not used for channels of phase = "none"' in a for a in said)
