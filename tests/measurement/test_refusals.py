"""What cannot be used ends in an error that names the file, the value and the remedy."""

from collections.abc import Callable
from dataclasses import replace
from pathlib import Path

import h5py
import numpy as np
import pytest
import scipy.io
from support.measured_oscillator import FREQUENCY, TOML, recorded

from updamp.measurement.load import load_measurement
from updamp.measurement.measurement import MeasurementError
from updamp.measurement.readers.hdf5 import write_hdf5
from updamp.measurement.readers.long_csv import write_long_csv
from updamp.measurement.readers.uff import write_uff58
from updamp.measurement.recorded import RecordedSweep
from updamp.measurement.sweep_checks import check_frequencies
from updamp.parallel.whole_file import MARK

POINTS = ["mass.drive.x", "mass.tip.x"]
LEVEL = 'level = "17 N"'


def refused(folder: Path, toml: str = TOML, sweep: RecordedSweep | None = None, name: str = "data.csv") -> str:
    if not (folder / name).exists():
        write_long_csv(folder / name, [sweep or recorded()])
    path = folder / "measurement.toml"
    path.write_text(toml.replace("data.csv", name))
    with pytest.raises(MeasurementError) as error:
        load_measurement(path, POINTS, rig="oscillator")
    return str(error.value)


@pytest.mark.parametrize(
    ("old", "new", "words"),
    [
        ('unit = "mm/s"', 'unit = "mm"', ['channels.laser.unit = "mm"', "velocity", '"mm/s"']),
        ('unit = "mm/s"', 'unit = ""', ['channels.laser.unit = ""', "state its unit", '"mm/s"']),
        ('unit = "mm/s"\n', "", ["channels.laser.unit: missing", "mm/s"]),
        ('unit = "mm/s"', 'unit = "furlong/s/s"', ["channels.laser.unit", "wrong dimension"]),
        ('unit = "mm/s"', 'unit = "dB"', ['channels.laser.unit = "dB"', "logarithmic", "10^(dB/20)", '"mm/s"']),
        ('unit = "mm/s"', 'unit = "dB"\nuncalibrated = true', ['channels.laser.unit = "dB"', "10^(dB/20)"]),
        ('"17 N"', '"2 dB"', ['level = "2 dB"', "logarithmic"]),
        ('"g_0"', '"g"', ['unit = "g"', 'write "g_0"', "gram"]),
        ('unit = "N"\n', "", ["channels.force.unit: missing", 'such as unit = "N"']),
        ('"g_0"', '"G"', ['unit = "G"', 'write "g_0"', "gauss"]),
        ('"g_0"', '"m/s^2/N"', ["of the kind m/s^2", 'such as "m/s^2", and per_force = true']),
        ('"g_0"', '"gn"', ['unit = "gn"', 'write "g_0"']),
        ('file = "data.csv"', 'file = "/dev/null"', ["/dev/null: is a device or pipe, no file"]),
        ('"17 N"', '"17"', ['level = "17"', "state its unit"]),
        ('"960 N"', '"960 mm"', ["damper_load", "960 mm", "wrong dimension"]),
        ('point = "mass.tip"', 'point = "mass.tpi"', ["channels.laser.point", "mass.tpi.x", "did you mean mass.tip.x"]),
        ('direction = "-x"', 'direction = "-z"', ["channels.laser.point", "mass.tip.z", "no such point", "mass.tip.x"]),
        ('excitation = "mass.drive.x"', 'excitation = "mass.tip.x"', ["channels.force.point", "make them one"]),
        ('quantity = "velocity"', 'quantity = "speed"', ["channels.laser.quantity", "speed", "velocity"]),
        ('quantity = "force"', 'quantity = "displacement"\nnoise = "1 N"', ["channels.force.unit", "displacement"]),
        ('amplitude = "rms"\n', "", ["channels.laser.amplitude: missing", "mixed conventions"]),
        ('amplitude = "rms"', 'amplitude = "effective"', ["channels.laser.amplitude", "effective", "rms"]),
        ('"rms"', '"rms"\nnoise = "1 um/s"', ["channels.accelerometer.noise: missing", "mixed conventions"]),
        ('rig = "oscillator"', 'rig = "another"', ["another", "oscillator"]),
        ('mode = "B"', 'mode = "B"\nzzz = 3', ["runs[0].zzz = 3", "unknown key", "allowed are name, mode, file"]),
        ('mode = "B"', 'mode = "B"\nrepaet = 3', ["runs[0].repaet", "did you mean repeat"]),
        ('mode = "B"\n', "", ["runs[0].mode: missing"]),
        ('held = "force"', 'held = "voltage"', ["runs[0].held", "voltage", '"response" or "nothing"']),
        ('held = "force"', 'held = "response"', ["runs[0].held_channel"]),
        (LEVEL, f'{LEVEL}\nchannels = ["lasr"]', ["runs[0].channels", "lasr", "did you mean laser"]),
        (LEVEL, f"{LEVEL}\noptions = {{ gain = 2 }}", ["runs[0].options.gain", "unknown key"]),
        (LEVEL, f'{LEVEL}\nreader = "longcsv"', ["longcsv", "did you mean long_csv"]),
        (LEVEL, f"{LEVEL}\nrepeat = 4", ["data.csv", "repeat 4", "it has repeat 1"]),
        (LEVEL, f'{LEVEL}\nrun = "B 71 N"', ["data.csv", "no run 'B 71 N'", "did you mean B 17 N"]),
        ('"17 N"', '"12.02 N"', ["level = 12.02 N", "RMS for peak"]),
        ('direction = "x"\nunit = "g_0"', 'direction = "-x"\nunit = "g_0"', ["feed the shaker", "direction"]),
        ("+iwt", "-iwt", ["feed the shaker", "exp(+iwt)"]),
        ('"g_0"', '"g_0"\nphase_of = "displacement"', ["feed the shaker", "phase_of"]),
        ('sweep = "up"', 'sweep = "down"', ["data.csv", "no sweep down", "repeat 1 up"]),
        ("[channels.laser]", '[channels.laser]\nlabel = "vibrometer"', ["data.csv", "vibrometer", "there are laser"]),
        ('file = "data.csv"', 'file = "dta.csv"', ["dta.csv", "no such file", "did you mean data.csv"]),
        ('file = "data.csv"', 'file = "."', ["is a folder"]),
            ("[channels.force]", "[channels.force", ["measurement.toml", "not valid TOML"]),
    ],
)  # fmt: skip
def test_statements(tmp_path: Path, old: str, new: str, words: list[str]) -> None:
    assert old in TOML
    message = refused(tmp_path, TOML.replace(old, new, 1))
    for word in words:
        assert word in message, message


def with_value(channel: str, place: tuple[int, int | slice], value: complex) -> RecordedSweep:
    sweep = recorded()
    amplitude = sweep.channels[channel].amplitude.copy()
    amplitude[place] = value
    return replace(sweep, channels={**sweep.channels, channel: replace(sweep.channels[channel], amplitude=amplitude)})


@pytest.mark.parametrize(
    ("sweep", "words"),
    [
        (with_value("laser", (1, 7), complex(np.nan, 0)), ["laser", "1 of 82", f"{FREQUENCY[7]:g} Hz", "harmonic 3"]),
        (with_value("accelerometer", (0, 3), complex(0, np.inf)), ["accelerometer", "no finite number", "take these"]),
        (with_value("force", (0, 5), 0j), ["force = 0", "1 of 41", f"{FREQUENCY[5]:g} Hz"]),
        (with_value("laser", (0, 5), 0j), ["'laser': response = 0", "1 of 41", f"{FREQUENCY[5]:g} Hz", "take these"]),
        (with_value("laser", (0, slice(None)), 0j), ["'laser': response = 0", "41 of 41", "leave the channel out"]),
        (replace(recorded(), frequency=np.where(FREQUENCY > 430, FREQUENCY, np.nan)), ["frequency = nan"]),
        (replace(recorded(), frequency=np.round(FREQUENCY)), ["frequency = 428 Hz", "places 1 and 2", "average"]),
        (replace(recorded(), frequency=np.roll(FREQUENCY, 9)), ["turn round at 432", "place 9", "split"]),
        (replace(recorded(), frequency=-FREQUENCY), ["frequency = -428", "mend"]),
    ],
)
def test_values(tmp_path: Path, sweep: RecordedSweep, words: list[str]) -> None:
    message = refused(tmp_path, sweep=sweep)
    for word in ("data.csv", "B 17 N", *words):
        assert word in message, message


def test_force_is_missing(tmp_path: Path) -> None:
    sweep = recorded()
    channels = {name: channel for name, channel in sweep.channels.items() if name != "force"}
    message = refused(tmp_path, sweep=replace(sweep, channels=channels))
    assert "the force, channel 'force'" in message
    assert "not in the file" in message


@pytest.mark.parametrize("ending", [".csv", ".h5", ".mat", ".uff"])
def test_amplitudes_alone_are_not_taken_for_a_phase_of_zero(tmp_path: Path, ending: str) -> None:
    toml = f'{TOML.replace("data.csv", f"data{ending}")}repeat = 1\nchannels = ["laser"]\n'
    sweep = recorded()
    laser = sweep.channels["laser"]
    laser = replace(laser, amplitude=np.abs(laser.amplitude[:1]) + 0j, harmonics=(1,))
    channels = {"force": sweep.channels["force"], "laser": laser}
    write = {".csv": write_long_csv, ".h5": write_hdf5, ".mat": write_mat, ".uff": write_uff58}[ending]
    write(tmp_path / f"data{ending}", [replace(sweep, channels=channels)])
    message = refused(tmp_path, toml, name=f"data{ending}")
    assert "channel 'laser': its 41 values are all real" in message
    assert 'phase = "none"' in message
    path = tmp_path / "measurement.toml"
    path.write_text(toml.replace("[channels.laser]", '[channels.laser]\nphase = "none"'))
    assert load_measurement(path).runs[0].without_phase == ("laser",)


@pytest.mark.parametrize("key", ["phase", "imaginary"])
@pytest.mark.parametrize("label", ["lasr", "laser 1"])
def test_a_phase_of_what_is_no_channel(tmp_path: Path, key: str, label: str) -> None:
    (tmp_path / "data.csv").write_text("frequency_Hz,force,laser,angle\n430,17,1,-90\n")
    options = f'{key} = {{ "{label}" = "angle" }}, phase_unit = "deg"'
    message = refused(tmp_path, f'{TOML}reader = "csv_columns"\noptions = {{ {options} }}\n')
    for word in ("data.csv", f'options.{key}: "{label}"', "did you mean laser?"):
        assert word in message, message


@pytest.mark.parametrize("ending", [".csv", ".uff"])
def test_no_label_is_in_the_file(tmp_path: Path, ending: str) -> None:
    (write_long_csv if ending == ".csv" else write_uff58)(tmp_path / f"data{ending}", [recorded()])
    toml = TOML
    for name in ("force", "laser", "accelerometer"):
        toml = toml.replace(f"[channels.{name}]", f'[channels.{name}]\nlabel = "sensor {name[0]}"')
    message = refused(tmp_path, toml, name=f"data{ending}")
    for word in ("channel 'laser'", 'label = "sensor l"', "not in the file", "there are force, laser, accelerometer"):
        assert word in message, message


def test_a_file_that_contradicts_the_statement(tmp_path: Path) -> None:
    sweep = recorded()
    for key, value, words in (("unit", "m/s", "says m/s"), ("quantity", "acceleration", "says acceleration")):
        changed = replace(sweep.channels["laser"], **{key: value})
        write_uff58(tmp_path / "data.uff", [replace(sweep, channels={**sweep.channels, "laser": changed})])
        message = refused(tmp_path, name="data.uff")
        assert "channel 'laser'" in message
        assert words in message


def test_repeats_without_numbers(tmp_path: Path) -> None:
    write_long_csv(tmp_path / "data.csv", [recorded(None)])
    write_long_csv(tmp_path / "second.csv", [recorded(None)])
    run = TOML[TOML.index("[[runs]]") :]
    assert "number their assemblies" in refused(tmp_path, TOML + run.replace("data.csv", "second.csv"))
    assert "listed twice" in refused(tmp_path, TOML + run)
    other = run.replace("data.csv", "second.csv").replace('mode = "B"', 'mode = "A"')
    assert "runs of one name are repeats" in refused(tmp_path, TOML + other)


def test_one_repeat_is_listed_twice(tmp_path: Path) -> None:
    again = TOML[TOML.index("[[runs]]") :] + "repeat = 1\n"  # the number that the file states
    message = refused(tmp_path, TOML + again)
    for word in ("measurement.toml", "run 'B 17 N' has repeat = 1 more than once", "listed twice"):
        assert word in message, message


def test_values_that_are_copied_are_asked_about(tmp_path: Path) -> None:
    """As another repeat, and as another run."""
    write_hdf5(tmp_path / "data.h5", [recorded(1), replace(recorded(1), repeat=2), recorded(3)])
    toml = TOML.replace("data.csv", "data.h5")
    again = toml[toml.index("[[runs]]") :].replace('name = "B 17 N"', 'name = "C"\nrun = "B 17 N"\nrepeat = 3')
    path = tmp_path / "measurement.toml"
    path.write_text(toml + again)
    asked = [a for a in load_measurement(path).assumptions if "is it a copy?" in a]
    assert ["run 'B 17 N' repeat 2 has the very values of run 'B 17 N' repeat 1" in a for a in asked] == [True, False]
    assert "run 'C' repeat 3 has the very values of run 'B 17 N' repeat 3" in asked[1]


def test_one_repeat_number_for_two_sweeps(tmp_path: Path) -> None:
    write_hdf5(tmp_path / "data.h5", [recorded(1), recorded(1)])
    assert "more than one sweep of the same repeat" in refused(tmp_path, name="data.h5")
    write_long_csv(tmp_path / "data.csv", [recorded(1), recorded(1)])
    message = refused(tmp_path)
    for word in ("turn round at 432", "place 41", "column of runs", 'options = { run = "its column" }'):
        assert word in message, message


@pytest.mark.parametrize(
    ("group", "key"),
    [("sweeps/00000", "run"), ("sweeps/00000/channels/0001", "unit"), ("sweeps/00000/channels/0001", "name")],
)
def test_an_hdf5_file_lacks_an_attribute(tmp_path: Path, group: str, key: str) -> None:
    write_hdf5(tmp_path / "whole.h5", [recorded()])
    content = (tmp_path / "whole.h5").read_bytes()
    (tmp_path / "data.h5").write_bytes(content[: content.index(MARK)])  # another program writes no checksum
    with h5py.File(tmp_path / "data.h5", "r+") as file:
        del file[group].attrs[key]
    message = refused(tmp_path, name="data.h5")
    assert f"/{group} has no attribute '{key}'" in message
    assert "damaged" not in message


GARBAGE = np.random.default_rng(1).bytes(20_000)
ENDINGS = [".csv", ".uff", ".mat", ".h5"]


@pytest.mark.parametrize("ending", ENDINGS)
@pytest.mark.parametrize(
    "content", [GARBAGE, b"", b"\x00" * 50_000, b"hello, world\n" * 1000, "Köln\n".encode("latin-1")]
)
def test_garbage(tmp_path: Path, ending: str, content: bytes) -> None:
    (tmp_path / f"data{ending}").write_bytes(content)
    message = refused(tmp_path, name=f"data{ending}")
    assert f"data{ending}" in message
    if not content:
        assert "empty" in message


def write_mat(path: Path, sweeps: list[RecordedSweep]) -> None:
    scipy.io.savemat(path, {"frequency": FREQUENCY, **{n: c.amplitude[:1] for n, c in sweeps[0].channels.items()}})


@pytest.mark.parametrize("share", [0.02, 0.3, 0.6, 0.95, 0.99])
@pytest.mark.parametrize(
    ("name", "write"), [("d.uff", write_uff58), ("d.h5", write_hdf5), ("d.mat", write_mat), ("d.csv", write_long_csv)]
)
def test_cut_off(tmp_path: Path, name: str, write: Callable[[Path, list[RecordedSweep]], None], share: float) -> None:
    write(tmp_path / name, [recorded()])
    content = (tmp_path / name).read_bytes()
    (tmp_path / name).write_bytes(content[: int(share * len(content))])
    assert name in refused(tmp_path, name=name)


def test_records_shorter_than_their_header_says(tmp_path: Path) -> None:
    path = tmp_path / "data.uff"
    write_uff58(path, [recorded()], binary=False)
    lines = path.read_text().splitlines(keepends=True)
    path.write_text("".join(lines[:20] + lines[24:]))
    assert "values where its header says 41" in refused(tmp_path, name="data.uff")


@pytest.mark.parametrize("ending", ENDINGS)
def test_huge_files_are_refused_before_they_are_read(tmp_path: Path, ending: str) -> None:
    path = tmp_path / f"data{ending}"
    with path.open("wb") as file:
        file.truncate(3_000_000_000)  # sparse: no byte of it is on the disk
    assert path.name in refused(tmp_path, name=path.name)


def test_no_measurement_toml(tmp_path: Path) -> None:
    with pytest.raises(MeasurementError, match=r"no such file; give a measurement\.toml"):
        load_measurement(tmp_path / "measurement.toml")
    with pytest.raises(MeasurementError, match="cannot be read"):
        load_measurement(tmp_path)


def test_every_problem_of_a_file_is_named_at_once(tmp_path: Path) -> None:
    message = refused(
        tmp_path, TOML.replace('"mm/s"', '"mm"').replace('"960 N"', '"960"').replace('"force"\nlevel', '"f"\nlevel')
    )
    assert len(message.splitlines()) == 4


@pytest.mark.parametrize(
    ("first", "second", "words"),
    [
        ("taken = 1", "", "runs[1].taken: missing, and others have it"),
        ("taken = 2", "taken = 2", "runs[1].taken = 2: so has runs[0] of the same assembly"),
        ("taken = 0", "taken = 1", "runs[0].taken = 0"),
    ],
)
def test_the_order_of_runs_is_that_of_all(tmp_path: Path, first: str, second: str, words: str) -> None:
    run = TOML[TOML.index("[[runs]]") :]
    again = run.replace('name = "B 17 N"', 'name = "again"\nrun = "B 17 N"')
    message = refused(tmp_path, f"{TOML.rstrip()}\n{first}\n\n{again.rstrip()}\n{second}\n")
    assert words in message, message


def test_no_run_is_listed(tmp_path: Path) -> None:
    toml = "runs = []\n" + TOML[: TOML.index("[[runs]]")]
    assert "runs = []: state at least one run" in refused(tmp_path, toml)


def test_what_is_wrong_in_a_table_is_named(tmp_path: Path) -> None:
    write_long_csv(tmp_path / "data.csv", [recorded()])
    good = (tmp_path / "data.csv").read_text()
    (tmp_path / "data.csv").write_text(good.replace("frequency_Hz", "Frequency_Hz"))
    message = refused(tmp_path)
    assert "there is no 'frequency_Hz', 'Frequency_Hz' is none of these" in message
    lines = good.splitlines()
    (tmp_path / "data.csv").write_text("\n".join([*lines[:3], "-,-,-,Hz,-,-,N,N", *lines[3:], ""]))
    message = refused(tmp_path)
    assert 'line 4: frequency_Hz = "Hz": not a number; take its line out' in message


def test_one_frequency_is_no_sweep() -> None:
    """A comparison of it had ended in a division by zero."""
    with pytest.raises(MeasurementError, match=r"run 'a': 432 Hz alone is no sweep, .* two frequencies"):
        check_frequencies("run 'a'", np.array([432.0]))
