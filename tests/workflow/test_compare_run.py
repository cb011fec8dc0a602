"""`updamp compare` as a person calls it: files it writes, sentences, errors."""

import json
from pathlib import Path

import numpy as np
import pytest
from typer.testing import CliRunner

from updamp.model.build import modal_model
from updamp.pipeline import app

RIG = Path(__file__).parents[2] / "rigs" / "brake_reuss.toml"

MEASUREMENT = """
title = "Beam"
rig = "brake_reuss"
damper_load = "0 N"
excitation = "beam.drive.x"

[channels.force]
point = "beam.drive"
direction = "x"
quantity = "force"
unit = "N"
amplitude = "peak"

[channels.laser]
point = "beam.drive"
direction = "x"
quantity = "displacement"
unit = "m"
amplitude = "peak"

[[runs]]
name = "low"
mode = "first bending"
file = "sweep.csv"
sweep = "up"
held = "force"
level = "1 N"
repeat = 1
"""


@pytest.fixture
def measurement(tmp_path: Path) -> Path:
    """One run of the beam that the rig file describes, with noise of 0.5 %."""
    rng = np.random.default_rng(0)
    f = np.linspace(79.6, 81.2, 41)
    w, w0 = 2 * np.pi * f, 2 * np.pi * 80.38
    mass = modal_mass()
    x = 1 / (mass * (w0**2 * (1 + 0.0031j) - w**2))
    x = x * (1 + 0.005 / np.sqrt(2) * (rng.standard_normal(41) + 1j * rng.standard_normal(41)))
    rows = [f"low,1,up,{a!r},force,1,1.0,0.0\nlow,1,up,{a!r},laser,1,{y.real!r},{y.imag!r}" for a, y in
            zip(f.tolist(), x.tolist(), strict=True)]  # fmt: skip
    head = "run,repeat,sweep,frequency_Hz,channel,harmonic,real,imag"
    (tmp_path / "sweep.csv").write_text("\n".join([head, *rows]) + "\n", encoding="utf-8")
    path = tmp_path / "measurement.toml"
    path.write_text(MEASUREMENT, encoding="utf-8")
    return path


def modal_mass() -> float:
    from updamp.model.rig_files import load_modal

    components = modal_model(load_modal(RIG)).components
    return float(components.phi[components.row("beam.drive.x"), 0] ** -2)


def compare(*arguments: object):
    return CliRunner().invoke(app, ["compare", *(str(a) for a in arguments)])


def test_it_writes_numbers_and_a_page_and_says_what_it_found(measurement: Path, tmp_path: Path) -> None:
    result = compare(RIG, measurement, "--out", tmp_path / "out", "--debug")
    assert result.exit_code == 0, result.output
    assert "no misfit beyond repeatability" in result.output
    numbers = json.loads((tmp_path / "out" / "comparison.json").read_text(encoding="utf-8"))
    assert numbers["adequate"] is True
    assert 0.6 < numbers["chi2_after"] / numbers["values"] < 1.4
    page = (tmp_path / "out" / "report.html").read_text(encoding="utf-8")
    assert "Beam" in page
    assert "http" not in page.split("<script", 1)[0].replace("http-equiv", "")
    pictures = {path.name for path in (tmp_path / "out" / "pictures").iterdir()}
    assert pictures == {f"compared_first_bending.{ending}" for ending in ("png", "svg", "pdf")}


def test_bad_input_ends_in_a_sentence(measurement: Path, tmp_path: Path) -> None:
    (tmp_path / "sweep.csv").write_text("not,a,measurement\n", encoding="utf-8")
    result = compare(RIG, measurement, "--out", tmp_path / "out")
    assert result.exit_code == 2
    assert "sweep.csv" in result.output
    assert "Traceback" not in result.output


def test_a_measurement_of_another_rig_is_refused(measurement: Path, tmp_path: Path) -> None:
    measurement.write_text(MEASUREMENT.replace("brake_reuss", "other"), encoding="utf-8")
    result = compare(RIG, measurement, "--out", tmp_path / "out")
    assert result.exit_code == 2
    assert "other" in result.output
