"""Studies may vary a damper's own material by its path, where the rig file states one."""

from pathlib import Path

import pytest
from support.study_runs import run

from updamp.design.outputs import write_outputs
from updamp.design.study_file import StudyError, read_study
from updamp.model.rig_files import load_rig
from updamp.parameter_study.study_file import read_parameter_study
from updamp.rig.damper_mass import damper_mass
from updamp.workflow.rig_text import with_values

RIG = Path(__file__).parents[1] / "data" / "short_faces.toml"
TABLE = """
[damper.material]
youngs_modulus = "114 GPa"
poissons_ratio = 0.33
density = "4430 kg/m^3"
loss_factor = 0.0005
"""
STUDY = """
[study]
rig = "rig.toml"
mesh = "small"
out = "out"

[[variables]]
name = "density"
path = "damper.material.density"
lower = "2 g/cm^3"
upper = "8 g/cm^3"

[[responses]]
name = "mass"
kind = "damper_mass"

[method]
kind = "grid"
points = 2
"""
VARIANT = """
[study]
rig = "rig.toml"
out = "out"

[[variants]]
name = "heavy"
changes = { "damper.material.density" = "8 g/cm^3" }

[[families]]
name = "mass"
title = "Mass"
variants = ["heavy"]
"""


def folder_with(folder: Path, table: str) -> Path:
    (folder / "rig.toml").write_text(RIG.read_text() + table)
    (folder / "study.toml").write_text(STUDY)
    (folder / "variants.toml").write_text(VARIANT)
    return folder


def test_the_density_of_the_damper_is_varied(tmp_path):
    folder = folder_with(tmp_path, TABLE)
    (variable,) = read_study(folder / "study.toml").variables
    assert (variable.unit, variable.initial) == ("g/cm^3", 4.43)
    result = run(folder / "study.toml")
    write_outputs(result)
    light, heavy = result.records
    assert heavy.responses["mass"] == pytest.approx(4 * light.responses["mass"])
    mass = 1e3 * damper_mass(load_rig(folder / "rig.toml"))
    assert light.responses["mass"] == pytest.approx(mass * 2000 / 4430)


def test_the_rig_of_a_design_has_it_in_its_table(tmp_path):
    folder = folder_with(tmp_path, TABLE)
    path = folder / "other.toml"
    path.write_text(with_values((folder / "rig.toml").read_text(), {"damper.material.density": "8.0 g/cm^3"}))
    before, after = load_rig(folder / "rig.toml"), load_rig(path)
    assert after.damper_material.density == 8000
    assert after.damper.dimensions == before.damper.dimensions
    assert after.material == before.material


def test_a_study_of_a_rig_that_states_none_says_what_to_add(tmp_path):
    folder = folder_with(tmp_path, "")
    with pytest.raises(StudyError) as refused:
        read_study(folder / "study.toml")
    assert (
        'path = "damper.material.density": damper.material.density: the rig file has no table [damper.material]; '
        "add it there, with all its keys"
    ) in str(refused.value)


def test_a_parameter_study_takes_the_path_too_and_says_what_is_missing(tmp_path):
    folder = folder_with(tmp_path, TABLE)
    (variant,) = read_parameter_study(folder / "variants.toml").variants
    assert load_rig(folder / "rig.toml", variant.changes).damper_material.density == 8000
    folder_with(tmp_path, "")
    with pytest.raises(StudyError) as refused:
        read_parameter_study(folder / "variants.toml")
    assert "damper.material.youngs_modulus: missing; add it" in str(refused.value)
