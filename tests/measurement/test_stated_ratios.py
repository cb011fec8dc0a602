"""`per_force = true`: CSV, MATLAB and HDF5 files that hold responses divided by the force give what the responses give;
a file that says otherwise is refused."""

from collections.abc import Callable
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
import scipy.io
from support.measured_oscillator import FREQUENCY, TOML, displacement, force, recorded
from support.universal_file import UFF_TOML, ratios, record, spectra

from updamp.measurement.load import load_measurement
from updamp.measurement.measurement import Measurement, MeasurementError
from updamp.measurement.readers.hdf5 import write_hdf5
from updamp.measurement.readers.long_csv import write_long_csv
from updamp.measurement.recorded import RecordedChannel, RecordedSweep

RATIO = TOML.replace("[channels.laser]", "[channels.laser]\nper_force = true").replace(
    "[channels.accelerometer]", "[channels.accelerometer]\nper_force = true"
)
NO_FORCE = ('unit = "N"', 'unit = "N"\nrecorded = false')
COLUMNS = 'reader = "csv_columns"\noptions = { imaginary = { force = "fi", laser = "li", accelerometer = "ai" } }\n'
Change = tuple[str, str]


def divided(with_force: bool = True, **fields: object) -> RecordedSweep:
    """In the units and signs of TOML over N: peak by peak, whatever TOML says of amplitudes."""
    sweep = recorded()
    sorts = {"laser": np.sqrt(2), "accelerometer": 1.0}
    channels = {
        name: RecordedChannel(sweep.channels[name].amplitude[:1] * sort / force(), **fields)
        for name, sort in sorts.items()
    }
    return replace(sweep, channels={**({"force": sweep.channels["force"]} if with_force else {}), **channels})


def write_columns(path: Path, sweep: RecordedSweep, units: str = "") -> None:
    names = {"force": "force,fi", "laser": "laser,li", "accelerometer": "accelerometer,ai"}
    parts = [part for c in sweep.channels.values() for part in (c.amplitude[0].real, c.amplitude[0].imag)]
    rows = [",".join(map(repr, row)) for row in np.column_stack((FREQUENCY, *parts)).tolist()]
    header = ",".join(["frequency_Hz", *(names[name] for name in sweep.channels)])
    path.write_text("\n".join([header, *([units] if units else []), *rows, ""]))


def write_mat(path: Path, sweep: RecordedSweep) -> None:
    scipy.io.savemat(path, {"frequency": FREQUENCY, **{n: c.amplitude for n, c in sweep.channels.items()}})


def write_h5(path: Path, sweep: RecordedSweep) -> None:
    write_hdf5(path, [sweep])


def write_csv(path: Path, sweep: RecordedSweep) -> None:
    write_long_csv(path, [sweep])


def load(folder: Path, name: str, *changes: Change, toml: str = RATIO, tail: str = "") -> Measurement:
    toml = toml.replace("data.csv", name)
    for old, new in changes:
        assert old in toml
        toml = toml.replace(old, new, 1)
    path = folder / "measurement.toml"
    path.write_text(toml + tail)
    return load_measurement(path)


def refused(folder: Path, name: str, *changes: Change, toml: str = RATIO, tail: str = "") -> str:
    with pytest.raises(MeasurementError) as error:
        load(folder, name, *changes, toml=toml, tail=tail)
    return str(error.value)


def assert_receptance(measurement: Measurement) -> None:
    (run,) = measurement.runs
    for channel in ("laser", "accelerometer"):
        np.testing.assert_allclose(run.receptance(channel), displacement()[0] / force(), rtol=1e-11)


FILES: list[tuple[str, Callable[[Path, RecordedSweep], None], str]] = [
    ("data.csv", write_csv, ""),
    ("data.csv", write_columns, f"repeat = 1\n{COLUMNS}"),
    ("data.mat", write_mat, 'repeat = 1\noptions = { frequency_unit = "Hz" }\n'),
    ("data.h5", write_h5, ""),
]


@pytest.mark.parametrize(("name", "write", "tail"), FILES)
def test_a_response_function_is_multiplied_by_the_force_recorded(
    tmp_path: Path, name: str, write: Callable[[Path, RecordedSweep], None], tail: str
) -> None:
    """So the very displacements come out, though the force drops at resonance; nothing is taken for granted."""
    write(tmp_path / name, divided())
    measurement = load(tmp_path, name, tail=tail)
    assert_receptance(measurement)
    (run,) = measurement.runs
    np.testing.assert_allclose(run.amplitude("laser"), displacement()[0], rtol=1e-11)
    assert not any("divided" in sentence or "unit" in sentence for sentence in measurement.assumptions)


@pytest.mark.parametrize(("name", "write", "tail"), FILES)
def test_a_response_function_alone_is_multiplied_by_the_level(
    tmp_path: Path, name: str, write: Callable[[Path, RecordedSweep], None], tail: str
) -> None:
    """Where the force was not recorded, it is the run's level at every frequency."""
    write(tmp_path / name, divided(with_force=False))
    tail = tail.replace('force = "fi", ', "")
    measurement = load(tmp_path, name, NO_FORCE, tail=tail)
    assert_receptance(measurement)
    np.testing.assert_array_equal(measurement.runs[0].force, 17.0)


def test_it_is_the_unit_of_the_force_that_divides(tmp_path: Path) -> None:
    """Over mN where the force is in mN."""
    sweep = divided()
    channels = {
        n: replace(c, amplitude=c.amplitude * (1e3 if n == "force" else 1e-3)) for n, c in sweep.channels.items()
    }
    write_csv(tmp_path / "data.csv", replace(sweep, channels=channels))
    assert_receptance(load(tmp_path, "data.csv", ('unit = "N"', 'unit = "mN"')))


def test_a_sensor_and_a_force_that_point_the_other_way(tmp_path: Path) -> None:
    sweep = divided()
    channels = {n: replace(c, amplitude=-c.amplitude) for n, c in sweep.channels.items()}
    write_csv(tmp_path / "data.csv", replace(sweep, channels=channels))
    assert_receptance(load(tmp_path, "data.csv", ('direction = "x"\nunit = "N"', 'direction = "-x"\nunit = "N"')))


def test_amplitudes_of_response_functions_alone(tmp_path: Path) -> None:
    """No phases, no force: what many analysers plot is enough."""
    sweep = divided(with_force=False)
    laser = replace(sweep.channels["laser"], amplitude=np.abs(sweep.channels["laser"].amplitude) + 0j)
    write_csv(tmp_path / "data.csv", replace(sweep, channels={"laser": laser}))
    change = ("[channels.laser]", '[channels.laser]\nphase = "none"')
    (run,) = load(tmp_path, "data.csv", NO_FORCE, change, tail='channels = ["laser"]\n').runs
    np.testing.assert_allclose(np.abs(run.receptance("laser")), np.abs(displacement()[0] / force()), rtol=1e-12)


@pytest.mark.parametrize("units", ["Hz,N,N,mm/s/N,mm/s/N,g/N,g/N", "Hz,N,N,[(mm/s)/N],[(mm/s)/N],[g/(N)],[g/(N)]"])
def test_the_row_of_units_may_say_so_too(tmp_path: Path, units: str) -> None:
    write_columns(tmp_path / "data.csv", divided(), units)
    assert_receptance(load(tmp_path, "data.csv", tail=f"repeat = 1\n{COLUMNS}"))


def test_the_row_of_units_may_have_another_force(tmp_path: Path) -> None:
    """As in a universal file: the file's own unit is that of the force it is divided by."""
    sweep = divided()
    laser, other = sweep.channels["laser"], sweep.channels["accelerometer"]
    channels = {**sweep.channels, "laser": replace(laser, amplitude=laser.amplitude * 1e3), "accelerometer": other}
    write_columns(tmp_path / "data.csv", replace(sweep, channels=channels), "Hz,N,N,mm/s/kN,mm/s/kN,g/N,g/N")
    assert_receptance(load(tmp_path, "data.csv", tail=f"repeat = 1\n{COLUMNS}"))


@pytest.mark.parametrize(
    ("units", "toml", "words"),
    [
        ("Hz,N,N,mm/s/N,mm/s/N,g/N,g/N", TOML, ["file says mm/s/N", "and per_force = true"]),
        ("Hz,N,N,mm/(s N),mm/(s N),,", TOML, ["file says mm/(s N)", "and per_force = true"]),
        ("Hz,N,N,mm/s,mm/s,g,g", RATIO, ["per_force = true, but the file says mm/s, the unit of a velocity"]),
        ("Hz,N,N,m/s/N,m/s/N,g/N,g/N", RATIO, ["the file says m/s", 'unit = "mm/s"']),
    ],
)
def test_a_row_of_units_that_contradicts(tmp_path: Path, units: str, toml: str, words: list[str]) -> None:
    write_columns(tmp_path / "data.csv", divided(), units)
    message = refused(tmp_path, "data.csv", toml=toml, tail=f"repeat = 1\n{COLUMNS}")
    for word in ("data.csv", "run 'B 17 N' channel 'laser'", *words):
        assert word in message, message


def test_a_force_is_not_divided_by_itself(tmp_path: Path) -> None:
    write_csv(tmp_path / "data.csv", divided())
    message = refused(tmp_path, "data.csv", ("[channels.force]", "[channels.force]\nper_force = true"))
    assert "channels.force.per_force = true: is for responses" in message


def test_a_unit_over_force_leads_to_the_key(tmp_path: Path) -> None:
    """Who states the unit of the ratio is told what to state."""
    message = refused(tmp_path, "data.csv", ('"mm/s"', '"mm/s/N"'))
    assert 'state the unit of the response alone, such as "mm/s", and per_force = true' in message


@pytest.mark.parametrize(
    ("content", "stated", "words"),
    [
        (spectra(), "true", "per_force = true, but the file says that it is a response itself, not divided"),
        (
            record(force()) + ratios(),
            "false",
            "per_force = false, but the file says that it is a response divided by the force",
        ),
    ],
)
def test_a_universal_file_says_itself_what_it_is(tmp_path: Path, content: str, stated: str, words: str) -> None:
    (tmp_path / "data.uff").write_text(content)
    change = ("[channels.laser]", f"[channels.laser]\nper_force = {stated}")
    message = refused(tmp_path, "data.uff", change, toml=UFF_TOML)
    for word in ("data.uff", "channel 'laser'", words, "the function type of a universal file"):
        assert word in message, message


def test_a_universal_file_and_the_key_may_agree(tmp_path: Path) -> None:
    (tmp_path / "data.uff").write_text(record(force()) + ratios())
    change = ("[channels.laser]", "[channels.laser]\nper_force = true")
    stated, plain = load(tmp_path, "data.uff", change, toml=UFF_TOML), load(tmp_path, "data.uff", toml=UFF_TOML)
    np.testing.assert_array_equal(stated.runs[0].response, plain.runs[0].response)


def test_an_hdf5_file_may_say_itself_what_it_is(tmp_path: Path) -> None:
    write_hdf5(tmp_path / "data.h5", [divided(per_force=True)])
    for toml in (TOML, RATIO):
        assert_receptance(load(tmp_path, "data.h5", toml=toml))
    sweep = divided(per_force=True)
    swapped = {**sweep.channels, "force": sweep.channels["laser"]}
    write_hdf5(tmp_path / "data.h5", [replace(sweep, channels=swapped)])
    assert "channel 'force': the file says that it is a response divided by the force" in refused(tmp_path, "data.h5")
    write_hdf5(tmp_path / "data.h5", [divided(per_force=False)])
    assert "the attribute per_force of HDF5" in refused(tmp_path, "data.h5")


def test_samples_are_not_divided_by_the_force(tmp_path: Path) -> None:
    (tmp_path / "data.csv").write_text("time_s,frequency_Hz,force,laser\n0,430,1,1\n")
    tail = 'reader = "time_csv"\nchannels = ["laser"]\n'
    message = refused(tmp_path, "data.csv", ('"rms"', '"peak"'), tail=tail)
    assert "channels.laser.per_force = true: time_csv reads time signals" in message


def test_higher_harmonics_of_a_response_function(tmp_path: Path) -> None:
    sweep = divided()
    both = {
        name: replace(c, amplitude=np.vstack([c.amplitude[:1]] * 2), harmonics=(1, 3))
        for name, c in sweep.channels.items()
    }
    write_csv(tmp_path / "data.csv", replace(sweep, channels=both))
    assert "a frequency response function has harmonic 1 only" in refused(tmp_path, "data.csv")
