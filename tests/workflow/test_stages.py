"""Which stages run again after which change of the rig file."""

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from updamp.geometry.build_mesh import build_mesh
from updamp.model.rig_files import load_rig
from updamp.workflow import stages

RIG = Path(__file__).parents[1] / "data" / "early_opening.toml"
ALL = {"mesh", "blade", "damper", "finite_elements", "coupled_check", "static_contact", "curve"}
AFTER_THE_MESH = ALL - {"mesh"}
BLADE_ALONE, DAMPER_ALONE = ALL - {"damper"}, ALL - {"blade"}


def keys(overrides=None, **choice):
    rig = load_rig(RIG, overrides)
    choice = {"preset": "small", "mode": "OOP", "force": "3.84", **choice}
    return {stage.name: stage.key(rig, choice) for stage in stages.STAGES}


def changed(a, b):
    return {name for name in a if a[name] != b[name]}


@pytest.mark.parametrize(
    ("override", "again"),
    [
        ({"contact.friction_coefficient": 0.5}, {"static_contact", "curve"}),
        ({"contact.pressure": {"model": "two_area", "central_share": 0.8, "central_fraction": 0.5}},
         {"static_contact", "curve"}),
        ({"contact.tangential_stiffness": "50000 N/mm^3"}, {"coupled_check", "curve"}),
        ({"contact.coupling": "nearest_node"}, AFTER_THE_MESH),
        ({"wire.axial_stiffness": "2e6 N/m"}, {"coupled_check", "curve"}),
        ({"load.pull": "900 N"}, {"coupled_check", "static_contact", "curve"}),
        ({"material.loss_factor": 0.002}, {"curve"}),
        ({"damper_model": "lumped"}, {"curve"}),
        ({"material.density": "7700 kg/m^3"}, AFTER_THE_MESH),
        ({"reduction.modes": 12}, AFTER_THE_MESH),
        ({"harmonic_balance.harmonics": [0, 1]}, {"curve"}),
        ({"excitation.blade": "left"}, {"curve"}),
        ({"excitation.height": "19 mm"}, BLADE_ALONE),
        ({"response.below_top": "25 mm"}, BLADE_ALONE),
        ({"blade.thickness": "7.4 mm"}, BLADE_ALONE),
        ({"mesh.small.stem_top": 4}, BLADE_ALONE),
        ({"damper.base_height": "2 mm"}, DAMPER_ALONE),
        ({"damper.apex_height": "0.5 mm"}, DAMPER_ALONE),
        ({"mesh.small.damper_across": 6}, DAMPER_ALONE),
        ({"damper.face_length": "4.5 mm"}, ALL),
        ({"platform.underside_angle": "31 deg"}, ALL),
        ({"blade.width": "14 mm"}, ALL),
        ({"mesh.small.width": 10}, ALL),
        ({"mesh.full.width": 42}, set()),
        ({"study.modes.OOP.window": ["430 Hz", "450 Hz"]}, {"curve"}),
        ({"study.modes.IP.window": ["360 Hz", "430 Hz"]}, set()),
        ({"study.force_levels": ["1 N"]}, set()),
        ({"name": "another"}, set()),
        ({"contact.friction_coefficient": 0.6, "load.pull": "0.96 kN"}, set()),
    ],
    ids=lambda value: ",".join(value) if isinstance(value, dict) else None,
)  # fmt: skip
def test_only_what_depends_on_a_change_runs_again(override, again):
    assert changed(keys(), keys(override)) == again


OWN = {"damper.material": {
    "youngs_modulus": "114 GPa", "poissons_ratio": 0.33, "density": "4430 kg/m^3", "loss_factor": 0.0005,
}}  # fmt: skip


@pytest.mark.parametrize(
    ("override", "again"),
    [
        ({"damper.material.density": "4500 kg/m^3"}, DAMPER_ALONE - {"mesh"}),
        ({"damper.material.youngs_modulus": "115 GPa"}, DAMPER_ALONE - {"mesh"}),
        ({"damper.material.poissons_ratio": 0.0}, DAMPER_ALONE - {"mesh"}),
        ({"damper.material.loss_factor": 0.001}, {"curve"}),
        ({"material.density": "7700 kg/m^3"}, BLADE_ALONE - {"mesh"}),
        ({"material.loss_factor": 0.002}, {"curve"}),
        ({"damper.base_height": "2 mm"}, DAMPER_ALONE),
    ],
)
def test_a_material_of_the_damper_alone_is_an_input_of_the_damper_alone(override, again):
    assert changed(keys(OWN), keys({**OWN, **override})) == again


def test_stating_a_material_of_the_damper_keeps_mesh_and_blade():
    assert changed(keys(), keys(OWN)) == DAMPER_ALONE - {"mesh"}


def test_keys_from_before_the_damper_could_have_a_material_still_hold():
    rig, choice = load_rig(RIG), {"preset": "small", "mode": "OOP", "force": "3.84"}
    for stage in stages.STAGES:
        before = replace(stage, instead=(), optional=())
        assert before.key(rig, choice) == stage.key(rig, choice)
    assert stages.DAMPER.read(rig, choice)[:3] == (
        "material.youngs_modulus",
        "material.poissons_ratio",
        "material.density",
    )


CHANGES = {
    "blade.height": "151 mm", "blade.thickness": "7.1 mm", "blade.width": "15.1 mm", "blade.axis_offset": "30.1 mm",
    "platform.top": "43.4 mm", "platform.gap": "4.1 mm", "platform.edge_thickness": "2.1 mm",
    "platform.underside_angle": "30.5 deg", "damper.face_start": "2.1 mm", "damper.face_length": "4.9 mm",
    "damper.apex_height": "0.5 mm", "damper.apex_flat": "3.1 mm", "damper.base_height": "3.1 mm",
    "excitation.height": "10.4 mm", "response.below_top": "21 mm",
    **{f"mesh.small.{name}": step for name, step in {
        "width": 14, "face": 5, "platform_outer": 3, "platform_inner": 2, "platform_height": 4, "stem_thickness": 3,
        "stem_below_excitation": 4, "stem_below_platform": 2, "stem_above_platform": 13, "stem_top": 4,
        "damper_across": 5, "damper_apex": 2, "damper_base": 2, "contact_elements": 74,
        "contact_strips": 4,
    }.items()},
}  # fmt: skip


@pytest.mark.parametrize("path", CHANGES)
def test_a_component_that_is_kept_has_the_same_mesh_and_contacts(path):
    """Whatever number of the geometry changes: where the key of a component is the same, so is what it is made from."""
    again = changed(keys(), keys({path: CHANGES[path]}))
    old, new = (build_mesh(load_rig(RIG, change), "small") for change in ({}, {path: CHANGES[path]}))
    for name in {"blade", "damper"} - again:
        one, other = getattr(old, name), getattr(new, name)
        for of in ("vertices", "hexahedra"):
            np.testing.assert_array_equal(getattr(one, of), getattr(other, of))
        assert one.points == other.points
        assert set(one.faces) == set(other.faces)
        for group in one.faces:
            np.testing.assert_array_equal(one.faces[group], other.faces[group])
        for of in ("triangle", "area", "tangent1", "normal"):
            np.testing.assert_array_equal(getattr(old.contacts, of), getattr(new.contacts, of))


def test_every_curve_has_its_own_key():
    assert changed(keys(), keys(force="17.0")) == {"curve"}
    assert changed(keys(), keys(mode="IP")) == {"curve"}


def test_another_preset_is_another_mesh():
    assert changed(keys(), keys(preset="medium")) == ALL


def test_a_new_version_of_a_stage_runs_it_and_what_follows(monkeypatch):
    before = keys()
    newer = stages.Stage(**{**stages.STATIC_CONTACT.__dict__, "version": stages.STATIC_CONTACT.version + 1})
    curve = stages.Stage(**{**stages.CURVE.__dict__, "after": (newer,)})
    monkeypatch.setattr(stages, "STAGES", (*stages.STAGES[:5], newer, curve))
    assert changed(before, keys()) == {"static_contact", "curve"}
