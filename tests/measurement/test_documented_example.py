"""The example of docs/measurements.md works as it stands there."""

import re
from pathlib import Path

import numpy as np
import pytest

from updamp.measurement.load import load_measurement
from updamp.measurement.readers.long_csv import COLUMNS, write_long_csv
from updamp.measurement.readers.registry import readers
from updamp.measurement.readers.uff import write_uff58
from updamp.measurement.recorded import RecordedChannel, RecordedSweep

TEXT = (Path(__file__).parents[2] / "docs" / "measurements.md").read_text(encoding="utf-8")
F = np.linspace(446, 432, 57)
W = 2 * np.pi * F


def block(language: str) -> str:
    found = re.search(rf"```{language}\n(.*?)```", TEXT, re.DOTALL)
    assert found is not None
    return found[1]


def displacement(force: float) -> np.ndarray:
    return force / (0.5 * ((2 * np.pi * 440) ** 2 * (1 + 0.005j) - W**2))


def sweep(force: float, run: str, repeat: int) -> RecordedSweep:
    x = displacement(force) * (1 + 0.01 * repeat)
    velocity = (1j * W * x * 1e3 / np.sqrt(2))[None]
    channels = {
        "force": RecordedChannel(np.full((1, len(F)), force, complex)),
        "laser 1": RecordedChannel(-velocity),
        "laser 2": RecordedChannel(-velocity),
    }
    return RecordedSweep(run, repeat, "down", F, channels)


def test_example(tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]) -> None:
    (tmp_path / "measurement.toml").write_text(block("toml"))
    write_long_csv(tmp_path / "oop_17N.csv", [sweep(17, "OOP 17 N", repeat) for repeat in (1, 2, 3)])
    write_uff58(tmp_path / "oop_1N.uff", [sweep(0.96, "OOP 0.96 N", 1)])
    points = [f"{blade}.{place}.x" for blade in ("blade_left", "blade_right") for place in ("tip", "excitation")]
    measurement = load_measurement(tmp_path / "measurement.toml", points, rig="pesaresi2017")
    assert [(run.name, run.repeat) for run in measurement.runs] == [
        *(("OOP 17 N", repeat) for repeat in (1, 2, 3)),
        ("OOP 0.96 N", 1),
    ]
    run = measurement.runs[1]
    assert (run.mode, run.upwards, run.held, run.level) == ("OOP", False, "force", 17.0)
    np.testing.assert_allclose(run.amplitude("tip_right"), 1.02 * displacement(17), rtol=1e-12)
    np.testing.assert_allclose(run.amplitude("tip_left"), -1.02 * displacement(17), rtol=1e-12)
    assert run.noise is not None
    np.testing.assert_allclose(run.noise[0, 0], 2e-6 * np.sqrt(2) / W, rtol=1e-12)
    assert measurement.assumptions == (
        "fewer than 3 assemblies were measured of 'OOP 0.96 N' (1): the scatter from one assembly to the next is "
        "hardly known from them",
    )
    monkeypatch.chdir(tmp_path)
    exec(block("python"), {})
    assert len(capsys.readouterr().out.splitlines()) == 5


def test_csv_shown_has_the_header_that_is_read() -> None:
    assert block("csv").splitlines()[0] == ",".join(COLUMNS)


def test_every_reader_stands_in_the_table() -> None:
    for reader in readers().values():
        row = next(line for line in TEXT.splitlines() if line.startswith(f"| `{reader.name}`"))
        for ending in reader.endings:
            assert ending in row
        for key in reader.options.model_fields:
            assert f"`{key}`" in row
