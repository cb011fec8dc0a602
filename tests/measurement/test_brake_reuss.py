"""The Brake-Reuss beam's published runs, with their trap: an acceleration's amplitude, a displacement's phase."""

from pathlib import Path

import numpy as np
import pytest

from updamp.comparison.fit.observations import plan_of
from updamp.measurement.load import load_measurement
from updamp.measurement.measurement import MeasurementError

BEAM = Path(__file__).parents[2] / "rigs" / "brake_reuss_measurement.toml"
DATA = Path(__file__).parents[3] / "shared" / "data" / "brb" / "response_controlled.csv"
needs_data = pytest.mark.skipif(
    not DATA.is_file(), reason=f"{DATA} is missing: the beam's data are under GPL-3.0 and are kept beside the checkout"
)


@needs_data
def test_resonance_and_damping_as_published() -> None:
    measurement = load_measurement(BEAM, ["beam.drive.x"], rig="brake_reuss")
    assert [run.level for run in measurement.runs] == [5, 20, 30, 40, 50, 60, 70, 80]
    assert all(len(run) == 41 and run.held == "response" and run.upwards for run in measurement.runs)
    frequencies, ratios = [], []
    for run in measurement.runs:
        receptance = run.receptance("accelerometer")
        phase = np.angle(receptance)
        resonance = np.interp(np.pi / 2, -phase, run.frequency)  # displacement lags by a quarter
        acceleration = np.abs(run.amplitude("accelerometer")) * (2 * np.pi * run.frequency) ** 2
        frequencies.append(resonance)
        ratios.append(np.interp(resonance, run.frequency, np.abs(run.force) / acceleration))
    np.testing.assert_allclose(frequencies, [80.37, 80.18, 80.18, 80.11, 80.25, 80.33, 80.39, 80.44], atol=0.006)
    assert ratios[0] == pytest.approx(0.0059, abs=5e-5)
    assert ratios[-1] == pytest.approx(0.0258, abs=5e-5)


@needs_data
def test_the_trap_is_noticed(tmp_path: Path) -> None:
    text = BEAM.read_text().replace("../../shared/data/brb/response_controlled.csv", str(DATA))
    path = tmp_path / "measurement.toml"
    path.write_text(text.replace('phase_of = "displacement"', ""))
    with pytest.raises(MeasurementError, match=r"feed the shaker.*phase_of"):
        load_measurement(path)


@needs_data
def test_repeatability_is_stated_where_no_repeats_are(tmp_path: Path) -> None:
    text = BEAM.read_text().replace("../../shared/data/brb/response_controlled.csv", str(DATA))
    path = tmp_path / "measurement.toml"
    path.write_text(text)
    measurement = load_measurement(path, ["beam.drive.x"], rig="brake_reuss")
    assert measurement.repeatability == 0.065
    assert {run.held_channel for run in measurement.runs} == {"accelerometer"}
    plan = plan_of(measurement)
    for condition, run in zip(plan.conditions, plan.observations, strict=True):
        assert np.all(run.noise[:, 1:] >= 0.065)
        assert condition.control is not None
        assert (condition.control.point, condition.control.derivatives) == ("beam.drive.x", 2)
        assert run.log_level is not None
        assert np.abs(run.log_level).max() < 0.1
    path.write_text(text.replace('run = "8"', 'run = "8"\nrepeat = 2'))
    with pytest.raises(MeasurementError, match=r"repeatability = 0\.065: there are 2 repeats"):
        load_measurement(path, ["beam.drive.x"], rig="brake_reuss")
    path.write_text(text.replace("repeatability = 0.065", "repeatability = 6.5"))
    with pytest.raises(MeasurementError, match=r"repeatability = 6\.5"):
        load_measurement(path, ["beam.drive.x"], rig="brake_reuss")
