"""Blind runs: what a diagnosis is given, what is kept, and that finished cases are not done again."""

import json
from dataclasses import fields
from pathlib import Path

import numpy as np
import pytest
import typer
from support.plain_rig import TINY_PRESET

from updamp.benchmarks.hidden_effects import run
from updamp.benchmarks.hidden_effects.cases import chosen
from updamp.benchmarks.hidden_effects.fitted_model import FINER, build, place
from updamp.benchmarks.hidden_effects.layout import Layout, write_whole
from updamp.benchmarks.hidden_effects.run import Task, diagnose, tasks
from updamp.benchmarks.hidden_effects.version_1 import version_1
from updamp.benchmarks.hidden_effects.version_2 import chosen_cases
from updamp.diagnosis.verdict import VERDICT_JSON, Confounding, ErrorReached, Verdict

RIG = Path(__file__).parents[2] / "rigs" / "virtual_rig.toml"
ADEQUATE = Verdict(
    "adequate", "", (), (), (), ErrorReached(1.0, 1.0, 1.0, 1.0, 1.0), (), (),
    Confounding((), np.zeros((0, 0)), 0.9, ()), (), (), {},
)  # fmt: skip


@pytest.fixture
def layout(tmp_path: Path) -> Layout:
    """Data of the three repetitions, made up, and stages of a model."""
    found = Layout(tmp_path)
    for case in chosen(version_1(), ("resolution",)):
        write_whole(found.truth(case.name), {"case": case.name, "effects": ["secret"]})
        found.data(case.name).mkdir(parents=True)
        found.measurement(case.name).write_text(f"title = '{case.name}'")
        for preset in (case.fitted, *FINER[case.fitted]):
            stages = found.models(RIG) / preset / "stages"
            stages.mkdir(parents=True, exist_ok=True)
            (stages / "mesh.h5").write_text("nodes")
    return found


def test_diagnosis_is_given_nothing_of_the_truth(layout: Layout, monkeypatch: pytest.MonkeyPatch) -> None:
    given = []

    def seeing(rig: Path, preset: str, measurement: Path, out: Path) -> Verdict:
        given.append((rig, preset, measurement, sorted(p.relative_to(out) for p in out.rglob("*.h5"))))
        return ADEQUATE

    monkeypatch.setattr(run, "diagnose_case", seeing)
    found, missing = tasks(layout, chosen_cases(None, ["resolution", "pair"]))
    assert len(missing) == 12
    assert {f.name for f in fields(Task)} == {"name", "rig", "preset", "measurement", "model", "out"}
    for task in found:
        assert diagnose(task).verdict == "adequate"
        assert VERDICT_JSON.read(task.out / "diagnosis.json").verdict == "adequate"
    assert {preset for _, preset, _, _ in given} == {"diagnosis_146"}
    assert {m.parent.name for _, _, m, _ in given} == {case.name for case in chosen(version_1(), ("resolution",))}
    assert all(not layout.truth(m.parent.name).is_relative_to(m.parent) for _, _, m, _ in given)
    finer = [Path(preset) / "stages/mesh.h5" for preset in FINER["diagnosis_146"]]
    assert all(stages == sorted([*finer, Path("stages/mesh.h5")]) for *_, stages in given)


def test_finished_cases_are_left_and_changed_ones_done_again(layout: Layout, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(run, "diagnose_case", lambda *_: ADEQUATE)
    first, *others = tasks(layout, chosen_cases(None, ["resolution"]))[0]
    assert not first.done
    diagnose(first)
    assert first.done
    assert not any(task.done for task in others)
    first.measurement.write_text("title = 'measured again'")
    assert not first.done


def test_verdicts_of_another_version_are_named(
    layout: Layout, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.setattr(run, "diagnose_case", lambda *_: ADEQUATE)
    monkeypatch.setattr(run, "build", lambda *_: None)
    monkeypatch.setattr(run, "build_dimensions", lambda *_: None)
    run.main(layout.folder, only=["resolution"])
    run.main(layout.folder, only=["resolution"])
    assert "another version" not in capsys.readouterr().err
    monkeypatch.setattr(run, "code_version", lambda *_: "code of another day")
    run.main(layout.folder, only=["resolution"])
    names = ", ".join(task.name for task in tasks(layout, chosen_cases(None, ["resolution"]))[0])
    assert f"by another version of updamp: {names}; --again" in capsys.readouterr().err
    run.main(layout.folder, only=["resolution"], again=True)
    run.main(layout.folder, only=["resolution"])
    assert "another version" not in capsys.readouterr().err


def test_a_failed_diagnosis_leaves_no_result(layout: Layout, monkeypatch: pytest.MonkeyPatch) -> None:
    def failing(*_: object) -> Verdict:
        raise ArithmeticError("stalled")

    monkeypatch.setattr(run, "diagnose_case", failing)
    monkeypatch.setattr(run, "build", lambda *_: None)
    monkeypatch.setattr(run, "build_dimensions", lambda *_: None)
    with pytest.raises(typer.Exit):
        run.main(layout.folder, only=["resolution"])
    assert not list((layout.folder / "verdicts").rglob("run.json"))
    monkeypatch.setattr(run, "diagnose_case", lambda *_: ADEQUATE)
    run.main(layout.folder, only=["resolution"])
    kept = [json.loads(path.read_text()) for path in (layout.folder / "verdicts").rglob("run.json")]
    assert len(kept) == 3
    assert all(one["seconds"] >= 0 and one["preset"] == "diagnosis_146" for one in kept)


def test_model_is_built_once_and_copied(tmp_path: Path) -> None:
    rig = tmp_path / "rig.toml"
    rig.write_text(RIG.read_text().replace("modes = 24 ", "modes = 8 ") + TINY_PRESET)
    model = build(rig, "tiny", tmp_path / "models")
    built = {path.name: path.stat().st_mtime_ns for path in (model / "stages").iterdir()}
    assert {"mesh.h5", "finite_elements.h5", "static_contact.h5"} <= set(built)
    build(rig, "tiny", tmp_path / "models")
    assert {p.name: p.stat().st_mtime_ns for p in (model / "stages").glob("*.h5")} == {
        name: when for name, when in built.items() if name.endswith(".h5")
    }
    place(model, tmp_path / "case")
    assert {p.name for p in (tmp_path / "case" / "stages").iterdir()} == set(built)
