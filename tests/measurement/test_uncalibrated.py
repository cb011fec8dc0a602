"""Tests of which amplitudes alone are known, in volts, with a force that was not recorded."""

from pathlib import Path

import numpy as np
import pytest

from updamp.comparison.fit.observations import plan_of
from updamp.measurement.load import load_measurement
from updamp.measurement.measurement import MeasurementError

ROOT = Path(__file__).parents[2]
DATA = ROOT.parent / "shared" / "data" / "beams"
TEXT = """
title = "gauge"
rig = "beam"
damper_load = "0 N"
excitation = "beam.gauge.x"
repeatability = 0.03

[channels.shaker]
quantity = "force"
recorded = false
uncalibrated = true
point = "beam.gauge"
direction = "x"
unit = "A"

[channels.gauge]
quantity = "displacement"
phase = "none"
uncalibrated = true
point = "beam.gauge"
direction = "x"
unit = "V"

[run_defaults]
mode = "first"
file = "sweep.csv"
reader = "csv_columns"
options = { frequency = "f" }
held = "force"
level = "1.5 A"

[[runs]]
name = "up"
sweep = "up"

[[runs]]
name = "down"
sweep = "down"
"""
FREQUENCY = (40.0, 41.0, 42.0, 41.5, 40.5)


def written(folder: Path, old: str = "", new: str = "", frequencies: tuple[float, ...] = FREQUENCY) -> Path:
    assert old in TEXT
    rows = [f"{f},{2e-5 * np.nan_to_num(f, nan=39.0)}" for f in frequencies]
    (folder / "sweep.csv").write_text("\n".join(["f,gauge", *rows]))
    path = folder / "measurement.toml"
    path.write_text(TEXT.replace(old, new) if old else TEXT)
    return path


def test_amplitudes_are_taken_as_they_stand(tmp_path: Path) -> None:
    measurement = load_measurement(written(tmp_path), ["beam.gauge.x"], rig="beam")
    up, down = measurement.runs
    assert measurement.units == ("V", "A")
    np.testing.assert_array_equal(up.force, 1.5)
    np.testing.assert_allclose(np.abs(up.amplitude("gauge")), 2e-5 * up.frequency, rtol=1e-12)
    # one series, up and back: the turning point belongs to the way up
    np.testing.assert_array_equal(up.frequency, FREQUENCY[:3])
    np.testing.assert_array_equal(down.frequency, FREQUENCY[3:])
    assert (up.upwards, down.upwards) == (True, False)
    said = " ".join(measurement.assumptions)
    assert "1 V stands for 1 m" in said
    assert "the force was not recorded" in said


@pytest.mark.parametrize("sign", [1, -1])
def test_a_turning_point_recorded_twice_belongs_to_both_ways(tmp_path: Path, sign: int) -> None:
    series = tuple(45 + sign * (f - 45) for f in (40.0, 41.0, 42.0, 42.0, 41.0, 40.0))
    runs = load_measurement(written(tmp_path, frequencies=series)).runs
    first, second = runs if sign > 0 else runs[::-1]
    np.testing.assert_array_equal(first.frequency, series[:3])
    np.testing.assert_array_equal(second.frequency, series[3:])
    assert first.upwards == (sign > 0)


def test_a_frequency_that_is_none_does_not_part_the_series(tmp_path: Path) -> None:
    runs = TEXT[TEXT.index('[[runs]]\nname = "down"') :]
    with pytest.raises(MeasurementError, match="frequency = nan Hz at place 1"):
        load_measurement(written(tmp_path, runs, "", (np.nan, 40.0, 41.0, 42.0)))


def test_phases_count_for_nothing(tmp_path: Path) -> None:
    plan = plan_of(load_measurement(written(tmp_path)))
    assert not plan.has_phases
    for run in plan.observations:
        assert np.isinf(run.noise[:, 2]).all()
        assert np.isfinite(run.noise[:, :2]).all()
    assert plan.conditions[0].level_name == "1.5 A"


@pytest.mark.parametrize(
    ("old", "new", "said"),
    [
        ('level = "1.5 A"', 'level = "1.5 N"', r'level = "1\.5 N": the channel is uncalibrated.*"1\.5 A"'),
        ('held = "force"\nlevel = "1.5 A"', 'held = "nothing"', r"held: the force was not recorded"),
        ('phase = "none"', "recorded = false", r"recorded = false: holds for the force alone"),
        ('phase = "none"\nuncalibrated = true', "", r"needs a unit of the kind m"),
        ('sweep = "down"', "", r"has sweeps up and down"),
    ],
)
def test_what_cannot_be_is_said(tmp_path: Path, old: str, new: str, said: str) -> None:
    with pytest.raises(MeasurementError, match=said):
        load_measurement(written(tmp_path, old, new))


@pytest.mark.skipif(not DATA.is_dir(), reason=f"{DATA} is missing: measured data are kept beside the checkout")
def test_the_beams_are_read_as_their_readme_has_them() -> None:
    clamped, magnets = (
        load_measurement(ROOT / "rigs" / f"beam_{name}_measurement.toml", ["beam.gauge.x"], rig=f"beam_{name}")
        for name in ("clamped", "magnets")
    )
    for measurement, frequencies in ((clamped, [45.96, 45.74, 45.56]), (magnets, [38.4, 39.15, 40.8, 42.3])):
        runs = [run for run in measurement.runs if run.upwards]
        peaks = [run.frequency[np.argmax(np.abs(run.amplitude("gauge")))] for run in runs]
        np.testing.assert_allclose(peaks, frequencies, atol=0.005)
    assert [len(run) for run in magnets.runs] == [81, 79, 81, 79, 106, 100, 121, 119]


@pytest.mark.parametrize(
    ("stated", "unit", "stays"),
    [
        ("V", "V", True),
        ("V", "mV", False),
        ("V", "EU", True),
        ("V", "", True),
        ("EU", "mV", True),
        ("% FS(", "V", True),
    ],
)
def test_a_row_of_units_has_another_multiple(tmp_path: Path, stated: str, unit: str, stays: bool) -> None:
    """Results are told in the unit stated, so the file's must be that one."""
    path = written(tmp_path, 'unit = "V"', f'unit = "{stated}"')
    data = tmp_path / "sweep.csv"
    data.write_text(data.read_text().replace("f,gauge\n", f"f,gauge\nHz,{unit}\n"))
    if stays:
        assert len(load_measurement(path).runs) == 2
        return
    with pytest.raises(MeasurementError, match=r'channel \'gauge\': the file says mV, measurement\.toml unit = "V"'):
        load_measurement(path)


def test_frequencies_are_known_as_well_as_is_stated(tmp_path):
    stated = load_measurement(written(tmp_path, "repeatability = 0.03", "repeatability = 0.03\nfrequency_error = 4e-4"))
    assert (plan_of(stated).observations[0].noise[:, 0] == 4e-4).all()
    assert (plan_of(load_measurement(written(tmp_path))).observations[0].noise[:, 0] == 2e-6).all()


def test_a_force_that_is_the_level_needs_no_sort_of_amplitude(tmp_path: Path) -> None:
    plain = load_measurement(written(tmp_path)).runs[0]
    rms = load_measurement(written(tmp_path, 'phase = "none"', 'phase = "none"\namplitude = "rms"')).runs[0]
    np.testing.assert_array_equal(rms.force, plain.force)
    np.testing.assert_allclose(rms.amplitude("gauge"), np.sqrt(2) * plain.amplitude("gauge"), rtol=1e-12)
