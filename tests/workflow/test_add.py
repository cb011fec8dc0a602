"""`updamp add`, `remove` and `history` as a person calls them, on a verdict made up for the test."""

import io
import tomllib
from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from PIL import Image
from rich.console import Console
from support.plain_rig import around_first_stuck_mode, plain_blade, plain_damper
from typer.testing import CliRunner

from updamp.comparison.comparison import COMPARISON_JSON, Calibrated
from updamp.diagnosis.verdict import (
    VERDICT_JSON,
    Candidate,
    Confounding,
    ErrorReached,
    Explanation,
    FittedEffect,
    FittedParameter,
    Step,
    Verdict,
)
from updamp.effects.catalogue import CATALOGUE
from updamp.hbm.continuation.response_curve import ResponseCurve
from updamp.model.rig_files import load_any, load_modal, load_rig
from updamp.pipeline import app
from updamp.rig.errors import RigError
from updamp.workflow import store
from updamp.workflow.add import AddOptions, add, remove
from updamp.workflow.history import Errors, history_file, read_history
from updamp.workflow.progress import Display
from updamp.workflow.run import Run
from updamp.workflow.run_options import RunOptions
from updamp.workflow.stage_functions import StageFunctions
from updamp.workflow.stages import STATIC_CONTACT

RIGS = Path(__file__).parents[2] / "rigs"
NAN = float("nan")
SHA = "0f" * 32
OWN = """
from updamp.api import Effect, EffectParameter

def apply(model, values):
    return model.with_contacts(mu=model.contacts.parameters.mu * values["factor"])

EFFECT = Effect("oily", "someone oiled it", (EffectParameter("factor", 1.0, 0.01, 1.0, 0.3, "", "a guess"),), apply)
"""


def candidate(name: str, held_out_gain: float = NAN, reason: str = "", **values: float) -> Candidate:
    """Fitted to values, with an interval of 10 % to both sides; not refitted without any."""
    known = {p.name: p for p in CATALOGUE[name].parameters} if name in CATALOGUE else {}
    fitted = tuple(
        FittedParameter(
            parameter, known[parameter].unit if known else "", value, 0.9 * value, 1.1 * value,
            *((known[parameter].null, known[parameter].lower, known[parameter].upper) if known else (1.0, 0.01, 1.0)),
        )
        for parameter, value in values.items()
    )  # fmt: skip
    return Candidate(name, f"{name} is missing", 9.0, 0.5, 80.0, NAN, NAN, held_out_gain, fitted, not reason, reason)


CANDIDATES = (
    candidate("shaker_attachment", 0.6, mass=0.123456789, dashpot=0.5),
    candidate("blade_mistuning", 0.25, "no gain on held-out data", difference=0.01),
    candidate("edge_gap", 0.1, "another explains more", depth=3e-7),
    candidate("wire_stiffness", reason="score below 3"),
    candidate("oily", 0.2, factor=0.5),
)


def verdict(effects: Sequence[str] = ("shaker_attachment",), **changes: object) -> Verdict:
    made = Verdict(
        verdict="identified" if effects else "unknown",
        sentence="",
        effects=tuple(effects),
        group=(),
        candidates=CANDIDATES,
        error=ErrorReached(5.0, 1.1, 4.0, 1.3, 1.0),
        next_measurement=(),
        signatures=(),
        confounding=Confounding((), np.zeros((0, 0)), 0.9, (("shaker_attachment", "blade_mistuning"),)),
        missing_forces=(),
        history=(Step((), 5.0, 4.0), Step(("shaker_attachment",), 1.1, 1.3)),
        provenance={"measurement": "test/measurement.toml", "date": "2026-11-20", "SHA-256 of sweeps.csv": SHA},
    )
    return replace(made, **changes)


@pytest.fixture
def diagnosed(tmp_path: Path) -> Path:
    folder = tmp_path / "diagnosis"
    folder.mkdir()
    VERDICT_JSON.write(folder / "diagnosis.json", verdict())
    return folder


@pytest.fixture
def rig(tmp_path: Path) -> Path:
    path = tmp_path / "rig.toml"
    path.write_text((RIGS / "pesaresi2017.toml").read_text(encoding="utf-8"), encoding="utf-8")
    return path


def updamp(*arguments: object):
    return CliRunner().invoke(app, [str(argument) for argument in arguments], env={"COLUMNS": "200"})


def effects_of(path: Path) -> dict[str, dict[str, float]]:
    return {effect.name: dict(effect.values) for effect in load_any(path).effects}


# --- the new rig file ---


def test_the_new_file_is_the_old_one_with_values_and_their_origin_at_its_end(rig, diagnosed):
    before = rig.read_text(encoding="utf-8")
    result = updamp("add", rig, "shaker_attachment", "--from", diagnosed, "--debug")
    assert result.exit_code == 0, result.output
    new = rig.with_name("rig+shaker_attachment.toml")
    text = new.read_text(encoding="utf-8")
    assert text.startswith(before), "comments and all"
    assert rig.read_text(encoding="utf-8") == before
    (stated,) = tomllib.loads(text)["effects"]
    assert stated == {
        "name": "shaker_attachment",
        "values": {"mass": "0.123457 kg", "dashpot": "0.5 N*s/m"},
        "origin": "fitted to test/measurement.toml, 2026-11-20; 95 %: mass 0.111 to 0.136 kg, "
        "dashpot 0.45 to 0.55 N*s/m",
    }
    assert effects_of(new) == {"shaker_attachment": {"mass": 0.123457, "stiffness": 0.0, "dashpot": 0.5}}
    assert "cannot tell" not in result.output, "they look alike to first order, and the verdict tells them apart"


def test_without_names_those_that_were_identified_are_added(rig, diagnosed):
    assert add(rig, (), diagnosed).rig.name == "rig+shaker_attachment.toml"
    VERDICT_JSON.write(diagnosed / "diagnosis.json", verdict(effects=()))
    with pytest.raises(
        ValueError, match=r"no effect was identified \(unknown\); name one .*shaker_attachment, blade_m"
    ):
        add(rig, (), diagnosed)


def test_a_wrong_dimension_is_no_effect_of_a_file_but_stated_where_it_stands(rig, diagnosed):
    longer = (candidate("face_length", 0.5, change=0.021),)
    VERDICT_JSON.write(diagnosed / "diagnosis.json", verdict(("face_length",), candidates=longer))
    result = updamp("add", rig, "--from", diagnosed)
    assert result.exit_code == 2
    assert 'write damper.face_length = "4.084 mm" in place of damper.face_length = "4 mm"' in result.output
    assert not rig.with_name("rig+face_length.toml").exists()


def test_of_a_group_none_is_added_unless_it_is_named(rig, diagnosed):
    apart = replace(verdict(), verdict="inseparable", group=("shaker_attachment", "blade_mistuning"))
    VERDICT_JSON.write(diagnosed / "diagnosis.json", apart)
    with pytest.raises(ValueError, match="do not tell which of shaker_attachment, blade_mistuning is missing; name"):
        add(rig, (), diagnosed)
    assert add(rig, ["shaker_attachment"], diagnosed).rig.name == "rig+shaker_attachment.toml"


def test_effects_stack_and_come_off_again(rig, diagnosed):
    one = add(rig, ["edge_gap"], diagnosed).rig
    two = add(one, ["shaker_attachment"], diagnosed).rig
    assert list(effects_of(two)) == ["edge_gap", "shaker_attachment"]
    assert two.read_text(encoding="utf-8").count("\n\n[[effects]]\n") == 2, "empty lines between tables"
    result = updamp("remove", two, "edge_gap", "--out", two.with_name("second.toml"), "--debug")
    assert result.exit_code == 0, result.output
    assert list(effects_of(two.with_name("second.toml"))) == ["shaker_attachment"]
    none = remove(two, ["edge_gap", "shaker_attachment"], two.with_name("none.toml")).rig
    assert none.read_text(encoding="utf-8") == rig.read_text(encoding="utf-8")
    several = add(rig, ["edge_gap", "shaker_attachment"], diagnosed, AddOptions(out=rig.with_name("several.toml"))).rig
    assert effects_of(several) == effects_of(two)


def test_comments_of_the_file_s_own_effects_stay_when_their_values_are_replaced(rig, diagnosed):
    text = rig.read_text(encoding="utf-8")
    text += '\n# seen in May\n[[effects]]   # by Ann\nname = "edge_gap"\nvalues = { depth = "1 um" }   # guessed\n'
    rig.write_text(text + "\n[calibration]\npreload = 1.02\n", encoding="utf-8")
    new = add(rig, ["edge_gap", "shaker_attachment"], diagnosed, AddOptions(replace=True)).rig
    written = new.read_text(encoding="utf-8")
    for comment in ("# seen in May", "# by Ann", "# guessed"):
        assert comment in written
    assert effects_of(new)["edge_gap"] == {"depth": 3e-7}
    assert list(effects_of(new)) == ["edge_gap", "shaker_attachment"]
    assert load_rig(new).calibration.factors == {"preload": 1.02}


def test_effects_written_as_inline_tables_are_added_to(rig, diagnosed):
    text = rig.read_text(encoding="utf-8")
    inline = 'effects = [{ name = "wire_stiffness", values = { factor = 2.0 } }]   # in one line\n'
    rig.write_text(inline + text, encoding="utf-8")
    new = add(rig, ["edge_gap"], diagnosed).rig
    assert list(effects_of(new)) == ["wire_stiffness", "edge_gap"]
    assert "# in one line" in new.read_text(encoding="utf-8")
    assert effects_of(remove(new, ["wire_stiffness"]).rig) == {"edge_gap": {"depth": 3e-7}}


def test_an_effect_at_its_null_value_waits_to_be_fitted(rig, diagnosed):
    waiting = '\n[[effects]]\nname = "edge_gap"\nvalues = { depth = "0 um" }\n'
    rig.write_text(rig.read_text(encoding="utf-8") + waiting, encoding="utf-8")
    assert effects_of(add(rig, ["edge_gap"], diagnosed).rig) == {"edge_gap": {"depth": 3e-7}}


def test_files_that_the_rig_names_are_found_from_another_folder(rig, diagnosed, tmp_path):
    (tmp_path / "oily.py").write_text(OWN)
    out = tmp_path / "elsewhere" / "deep" / "new.toml"
    result = updamp("add", rig, "oily", "--from", diagnosed, "--file", tmp_path / "oily.py", "--out", out, "--debug")
    assert result.exit_code == 0, result.output
    (effect,) = load_rig(out).effects
    assert effect.file.resolve() == tmp_path / "oily.py"
    assert tomllib.loads(out.read_text(encoding="utf-8"))["effects"][0]["file"] == "../../oily.py"
    back = add(out, ["edge_gap"], diagnosed, AddOptions(out=tmp_path / "back.toml")).rig
    assert load_rig(back).effects[0].file.resolve() == tmp_path / "oily.py"
    assert tomllib.loads(back.read_text(encoding="utf-8"))["effects"][0]["file"] == "oily.py"


def test_a_value_at_its_bound_is_not_rounded_beyond_it(rig, diagnosed):
    at_bound = FittedParameter("depth", "m", 4.99999996e-6, 4e-6, 5e-6, 0.0, 0.0, 4.99999997e-6)
    VERDICT_JSON.write(
        diagnosed / "diagnosis.json", verdict(candidates=(replace(candidate("edge_gap"), parameters=(at_bound,)),))
    )
    assert effects_of(add(rig, ["edge_gap"], diagnosed).rig) == {"edge_gap": {"depth": 4.99999996e-6}}


def test_the_calibration_comes_along_when_asked_for(rig, diagnosed):
    fitted = tuple(Calibrated(name, "", 1.0, 0.3, after, 0.9 * after, 1.1 * after) for name, after in
                   (("sliding_friction", 0.9), ("preload", 1.05)))  # fmt: skip
    VERDICT_JSON.write(diagnosed / "diagnosis.json", verdict(calibration=fitted))
    result = updamp("add", rig, "--from", diagnosed, "--with-calibration", "--debug")
    assert result.exit_code == 0, result.output
    new = rig.with_name("rig+shaker_attachment.toml")
    assert load_rig(new).calibration.factors == {"sliding_friction": 0.9, "preload": 1.05}
    assert "fitted together with shaker_attachment to test/measurement.toml, 2026-11-20" in new.read_text()
    again = add(new, (), diagnosed, AddOptions(new, replace=True, with_calibration=True)).rig
    assert load_rig(again).calibration.factors["sliding_friction"] == pytest.approx(0.81), "found about what was there"
    changed = remove(new, ["shaker_attachment"])
    assert "calibration stays" in changed.notes[0]
    assert not load_rig(remove(changed.rig, ["calibration"]).rig).calibration
    with pytest.raises(ValueError, match="it was fitted together with shaker_attachment; add just that"):
        add(rig, ["edge_gap"], diagnosed, AddOptions(with_calibration=True))


def test_a_factor_by_its_earlier_name_is_taken_over_under_the_present_one(rig, diagnosed):
    fitted = (Calibrated("friction_coefficient", "", 1.0, 0.3, 0.9, 0.8, 1.0),)
    VERDICT_JSON.write(diagnosed / "diagnosis.json", verdict(calibration=fitted))
    new = add(rig, (), diagnosed, AddOptions(with_calibration=True)).rig
    assert load_rig(new).calibration.factors == {"sliding_friction": 0.9}


# --- refusals ---


@pytest.mark.parametrize(
    ("names", "says"),
    [
        (["edge_gab"], "edge_gab: .*diagnosis.json has no such effect; did you mean edge_gap?"),
        (["wire_stiffness"], r"wire_stiffness: not refitted in .*\(score below 3\).*fitted were shaker_attachment"),
        (["shaker_attachment"], "has it already .mass 1 kg.*give --replace, to take it off: updamp remove"),
        (["oily"], "oily: neither in the catalogue nor in the rig file; name the Python file that defines it: --file"),
    ],
)
def test_what_cannot_be_added_is_said_with_what_to_do(rig, diagnosed, names, says):
    stated = '\n[[effects]]\nname = "shaker_attachment"\nvalues = { mass = "1 kg" }\n'
    rig.write_text(rig.read_text(encoding="utf-8") + stated, encoding="utf-8")
    before = sorted(rig.parent.iterdir())
    with pytest.raises(ValueError, match=says):
        add(rig, names, diagnosed)
    assert sorted(rig.parent.iterdir()) == before


def test_all_problems_are_told_at_once_and_cleanly(rig, diagnosed):
    result = updamp("add", rig, "edge_gab", "wire_stiffness", "--from", diagnosed, "--with-calibration")
    assert result.exit_code == 2
    assert len(result.output.splitlines()) == 3
    assert "Traceback" not in result.output


def test_no_diagnosis_no_folder_and_a_name_that_is_taken(rig, diagnosed, tmp_path):
    result = updamp("add", rig, "edge_gap", "--from", tmp_path / "nowhere")
    assert result.exit_code == 2
    assert f"no such file; make it with: updamp diagnose {rig} MEASUREMENT --out" in result.output
    assert "--from: missing" in updamp("add", rig, "edge_gap").output
    add(rig, ["edge_gap"], diagnosed)
    with pytest.raises(ValueError, match=r"rig\+edge_gap.toml: is there already; give another name with --out, or --r"):
        add(rig, ["edge_gap"], diagnosed)
    add(rig, ["edge_gap"], diagnosed, AddOptions(replace=True))
    with pytest.raises(ValueError, match=r"blade_mistuning is not there; it has edge_gap"):
        remove(rig.with_name("rig+edge_gap.toml"), ["blade_mistuning"])
    with pytest.raises(ValueError, match="it has no effects"):
        remove(rig, ["edge_gap"])


def test_a_file_that_could_not_be_read_back_is_not_written(rig, diagnosed):
    outside = FittedParameter("depth", "m", 1e-3, 0.0, 1.0, 0.0, 0.0, 1.0)  # of a catalogue with wider bounds
    VERDICT_JSON.write(
        diagnosed / "diagnosis.json", verdict(candidates=(replace(candidate("edge_gap"), parameters=(outside,)),))
    )
    with pytest.raises(RigError, match=r"rig\+edge_gap.toml:\neffects\[0\].values.depth = .0.001 m.: out of range"):
        add(rig, ["edge_gap"], diagnosed)
    assert [path.name for path in rig.parent.iterdir() if path.is_file()] == ["rig.toml"]


def test_what_a_diagnosis_did_not_accept_is_added_with_a_note(rig, diagnosed):
    group = ("shaker_attachment", "blade_mistuning")
    VERDICT_JSON.write(diagnosed / "diagnosis.json", verdict(verdict="inseparable", group=group))
    alone = add(rig, ["shaker_attachment"], diagnosed).notes
    assert alone == ("the data cannot tell shaker_attachment from blade_mistuning",)
    notes = add(rig, ["blade_mistuning", "shaker_attachment"], diagnosed).notes
    assert notes[0] == "blade_mistuning was not accepted by the diagnosis: no gain on held-out data"
    assert notes[1] == "the data cannot tell blade_mistuning and shaker_attachment apart: take one of them off"


# --- history ---


def test_the_history_goes_along_with_its_errors(rig, diagnosed):
    one = add(rig, ["shaker_attachment"], diagnosed).rig
    two = add(one, ["edge_gap"], diagnosed).rig
    three = remove(two, ["edge_gap"]).rig
    first, second, third = read_history(three).steps
    assert read_history(one).steps == (first,)
    assert first.before == Errors(5.0, 4.0)
    assert first.after == Errors(1.1, 1.3)
    assert (first.repeatability, first.day, first.measurement) == (1.0, "2026-11-20", "test/measurement.toml")
    assert (first.rig, first.parent) == ("rig+shaker_attachment.toml", "rig.toml")
    assert len(first.data) == 64
    assert second.before == first.after
    assert np.isnan([second.after.fit, second.after.held_out]).all(), "the diagnosis did not make this step"
    assert second.effects == ("shaker_attachment", "edge_gap")
    assert third.kind == "removed"
    assert third.after == first.after
    assert not history_file(rig).exists()
    alone = add(rig, ["edge_gap"], diagnosed).step
    assert np.isnan(alone.after.fit)
    assert alone.after.held_out == pytest.approx(4.0 * 0.9), "its own refit tells what it gained on held-out data"


def test_steps_of_the_diagnosis_give_the_errors_of_several_effects(rig, diagnosed):
    steps = (Step((), 5.0, 4.0), Step(("edge_gap",), 3.0, 2.5), Step(("edge_gap", "shaker_attachment"), 1.2, 1.4))
    VERDICT_JSON.write(diagnosed / "diagnosis.json", verdict(("edge_gap", "shaker_attachment"), history=steps))
    assert add(rig, ["edge_gap"], diagnosed).step.after == Errors(3.0, 2.5)
    both = add(rig, (), diagnosed).step
    assert (both.before, both.after) == (Errors(5.0, 4.0), Errors(1.2, 1.4))


def test_the_history_is_shown_and_drawn(rig, diagnosed, tmp_path):
    assert "no history yet; it begins with: updamp add" in updamp("history", rig).output
    two = add(add(rig, ["shaker_attachment"], diagnosed).rig, ["edge_gap"], diagnosed).rig
    picture = tmp_path / "picture.png"
    result = updamp("history", two, "--picture", picture, "--debug")
    assert result.exit_code == 0, result.output
    cells = [[cell.strip() for cell in line.split("│")] for line in result.output.splitlines()]
    (row,) = [row for row in cells if "+ shaker_attachment" in row]
    assert row[3:6] == ["5 → 1.1", "4 → 1.3", "1"]
    colours = np.array(Image.open(picture).convert("RGB")).reshape(-1, 3)
    green = (np.abs(colours - np.array([0, 158, 115])).max(axis=1) < 12).sum()
    assert green > 2000, "bars that fall"


# --- what a person does next ---

BEAM = """
title = "Beam with a heavy shaker"
rig = "brake_reuss"
damper_load = "0 N"
excitation = "beam.drive.x"

[channels]
force = { point = "beam.drive", direction = "x", quantity = "force", unit = "N", amplitude = "peak" }
laser = { point = "beam.drive", direction = "x", quantity = "displacement", unit = "m", amplitude = "peak" }

[[runs]]
name = "low"
mode = "first bending"
file = "sweep.csv"
sweep = "up"
held = "force"
level = "1 N"
repeat = 1
"""
MASS = 0.3


@pytest.fixture
def beam(tmp_path: Path) -> tuple[Path, Path]:
    """The beam's rig file, and a test of it with a mass at the shaker that no calibration may follow."""
    rig = tmp_path / "beam.toml"
    rig.write_text((RIGS / "brake_reuss.toml").read_text(encoding="utf-8"), encoding="utf-8")
    rng = np.random.default_rng(0)
    f0 = 80.38 / np.sqrt(1 + MASS / 2.0)
    f = np.linspace(f0 - 0.8, f0 + 0.8, 41)
    w, w0 = 2 * np.pi * f, 2 * np.pi * 80.38
    x = 1 / (2.0 * (w0**2 * (1 + 0.0031j) - w**2) - MASS * w**2)
    x = x * (1 + 0.005 / np.sqrt(2) * (rng.standard_normal(41) + 1j * rng.standard_normal(41)))
    rows = [f"low,1,up,{a!r},force,1,1.0,0.0\nlow,1,up,{a!r},laser,1,{y.real!r},{y.imag!r}" for a, y in
            zip(f.tolist(), x.tolist(), strict=True)]  # fmt: skip
    head = "run,repeat,sweep,frequency_Hz,channel,harmonic,real,imag"
    (tmp_path / "sweep.csv").write_text("\n".join([head, *rows]) + "\n", encoding="utf-8")
    (tmp_path / "measurement.toml").write_text(BEAM, encoding="utf-8")
    return rig, tmp_path / "measurement.toml"


def test_compare_shows_the_smaller_error_and_adds_it_to_the_history(beam, diagnosed, tmp_path):
    rig, measurement = beam
    fitted = verdict(candidates=(candidate("shaker_attachment", 0.6, mass=MASS),))
    VERDICT_JSON.write(diagnosed / "diagnosis.json", fitted)
    new = add(rig, ["shaker_attachment"], diagnosed).rig
    errors = {}
    for path in (rig, new, new):
        result = updamp("compare", path, measurement, "--out", tmp_path / path.stem, "--debug")
        assert result.exit_code == 0, result.output
        found = COMPARISON_JSON.read(tmp_path / path.stem / "comparison.json")
        errors[path] = np.sqrt(found.chi2_after / found.values)
    assert found.provenance["effects of the rig file"] == "shaker_attachment"
    assert errors[new] < 1.2
    assert errors[rig] > 5 * errors[new]
    assert not history_file(rig).exists(), "a rig file without effects gets no file beside it"
    added, compared = read_history(new).steps
    assert (added.kind, compared.kind) == ("added", "compared")
    assert compared.after.fit == pytest.approx(errors[new])
    assert compared.effects == ("shaker_attachment",)
    assert load_modal(new).effects[0].values["mass"] == MASS


def test_run_takes_the_new_file_and_traces_curves_only(rig, diagnosed, tmp_path):
    short = around_first_stuck_mode(rig, 0.8)
    text = rig.read_text(encoding="utf-8")
    of_oop = '["433 Hz", "451 Hz"]'
    assert of_oop in text
    text = text.replace(of_oop, f'["{short[0]}", "{short[1]}"]').replace("= 128", "= 64")
    rig.write_text(text.replace('law = "jenkins_box"', 'law = "jenkins_box_sampled"'), encoding="utf-8")

    def must_not_run(*_):
        raise AssertionError("this stage has to come from its file")

    def run(path, functions, **options):
        wanted = RunOptions("small", tmp_path / "out", modes=("OOP",), forces=(0.1,), check=False, **options)
        made = Run(load_rig(path), wanted, Display(Console(file=io.StringIO())), functions)
        return made, made.products()

    run(rig, StageFunctions(blade=plain_blade, damper=plain_damper), until=STATIC_CONTACT)
    heavy = candidate("shaker_attachment", 0.6, mass=1.0, dashpot=1000.0)
    VERDICT_JSON.write(diagnosed / "diagnosis.json", verdict(candidates=(heavy,)))
    new = add(rig, ["shaker_attachment"], diagnosed).rig
    again, done = run(new, StageFunctions(*5 * [must_not_run]))
    assert again.executed == ["OOP 0.1 N"]
    assert done.failures == ()
    curve = store.read(tmp_path / "out" / "stages" / "curve_OOP_0.1N.h5", ResponseCurve)
    assert curve.complete


def test_an_effect_whose_file_is_gone_can_be_taken_off(rig, tmp_path):
    """Nothing else could be done with the rig file either."""
    own = tmp_path / "oily.py"
    own.write_text(OWN, encoding="utf-8")
    table = '\n[[effects]]\nname = "oily"\nfile = "oily.py"\nvalues = { factor = 0.5 }\n'
    before = rig.read_text(encoding="utf-8")
    rig.write_text(before + table, encoding="utf-8")
    assert effects_of(rig) == {"oily": {"factor": 0.5}}
    own.unlink()
    with pytest.raises(RigError, match="no such file"):
        remove(rig, ("edge_gap",))
    assert remove(rig, ("oily",)).rig.read_text(encoding="utf-8") == before


# --- effects that were fitted together ---


def explained(*effects: tuple[str, str, float], misfit: float) -> Explanation:
    """effects: name, parameter, value"""
    fitted = tuple(FittedEffect(name, candidate(name, **{p: value}).parameters) for name, p, value in effects)
    return Explanation(tuple(name for name, _, _ in effects), 0.4, misfit, 1.2 * misfit, fitted)


TOGETHER = (
    explained(("shaker_attachment", "mass", 0.2), ("edge_gap", "depth", 1e-7), misfit=0.9),
    explained(("shaker_attachment", "mass", 0.5), misfit=1.1),
)


def test_effects_take_the_values_of_the_fit_with_just_these(rig, diagnosed):
    """They had those of a fit each, and errors that nobody knew."""
    VERDICT_JSON.write(diagnosed / "diagnosis.json", verdict(effects=(), explanations=TOGETHER))
    both = add(rig, ("edge_gap", "shaker_attachment"), diagnosed)
    assert effects_of(both.rig)["edge_gap"] == {"depth": 1e-7}
    assert effects_of(both.rig)["shaker_attachment"]["mass"] == 0.2
    assert both.step.after == Errors(0.9, pytest.approx(1.08))
    assert not any("fitted together" in note for note in both.notes)
    alone = add(rig, ("shaker_attachment",), diagnosed)
    assert effects_of(alone.rig)["shaker_attachment"]["mass"] == 0.5
    assert alone.step.after.fit == 1.1
    # what the rig file has is of another fit then
    second = add(alone.rig, ("edge_gap",), diagnosed)
    assert effects_of(second.rig)["edge_gap"] == {"depth": 1e-7}
    assert effects_of(second.rig)["shaker_attachment"]["mass"] == 0.5
    assert (second.step.before.fit, second.step.after.fit) == (1.1, 0.9)
    assert any("shaker_attachment stays as the rig file has it" in note for note in second.notes)


def test_effects_that_were_not_fitted_together_are_said_to_be_of_fits_of_their_own(rig, diagnosed):
    VERDICT_JSON.write(diagnosed / "diagnosis.json", verdict(explanations=TOGETHER))
    changed = add(rig, ("edge_gap", "blade_mistuning"), diagnosed)
    assert effects_of(changed.rig) == {"edge_gap": {"depth": 3e-7}, "blade_mistuning": {"difference": 0.01}}
    assert any("edge_gap and blade_mistuning were not fitted together" in note for note in changed.notes)
