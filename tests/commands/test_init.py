"""`updamp init`: what a newcomer gets can be read, is sound, and its steps are commands that there are."""

import json
import os
import shlex
import subprocess
import sys
import venv
from pathlib import Path

import pytest
from support.broken.outcome import command

from updamp.commands.init import STEPS, activation
from updamp.measurement.load import load_measurement
from updamp.model.rig_files import load_rig
from updamp.pipeline import app
from updamp.rig.questions import questions
from updamp.workflow.comparison_inputs import model_points


@pytest.fixture
def folder(tmp_path: Path) -> Path:
    told = command("init", tmp_path / "first")
    assert not told.refused
    for step, _ in STEPS:
        assert step in told.said
    return tmp_path / "first"


def test_the_files_are_sound_and_the_truth_is_sealed(folder: Path) -> None:
    rig = load_rig(folder / "rig.toml")
    assert questions(rig) == []
    assert next(iter(rig.mesh)) == "small", "what commands take where no mesh is named"
    measurement = load_measurement(folder / "measurement.toml", model_points(), rig.name)
    assert {run.mode for run in measurement.runs} == set(rig.study.modes)
    sealed = json.loads((folder / "sealed.json").read_text())
    assert [one["name"] for one in sealed["hidden"]] == ["blade_mistuning"]
    assert "mistuning" not in (folder / "rig.toml").read_text() + (folder / "measurement.toml").read_text()
    assert sum(path.stat().st_size for path in folder.iterdir()) < 300_000


def test_the_steps_are_commands_of_this_program_on_files_that_are_there(folder: Path) -> None:
    there = {path.name for path in folder.iterdir()}
    known = {one.callback.__name__ for one in app.registered_commands}
    for step, purpose in STEPS:
        program, name, *arguments = shlex.split(step)
        assert program == "updamp"
        assert name in known
        assert {one for one in arguments if one.endswith(".toml") and one != "better.toml"} <= there
        assert purpose
    runs = {run.name for run in load_measurement(folder / "measurement.toml", model_points()).runs}
    words = [word for step, _ in STEPS for word in shlex.split(step)]
    held_out = {words[i + 1] for i, word in enumerate(words) if word == "--hold-out"}
    assert set() < held_out < runs
    assert all(step in (folder / "README.md").read_text() for step, _ in STEPS)


def test_nothing_is_written_over(folder: Path) -> None:
    (folder / "rig.toml").write_text("mine")
    told = command("init", folder)
    assert told.refused
    assert "rig.toml, measurement.toml, sweeps.csv, sealed.json already; give another folder" in told.said
    assert (folder / "rig.toml").read_text() == "mine"


def test_options_are_named_in_full_on_a_narrow_terminal(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("COLUMNS", "80")
    said = command("diagnose", "--help").said
    whole = ("--next-measurement / --no-next-measurement", "--hold-out-mode", "-m, --mesh", "-o, --out", "-j, --jobs")
    assert [option for option in whole if option not in said] == []


def test_where_the_shell_does_not_find_updamp_it_is_told_how_it_will(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """The advice is followed by a shell, in an environment whose path has a blank."""
    place = tmp_path / "an environment"
    venv.create(place, symlinks=True)
    program = place / "bin" / "updamp"
    program.write_text("#!/bin/sh\necho found\n")
    program.chmod(0o755)
    monkeypatch.setattr(sys, "prefix", str(place))
    monkeypatch.setenv("PATH", os.defpath)
    said = command("init", tmp_path / "a first one").said
    advice = [line.strip() for line in said.splitlines() if line.strip().startswith(("source ", "cd "))]
    assert len(advice) == 2, "before the steps, in this order"
    script = "; ".join([*advice, "pwd", "updamp"])
    shell = subprocess.run(["bash", "-c", script], capture_output=True, text=True, check=True, cwd=tmp_path)
    assert shell.stdout.splitlines() == [str(tmp_path / "a first one"), "found"]


def test_no_advice_where_the_shell_finds_it_or_there_is_no_environment(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(sys, "prefix", str(tmp_path))
    monkeypatch.setenv("PATH", os.defpath)
    assert activation() == (), "nothing to be activated"
    (tmp_path / "bin").mkdir()
    (tmp_path / "bin" / "activate").touch()
    assert activation() == (f"source {tmp_path}/bin/activate",)
    program = tmp_path / "bin" / "updamp"
    program.touch(mode=0o755)
    monkeypatch.setenv("PATH", str(program.parent))
    assert activation() == ()


ROOT = Path(__file__).parents[2]


@pytest.mark.parametrize("rig", ["rigs/pesaresi2017.toml", "rigs/virtual_rig.toml", "commands/example/rig.toml"])
def test_the_change_of_friction_that_the_readme_shows_is_read_whatever_the_file_had(rig: str, tmp_path: Path) -> None:
    (line,) = [line for line in (ROOT / "README.md").read_text("utf-8").splitlines() if line.startswith("    sed ")]
    program, change, *_ = shlex.split(line)
    changed = subprocess.run([program, change, ROOT / rig], capture_output=True, text=True, check=True).stdout
    (tmp_path / "mine.toml").write_text(changed, encoding="utf-8")
    before, after = load_rig(ROOT / rig), load_rig(tmp_path / "mine.toml")
    assert before.contact.friction_coefficient != after.contact.friction_coefficient == 0.4
    assert len(set(changed.splitlines()) - set((ROOT / rig).read_text("utf-8").splitlines())) == 1
