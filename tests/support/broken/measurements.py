"""Broken measurements: what measurement.toml says, what the data files hold, and units that do not fit the model."""

from collections.abc import Callable, Sequence
from dataclasses import replace
from io import StringIO
from pathlib import Path

import numpy as np
import scipy.io
from rich.console import Console
from support.broken.outcome import Broken, Told, call
from support.measured_oscillator import FREQUENCY, TOML, recorded
from support.one_sweep import RESONANCE, sweep_of_beam

from updamp.measurement.load import load_measurement
from updamp.measurement.readers.hdf5 import write_hdf5
from updamp.measurement.readers.long_csv import write_long_csv
from updamp.measurement.readers.uff import write_uff58
from updamp.measurement.recorded import RecordedSweep
from updamp.workflow.comparison_inputs import CompareFiles, comparison_inputs
from updamp.workflow.progress import Display

POINTS = ["mass.drive.x", "mass.tip.x"]
RIGS = Path(__file__).parents[3] / "rigs"
Write = Callable[[Path, Sequence[RecordedSweep]], object]


def write_mat(path: Path, sweeps: Sequence[RecordedSweep]) -> None:
    scipy.io.savemat(path, {"frequency": FREQUENCY, **{n: c.amplitude[:1] for n, c in sweeps[0].channels.items()}})


WRITERS: dict[str, Write] = {".csv": write_long_csv, ".uff": write_uff58, ".mat": write_mat, ".h5": write_hdf5}


def load(folder: Path) -> Told:
    return call(lambda: load_measurement(folder / "measurement.toml", POINTS, rig="oscillator"))


def stated(old: str, new: str, *words: str, name: str = "") -> Broken:
    """One place of a sound measurement.toml changed."""
    assert old in TOML, old

    def made(folder: Path) -> Told:
        write_long_csv(folder / "data.csv", [recorded()])
        (folder / "measurement.toml").write_text(TOML.replace(old, new, 1), encoding="utf-8")
        return load(folder)

    return Broken(f"measurement: {name or new or 'without ' + old}"[:70].replace("\n", " "), words, made)


def data(name: str, ending: str, damage: Callable[[bytes], bytes], *words: str, welcome: bool = False) -> Broken:
    """The bytes of a sound data file damaged."""

    def made(folder: Path) -> Told:
        path = folder / f"data{ending}"
        WRITERS[ending](path, [recorded()])
        path.write_bytes(damage(path.read_bytes()))
        (folder / "measurement.toml").write_text(TOML.replace("data.csv", path.name), encoding="utf-8")
        return load(folder)

    return Broken(f"data{ending}: {name}", words, made, welcome)


def toml_bytes(name: str, damage: Callable[[bytes], bytes], *words: str, welcome: bool = False) -> Broken:
    def made(folder: Path) -> Told:
        write_long_csv(folder / "data.csv", [recorded()])
        (folder / "measurement.toml").write_bytes(damage(TOML.encode()))
        return load(folder)

    return Broken(f"measurement: {name}", words, made, welcome)


WHAT = "measurement.toml"
STATED = [
    toml_bytes("empty", lambda _: b"", WHAT, "empty"),
    toml_bytes("BOM", lambda b: b"\xef\xbb\xbf" + b, "Oscillator", welcome=True),
    toml_bytes("UTF-16", lambda b: b.decode().encode("utf-16"), WHAT, "UTF-16", "UTF-8"),
    toml_bytes("cut off", lambda b: b[: b.index(b'N"\namplitude')], WHAT, "line", "quote"),
    toml_bytes("a rig file", lambda _: (RIGS / "pesaresi2017.toml").read_bytes(), WHAT, "rig file"),
    stated('title = "Oscillator"', 'title = "Oscillator"\ntitle = "Again"', WHAT, "title", "twice", "line"),
    stated('unit = "mm/s"', 'unit = "mm"', "channels.laser.unit", "velocity", "mm/s"),
    stated('unit = "mm/s"', 'unit = ""', "channels.laser.unit", "state its unit"),
    stated('unit = "mm/s"\n', "", "channels.laser.unit", "missing"),
    stated('unit = "mm/s"', 'unit = "furlong/fortnight2"', "channels.laser.unit"),
    stated('"g_0"', '"g"', "unit", "g_0", "gram"),
    stated('"17 N"', '"17"', "level", "state its unit"),
    stated('"17 N"', '"17,0 N"', "level", "17,0 N", "decimal point"),
    stated('"17 N"', '"17 kN"', "level", "median", "measured"),
    stated('"17 N"', '"12.02 N"', "level", "RMS for peak"),
    stated('"960 N"', '"960 mm"', "damper_load", "wrong dimension"),
    stated('"960 N"', '"1e300 N"', "damper_load", "out of range"),
    stated('point = "mass.tip"', 'point = "mass.tpi"', "channels.laser.point", "did you mean mass.tip.x"),
    stated('direction = "-x"', 'direction = "-z"', "mass.tip.z", "no such point"),
    stated('direction = "-x"', 'direction = "up"', "channels.laser.direction", "up"),
    stated('excitation = "mass.drive.x"', 'excitation = "mass.tip.x"', "channels.force.point", "make them one"),
    stated('quantity = "velocity"', 'quantity = "speed"', "speed", "velocity"),
    stated('quantity = "force"', 'quantity = "displacement"', "channels"),
    stated(TOML[TOML.index("[channels.force]") : TOML.index("[channels.laser]")], "", "channels: none has",
           'quantity = "force"', "[channels.force]", "recorded = false", name="no force"),
    stated('amplitude = "rms"\n', "", "amplitude", "mixed conventions"),
    stated('amplitude = "rms"', 'amplitude = "effective"', "effective", "rms"),
    stated('rig = "oscillator"', 'rig = "another"', "another", "oscillator"),
    stated('mode = "B"\n', "", "runs[0].mode", "missing"),
    stated('held = "force"', 'held = "voltage"', "voltage", "response"),
    stated('held = "force"', 'held = "response"', "held_channel"),
    stated('level = "17 N"', 'level = "17 N"\nreader = "longcsv"', "did you mean long_csv"),
    stated('level = "17 N"', 'level = "17 N"\nrepeat = 4', "repeat 4", "it has repeat 1"),
    stated('level = "17 N"', 'level = "17 N"\nrun = "B 71 N"', "no run", "did you mean B 17 N"),
    stated('sweep = "up"', 'sweep = "down"', "no sweep down"),
    stated("+iwt", "-iwt", "feed the shaker", "exp(+iwt)"),
    stated('direction = "x"\nunit = "g_0"', 'direction = "-x"\nunit = "g_0"', "feed the shaker", "direction"),
    stated('file = "data.csv"', 'file = "dta.csv"', "no such file", "did you mean data.csv"),
    stated('file = "data.csv"', 'file = "."', "folder"),
    stated('file = "data.csv"', 'file = "data.xlsx"', "data.xlsx", "no such file"),
    stated("[channels.laser]", '[channels.laser]\nlabel = "vibrometer"', "vibrometer", "there are laser"),
    stated("[[runs]]", '[channels.edge]\nquantity = "displacement"\npoint = "mass.tip"\ndirection = "x"\nunit = "m"\n'
           'amplitude = "peak"\n\n[[runs]]', "channel 'edge'",
           "not in the file", "taken: force, laser, accelerometer", name="a channel that the file does not have"),
    stated(TOML[TOML.index("[[runs]]") :], "", "runs: missing", "add a table [[runs]] with name, mode", name="no runs"),
    stated('level = "17 N"', "level = 2", "runs[0].level = 2", "text in quotes", 'such as "17 N"'),
    stated('level = "17 N"', 'level = "17 N"\nchannels = []', "runs[0].channels = []", "entries wanted: at least 1",
           '["tip_right"]'),
]  # fmt: skip


def _line(n: int, new: Callable[[bytes], bytes]) -> Callable[[bytes], bytes]:
    """Damage to one line, counted from 1."""

    def damage(content: bytes) -> bytes:
        lines = content.split(b"\n")
        lines[n - 1] = new(lines[n - 1])
        return b"\n".join(lines)

    return damage


def _last(text: bytes) -> Callable[[bytes], bytes]:
    return lambda line: line[: line.rindex(b",") + 1] + text


GARBAGE = np.random.default_rng(1).bytes(20_000)
FILE = "data.csv"
DATA = [
    data("empty", ".csv", lambda _: b"", FILE, "empty"),
    data("header alone", ".csv", lambda b: b[: b.index(b"\n") + 1], FILE, "no line below"),
    data("BOM", ".csv", lambda b: b"\xef\xbb\xbf" + b, "Oscillator", welcome=True),
    data("UTF-16", ".csv", lambda b: b.decode().encode("utf-16"), "Oscillator", welcome=True),
    data("Latin-1 in a number", ".csv", _line(7, lambda b: b + b"\xf6"), FILE, "line 7", "not a number"),
    data("binary", ".csv", lambda b: b[:300] + GARBAGE, FILE, "no text", "name the reader that suits it"),
    data("semicolons", ".csv", lambda b: b.replace(b",", b";"), FILE, "semicolon", 'options = { delimiter = ";" }'),
    data("tabs", ".csv", lambda b: b.replace(b",", b"\t"), FILE, "tab", r'options = { delimiter = "\t" }'),
    data(
        "two columns of a name",
        ".csv",
        lambda b: b.replace(b"imag", b"real", 1),
        FILE,
        "2 columns have the name",
        "'real'",
    ),
    data("decimal commas", ".csv", lambda b: b.replace(b",", b";").replace(b".", b","), FILE, "semicolon"),
    data("a word in line 9", ".csv", _line(9, _last(b"overload")), FILE, "line 9", "imag", "overload"),
    data("an empty number in line 9", ".csv", _line(9, _last(b"")), FILE, "line 9", "imag", "not a number"),
    data("a column less in line 12", ".csv", _line(12, lambda b: b[: b.rindex(b",")]), FILE, "line 12", "columns"),
    data("nan in line 12", ".csv", _line(12, _last(b"nan")), FILE, "no finite number", "428.995 Hz"),
    data("inf in line 12", ".csv", _line(12, _last(b"inf")), FILE, "no finite number", "428.995 Hz"),
    data(
        "decimal comma in line 12",
        ".csv",
        _line(12, _last(b'"0,5"')),
        FILE,
        "line 12",
        "decimal point",
        'decimal = ","',
    ),
    data("a word far below", ".csv", _line(150, _last(b"x")), FILE, "line 150", '"x"'),
    data("unknown header", ".csv", lambda b: b.replace(b"frequency_Hz", b"f", 1), FILE, "frequency_Hz", "wanted"),
    data("harmonic 1.5", ".csv", lambda b: b.replace(b"force,1,", b"force,1.5,", 1), FILE, "harmonic", "1.5"),
    *(
        case
        for ending in WRITERS
        for case in (
            data("garbage", ending, lambda _: GARBAGE, f"data{ending}"),
            data("zeros", ending, lambda b: bytes(len(b)), f"data{ending}"),
            data("one third", ending, lambda b: b[: len(b) // 3], f"data{ending}"),
            data("all but ten bytes", ending, lambda b: b[:-10], f"data{ending}"),
        )
    ),
    data("empty", ".h5", lambda _: b"", "data.h5", "empty"),
    data("another HDF5 file", ".h5", lambda b: b.replace(b"updamp recorded", b"somebody's file"), "data.h5"),
    data("a text", ".uff", lambda _: b"hello\n" * 99, "data.uff", "universal file"),
    data("a bit turned", ".h5", lambda b: b[:6000] + bytes([b[6000] ^ 1]) + b[6001:], "data.h5", welcome=False),
]

# --- units that do not fit the model: recognised by their factor, said first, as a question ---


def compared(measurement: Path, rig: Path = RIGS / "brake_reuss.toml") -> Told:
    """All that `updamp compare` says before it fits anything."""

    def work() -> str:
        said = StringIO()
        files = CompareFiles(rig, measurement, measurement.parent / "out")
        inputs = comparison_inputs(files, "small", 1, Display(Console(file=said, width=10_000)), ())
        return f"{said.getvalue()} {' '.join(inputs.measurement.assumptions)}"

    return call(work)


def units(name: str, *words: str, **how: object) -> Broken:
    return Broken(f"units: {name}", words, lambda folder: compared(sweep_of_beam(folder, **how)))  # type: ignore[arg-type]


def mixed_up(old: str, new: str, name: str, *words: str) -> Broken:
    def made(folder: Path) -> Told:
        path = sweep_of_beam(folder)
        text = path.read_text(encoding="utf-8")
        assert old in text
        path.write_text(text.replace(old, new, 1), encoding="utf-8")
        return compared(path)

    return Broken(f"units: {name}", words, made)


G = 9.80665
UNITS = [
    units("mm/s said to be m/s", "sensor", "1000", "mm/s", "?", factor=1e3),
    units("m/s said to be mm/s", "sensor", "1000", "m/s", "?", unit="mm/s"),
    units("g said to be m/s2", "sensor", "9.8", "g_0", "?", quantity="acceleration", unit="m/s^2", factor=1 / G),
    units("m/s2 said to be g", "sensor", "9.8", "m/s^2", "?", quantity="acceleration", unit="g_0"),
    units("RMS said to be peak", "sensor", "1.41", "rms", "?", factor=1 / np.sqrt(2)),
    units("peak to peak said to be peak", "sensor", "2", "peak_to_peak", "?", factor=2),
    units("velocity over w said to be displacement", "sensor", "quantity", "?", quantity="displacement", unit="m",
          factor=RESONANCE),
    units("2 pi", "sensor", "6.28", "?", factor=2 * np.pi),
    units("kHz said to be Hz", "0.08", "kHz", "Hz", "?", frequency=lambda f: f / 1e3),
    units("mHz said to be Hz", "8.036e+04", "Hz", "?", frequency=lambda f: f * 1e3),
    units("rad/s said to be Hz", "rad/s", "6.28", "?", frequency=lambda f: f * 2 * np.pi),
    units("frequencies 200 Hz off", "80.", "28", "Hz", "frequencies", "?", frequency=lambda f: f + 200),
    units("three points", "low", "3 frequencies", "?", points=3),
    units("a factor of 1e6", "sensor", "1e+06", "?", factor=1e6),
    mixed_up('quantity = "velocity"\nunit = "m/s"', 'quantity = "displacement"\nunit = "mm"', "velocity as mm",
             "sensor", "?"),
]  # fmt: skip


def _sound(folder: Path) -> Told:
    """A measurement that fits is asked nothing."""
    told = compared(sweep_of_beam(folder))
    return replace(told, refused=told.refused or "?" in told.said)


def _other_mode(folder: Path) -> Told:
    text = TOML.replace('mode = "B"', 'mode = "OPP"').replace('rig = "oscillator"', 'rig = "pesaresi2017"')
    text = text.replace("mass.drive", "blade_right.excitation").replace("mass.tip", "blade_right.tip")
    write_long_csv(folder / "data.csv", [recorded()])
    (folder / "measurement.toml").write_text(text, encoding="utf-8")
    return call(lambda: _asked_of_rig(folder / "measurement.toml"))


def _asked_of_rig(path: Path) -> str:
    """What is asked before the model of a rig with geometry is made."""
    from updamp.model.rig_files import load_rig
    from updamp.workflow.comparison_inputs import model_points
    from updamp.workflow.measured_against_model import unknown_modes

    rig = load_rig(RIGS / "pesaresi2017.toml")
    measurement = load_measurement(path, model_points(), rig.name)
    return " ".join(unknown_modes(measurement, tuple(rig.study.modes)))


def _other_point(folder: Path) -> Told:
    """Before anything is meshed or written."""
    text = TOML.replace('rig = "oscillator"', 'rig = "pesaresi2017"').replace("mass.drive", "blade_right.excitation")
    (folder / "measurement.toml").write_text(text.replace("mass.tip", "schaufel.spitze"), encoding="utf-8")
    told = compared(folder / "measurement.toml", RIGS / "pesaresi2017.toml")
    return replace(told, refused=told.refused and not (folder / "out").exists())


MEASUREMENTS = [
    *STATED,
    *DATA,
    *UNITS,
    Broken("units: all as it should be", (), _sound, welcome=True),
    Broken("measurement: a mode that the rig does not have", ("OPP", "did you mean OOP", "?"), _other_mode),
    Broken("measurement: a point that no rig has", ("channels.laser.point", "schaufel.spitze.x", "blade_left.tip.x",
           "blade_right.platform.y", "damper.corner_right.y"), _other_point),
]  # fmt: skip
