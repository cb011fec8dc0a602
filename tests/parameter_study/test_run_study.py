"""A whole study on the coarsest mesh: what it leaves, what a second run does, what a kill loses."""

import json
import os
import signal
import subprocess
import sys
import time
from pathlib import Path

import numpy as np
import pytest
from rich.console import Console
from support.curves import softening_curve
from support.parameter_study import STUDY, run, study_folder

from updamp.fem.contact_places import nearest_patch
from updamp.model.small_amplitude import small_amplitude
from updamp.parameter_study import solved_study
from updamp.parameter_study.design_numbers import design_numbers
from updamp.parameter_study.families import CurveName
from updamp.parameter_study.mode_peak import window_of_mode
from updamp.parameter_study.outputs import check_findings, write_outputs
from updamp.parameter_study.run_study import counted, run_parameter_study
from updamp.parameter_study.solved_study import loop_at
from updamp.parameter_study.study_file import read_parameter_study
from updamp.workflow.progress import Display

CURVES = 4


@pytest.fixture(scope="module")
def file(tmp_path_factory):
    return study_folder(tmp_path_factory.mktemp("study"))


@pytest.fixture(scope="module")
def solved(file):
    return run(file).result


def test_all_curves_are_there_and_of_the_right_mode(solved):
    assert len(solved.curves) == CURVES
    assert solved.missing == {}
    peak = solved.peak(CurveName("film", "OOP", 0.096))
    stuck = solved.variants["film"].mode("OOP").frequency
    assert peak.frequency == pytest.approx(stuck, rel=1e-3), "nothing slips under so small a force"


def test_a_second_run_traces_nothing(solved, file):
    before = {path: path.stat().st_mtime_ns for path in (solved.folder / "stages").glob("curve_*.h5")}
    again = run(file)
    assert not again.interrupted
    assert {path: path.stat().st_mtime_ns for path in before} == before
    assert list(again.result.curves) == list(solved.curves)


def test_named_contacts_lie_where_they_are_stated(solved):
    contacts, (upper, centre) = solved.patches("film"), solved.study.contacts
    top, middle = (contacts.point[nearest_patch(contacts, place)] for place in (upper, centre))
    assert top[1] > middle[1]
    assert top[0] > 0
    assert middle[0] > 0, "the right face"
    assert abs(middle[2]) < solved.rig.blade.width / 4


def test_a_stuck_contact_has_a_force_in_proportion_to_its_motion(solved):
    loop = loop_at(solved, CurveName("film", "OOP", 0.096), "A2")
    area = solved.patches("film").area[nearest_patch(solved.patches("film"), solved.study.contacts[1])]
    stiffness = solved.rig.contact.tangential_stiffness * area
    np.testing.assert_allclose(loop.force[:, 0], stiffness * loop.motion[:, 0], atol=1e-9 * np.abs(loop.force).max())
    assert loop.normal.min() > 0


def test_design_numbers(solved):
    numbers = design_numbers(solved, CurveName("film", "OOP", 0.96))
    assert numbers.force_ratio == pytest.approx(solved.rig.load.pull / 0.96)
    assert numbers.frequency_shift > 1, "the damper stiffens"
    assert 0 < numbers.displacement_ratio < 1
    assert 0 <= numbers.energy_ratio < 1


@pytest.mark.long
def test_outputs_and_findings(solved):
    findings = check_findings(solved)
    with Display(Console(quiet=True)) as display:
        write_outputs(solved, findings, display)
    found = json.loads((solved.folder / "study.json").read_text())
    assert [one["number"] for one in found["findings"]] == list(range(1, 16))
    assert set(found["findings"][0]) >= {"number", "paper", "updamp", "met", "measure"}
    assert all(one["met"] is None for one in found["findings"] if one["number"] in (1, 5, 12))
    assert len(found["curves"]) == CURVES
    html = (solved.folder / "study.html").read_text()
    for file in found["pictures"]:
        assert (solved.folder / file).stat().st_size > 5000
    kinds = ("responses", "against_test", "peaks", "damper_motion", "contact_states", "force_loops", "mean_position",
             "pressure")  # fmt: skip
    assert all(any(f"levels_{kind}" in file for file in found["pictures"]) for kind in kinds)
    assert "<script src" not in html
    assert html.count("data:image/png") >= len(kinds) - 2


def test_peaks_are_taken_at_the_blade_that_a_variant_is_excited_at(tmp_path, monkeypatch):
    """Else a rig and its mirror image would have other peaks."""
    changes = 'changes = { "excitation.blade" = "left" }'
    text = STUDY.replace('changes = { "contact.pressure" = { model = "uniform" } }', changes)
    result = run(study_folder(tmp_path, text), solve=False).result
    assert [result.point(variant) for variant in ("film", "50/50")] == ["blade_right.tip.x", "blade_left.tip.x"]
    monkeypatch.setattr(solved_study, "peak_of_mode", lambda _, point, reference: (point, reference.name))
    assert result.peak_of(CurveName("50/50", "OOP", 0.096), softening_curve()) == ("blade_left.tip.x", "OOP")


def test_a_variant_that_cannot_be_built_leaves_the_others(tmp_path):
    """Its curves are missing, with the reason."""
    changes = 'changes = { "contact.pressure" = { model = "polynomial", map = "line.csv" } }'
    (tmp_path / "line.csv").write_text("s,z,pressure\n" + "".join(f"0.3,{z / 20 - 1},1\n" for z in range(40)))
    text = STUDY.replace('changes = { "contact.pressure" = { model = "uniform" } }', changes)
    result = run(study_folder(tmp_path, text), solve=False).result
    missing = {name.variant: reason for name, reason in result.missing.items()}
    assert "determine only" in missing["50/50"]
    assert missing["film"] == "not traced yet"


def test_the_last_line_says_how_many_of_the_known_curves_are_complete():
    whole, stopped = softening_curve(), softening_curve(stopped="the branch stops")
    assert counted([whole, whole], 2) == "2 of 2 known, 2 of them complete"
    assert counted([whole, stopped], 3).startswith("2 of 3 known, 1 of them complete; study.html has the reasons")


def test_the_last_line_stands_in_the_terminal(solved, file, capsys):
    study = read_parameter_study(file)
    with Display(Console(width=200)) as display:
        run_parameter_study(study, study.out, 1, display, solve=False)
    complete = sum(curve.complete for curve in solved.curves.values())
    assert f"{CURVES} of {CURVES} known, {complete} of them complete" in capsys.readouterr().out


def whole_curves(stages: Path) -> dict[Path, int]:
    """File -> when it was written [ns]"""
    return {path: path.stat().st_mtime_ns for path in stages.glob("curve_*.h5") if "partial" not in path.name}


@pytest.mark.long
def test_nothing_that_was_traced_is_lost_by_a_kill(tmp_path):
    file = study_folder(tmp_path, STUDY.replace('"0.96 N"', '"0.96 N", "3.84 N", "6 N", "9.6 N"'))
    environment = {**os.environ, "PYTHONPATH": os.pathsep.join(sys.path)}
    command = [sys.executable, "-m", "updamp.pipeline", "study", str(file), "--jobs", "1"]
    process = subprocess.Popen(command, env=environment, stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)
    stages, until = tmp_path / "out" / "tiny" / "stages", time.monotonic() + 240
    while len(whole_curves(stages)) < 2 and process.poll() is None:
        assert time.monotonic() < until, "no curves come"
        time.sleep(0.02)
    process.send_signal(signal.SIGKILL)
    process.wait()
    before = whole_curves(stages)
    assert 2 <= len(before) < 10
    result = run(file).result
    assert len(result.curves) == 10
    assert {path: path.stat().st_mtime_ns for path in before} == before


def test_a_window_moves_down_with_contacts_that_are_open_at_rest(tmp_path, solved):
    """As far as the mode at small amplitude; where nothing is open it stays as it is."""
    flat = 'changes = { "contact.pressure" = { model = "fe" } }'
    text = STUDY.replace('changes = { "contact.pressure" = { model = "uniform" } }', flat)
    result = run(study_folder(tmp_path, text), solve=False).result
    open_at_rest = result.variants["50/50"]
    stuck, (low, high) = open_at_rest.mode("OOP"), window_of_mode(open_at_rest, "OOP")
    near = small_amplitude(open_at_rest.model, stuck.frequency).frequencies
    assert high < stuck.window[1]
    assert np.any((near > low) & (near < high)), "the mode is in it"
    assert window_of_mode(solved.variants["film"], "OOP") == solved.variants["film"].mode("OOP").window
