"""What would run again is what the stages' keys say, and each reason names its input."""

from pathlib import Path

import pytest
from typer.testing import CliRunner

from updamp.model.rig_files import load_rig
from updamp.pipeline import app
from updamp.workflow import stages
from updamp.workflow.explain import explain, other_changes

RIG = Path(__file__).parents[2] / "rigs" / "pesaresi2017.toml"
CHANGES = {
    "contact.friction_coefficient": 0.4,
    "contact.normal_stiffness": "50000 N/mm^3",
    "damper.face_length": "4.5 mm",
    "damper.base_height": "2.5 mm",
    "blade.thickness": "7.2 mm",
    "material.loss_factor": 0.002,
    "study.modes.OOP.window": ["430 Hz", "450 Hz"],
    "mesh.small.face": 5,
    "mesh.full.face": 8,
    "effects": [{"name": "edge_gap", "values": {"depth": "0.3 um"}}],
    "name": "other",
    "damper.material": {
        "youngs_modulus": "114 GPa",
        "poissons_ratio": 0.33,
        "density": "4430 kg/m^3",
        "loss_factor": 0.0005,
    },
}


@pytest.mark.parametrize("path", CHANGES)
def test_a_stage_runs_again_exactly_where_its_key_is_another(path):
    old, new = load_rig(RIG), load_rig(RIG, {path: CHANGES[path]})
    told = {one.name: one for one in explain(new, old, "small")}
    for stage in stages.STAGES:
        for mode in new.study.modes if stage is stages.CURVE else ("",):
            choice = {"preset": "small", "mode": mode, "force": "1.0"}
            differs = stage.key(new, choice) != stage.key(old, choice)
            assert told[f"{stage.name} {mode}".strip()].again == differs, (stage.name, mode)


def test_the_reason_names_the_input_with_both_values():
    old, new = load_rig(RIG), load_rig(RIG, {"contact.friction_coefficient": 0.4, "name": "other"})
    told = {one.name: one.because for one in explain(new, old, "small")}
    assert told["static_contact"] == "contact.friction_coefficient: 0.6 -> 0.4"
    assert told["curve IP"] == "contact.friction_coefficient: 0.6 -> 0.4, static_contact runs again"
    assert told["finite_elements"] == ""
    assert [one.path for one in other_changes(new, old, explain(new, old, "small"))] == ["name"]


def test_a_further_force_is_a_curve_more_and_the_resonance_anew():
    old = load_rig(RIG, {"study.force_levels": ["1 N", "4 N"]})
    new = load_rig(RIG, {"study.force_levels": ["0.5 N", "4 N"]})
    told = {one.name: one for one in explain(new, old, "small")}
    assert told["curve OOP"].because == "study.force_levels: [1, 4] -> [0.5, 4], at [0.5] alone"
    assert told["resonance IP"].again
    assert not told["static_contact"].again
    fewer = {one.name: one for one in explain(load_rig(RIG, {"study.force_levels": ["4 N"]}), old, "small")}
    assert not fewer["curve OOP"].again
    assert fewer["resonance OOP"].again


def test_a_change_of_the_damper_leaves_the_blade_alone():
    old, new = load_rig(RIG), load_rig(RIG, {"damper.base_height": "2.5 mm"})
    told = {one.name: one for one in explain(new, old, "small")}
    assert not told["blade"].again
    assert told["damper"].because == "damper.base_height: 0.003 -> 0.0025"
    assert told["finite_elements"].because == "damper runs again"


@pytest.mark.parametrize("key", ["density", "loss_factor"])
@pytest.mark.parametrize("table", ["material", "damper.material"])
def test_each_material_is_told_where_it_enters(table, key):
    own = {"damper.material": CHANGES["damper.material"]}
    change = {f"{table}.{key}": {"density": "5000 kg/m^3", "loss_factor": 0.003}[key]}
    old, new = load_rig(RIG, own), load_rig(RIG, {**own, **change})
    told = {one.name: one for one in explain(new, old, "small")}
    for stage in stages.STAGES[:-1]:
        choice = {"preset": "small"}
        assert told[stage.name].again == (stage.key(new, choice) != stage.key(old, choice)), stage.name
    named = {name for name, one in told.items() if f"{table}.{key}" in [change.path for change in one.changes]}
    body = {"material": "blade", "damper.material": "damper"}[table]
    assert named == ({body} if key == "density" else {"curve OOP", "curve IP", "resonance OOP", "resonance IP"})


def test_an_effect_that_is_new_is_named():
    old, new = load_rig(RIG), load_rig(RIG, {"effects": CHANGES["effects"]})
    told = {one.name: one.because for one in explain(new, old, "small")}
    assert "effects.edge_gap.depth: not stated -> 3e-07" in told["curve OOP"]
    assert not [part for part in told["curve OOP"].split(", ") if part.endswith("-> ")], told["curve OOP"]


def test_a_key_that_is_not_set_is_no_change():
    """The polynomial of the reference rig has a `map` that may be stated in place of its coefficients."""
    old, new = load_rig(RIG), load_rig(RIG, {"contact.pressure": {"model": "uniform"}})
    one_way = [change.path for verdict in explain(new, old, "small") for change in verdict.changes]
    back = [change.path for verdict in explain(old, new, "small") for change in verdict.changes]
    for paths in (one_way, back):
        assert "contact.pressure.model" in paths
        assert "contact.pressure.map" not in paths


def test_the_command_says_so(tmp_path):
    other = tmp_path / "other.toml"
    other.write_text(RIG.read_text().replace("friction_coefficient = 0.6", "friction_coefficient = 0.4"))
    result = CliRunner().invoke(app, ["explain", str(other), "--against", str(RIG), "--mesh", "small"])
    assert result.exit_code == 0, result.output
    assert "runs again" in result.output
    beam = RIG.with_name("brake_reuss.toml")
    for pair in ((beam, RIG), (RIG, beam)):
        given_by_modes = CliRunner().invoke(app, ["explain", str(pair[0]), "--against", str(pair[1])])
        assert given_by_modes.exit_code == 2
        assert "brake_reuss.toml: gives modes, not dimensions, so there is nothing to mesh" in given_by_modes.output
        assert "missing" not in given_by_modes.output
    refused = CliRunner().invoke(app, ["explain", str(other), "--against", str(RIG), "--mesh", "tiny"])
    assert refused.exit_code == 2
    assert "--mesh tiny: the rig pesaresi2017 has small, medium, full" in refused.output
