"""Which stages run again after which change of the rig file."""

from pathlib import Path

import pytest

from updamp.model.rig_files import load_rig
from updamp.workflow import stages

RIG = Path(__file__).parents[2] / "rigs" / "pesaresi2017.toml"
ALL = {"mesh", "finite_elements", "coupled_check", "static_contact", "curve"}
AFTER_THE_MESH = ALL - {"mesh"}


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
        ({"excitation.height": "19 mm"}, ALL),
        ({"response.below_top": "25 mm"}, ALL),
        ({"blade.thickness": "7.4 mm"}, ALL),
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


def test_every_curve_has_its_own_key():
    assert changed(keys(), keys(force="17.0")) == {"curve"}
    assert changed(keys(), keys(mode="IP")) == {"curve"}


def test_another_preset_is_another_mesh():
    assert changed(keys(), keys(preset="medium")) == ALL


def test_a_new_version_of_a_stage_runs_it_and_what_follows(monkeypatch):
    before = keys()
    newer = stages.Stage(**{**stages.STATIC_CONTACT.__dict__, "version": stages.STATIC_CONTACT.version + 1})
    curve = stages.Stage(**{**stages.CURVE.__dict__, "after": (newer,)})
    monkeypatch.setattr(stages, "STAGES", (*stages.STAGES[:3], newer, curve))
    assert changed(before, keys()) == {"static_contact", "curve"}
