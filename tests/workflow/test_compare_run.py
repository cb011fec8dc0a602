"""`updamp compare` as a person calls it: files it writes, sentences, errors."""

import json
from io import StringIO
from pathlib import Path

import pytest
from rich.console import Console
from support.one_sweep import sweep_of_beam
from typer.testing import CliRunner

from updamp.commands.shared import chosen_names
from updamp.model.rig_files import load_rig
from updamp.pipeline import app
from updamp.workflow import limits
from updamp.workflow.built_rig import NO_FINER, finer_rigs
from updamp.workflow.progress import Display

RIGS = Path(__file__).parents[2] / "rigs"
RIG = RIGS / "brake_reuss.toml"


@pytest.fixture
def measurement(tmp_path: Path) -> Path:
    return sweep_of_beam(tmp_path, quantity="displacement", unit="m")


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
    text = measurement.read_text(encoding="utf-8")
    measurement.write_text(text.replace("brake_reuss", "other"), encoding="utf-8")
    result = compare(RIG, measurement, "--out", tmp_path / "out")
    assert result.exit_code == 2
    assert "other" in result.output


def test_a_rig_that_is_excited_elsewhere_is_told_before_finite_elements(measurement: Path, tmp_path: Path) -> None:
    text = measurement.read_text(encoding="utf-8").replace("brake_reuss", "pesaresi2017")
    text = text.replace("beam.drive", "blade_left.excitation")
    measurement.write_text(text, encoding="utf-8")
    result = compare(RIGS / "pesaresi2017.toml", measurement, "--out", tmp_path / "out")
    assert result.exit_code == 2
    assert "the rig file excites the model at" in result.output
    assert "blade_right.excitation.x" in result.output
    assert not (tmp_path / "out").exists()


def finer(mesh: str, wanted: list[str] | None, out: Path) -> tuple[list[str], str]:
    """Presets that tell the numerical error, and what is said."""
    said = StringIO()
    with Display(Console(file=said, width=200)) as display:
        rig = load_rig(RIGS / "pesaresi2017.toml")
        return list(finer_rigs(rig, mesh, out, 1, display, chosen_names(wanted))), said.getvalue()


def test_the_numerical_error_is_asked_for_unless_one_says_no(tmp_path: Path) -> None:
    assert finer("small", None, tmp_path) == (["medium"], "")
    assert finer("small", ["full", "medium", "full"], tmp_path) == (["full", "medium"], "")
    for mesh, wanted in (("full", None), ("small", ["none"])):
        presets, said = finer(mesh, wanted, tmp_path)
        assert presets == []
        assert NO_FINER in said


def test_a_finer_preset_that_memory_does_not_hold_can_be_left_out(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(limits, "free_memory", lambda: 1.2e9)
    with pytest.raises(ValueError, match=r"mesh\.medium: .* GB are free.*\n.*--finer none"):
        finer("small", None, tmp_path)
    with pytest.raises(ValueError, match=r"mesh\.full: .* GB are free.* take fewer$"):
        finer("small", ["full"], tmp_path)


def test_the_report_of_a_diagnosis_is_not_replaced(measurement: Path, tmp_path: Path) -> None:
    """They were of one name, and one folder for all steps is there so that finite elements are computed once."""
    out = tmp_path / "out"
    out.mkdir()
    (out / "diagnosis.json").write_text("{}", encoding="utf-8")
    (out / "report.html").write_text("of the diagnosis", encoding="utf-8")
    result = compare(RIG, measurement, "--out", out)
    assert result.exit_code == 0, result.output
    assert "comparison.html" in result.output
    assert (out / "report.html").read_text(encoding="utf-8") == "of the diagnosis"
    assert "Beam" in (out / "comparison.html").read_text(encoding="utf-8")
