"""Designs of a rig with geometry on the coarsest mesh: what is shared, what cannot be built, modes that move."""

import shutil
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from support.plain_rig import TINY_PRESET, plain_reduced_model
from support.study_runs import run

from updamp.design.design_rig import write_design_rig
from updamp.design.outputs import write_outputs
from updamp.design.shared_stages import SharedStages
from updamp.design.tracked_modes import mode_references, tracked_mode
from updamp.fem.finite_element_model import finite_element_model
from updamp.fem.static_contact.static_contact import static_contact
from updamp.geometry.build_mesh import build_mesh
from updamp.geometry.outlines import area, blade_outline, damper_outline
from updamp.model.build import rig_model
from updamp.model.rig_files import load_rig
from updamp.rig.damper_mass import damper_mass

RIG = Path(__file__).parents[1] / "data" / "short_faces.toml"

STUDY = """
[study]
rig = "rig.toml"
mesh = "tiny"
out = "out"

[[variables]]
name = "angle"
path = "platform.underside_angle"
lower = "20 deg"
upper = "70 deg"

[[variables]]
name = "mu"
path = "contact.friction_coefficient"
lower = 0.3
upper = 0.35

[[responses]]
name = "oop"
kind = "stuck_frequency"
mode = "OOP"

[[responses]]
name = "pressure"
kind = "largest_pressure"

[[responses]]
name = "mass"
kind = "damper_mass"

[[responses]]
name = "pressure_at_peak"
kind = "largest_pressure"
mode = "OOP"
force = "8 N"

[[responses]]
name = "friction_share"
kind = "energy_ratio"
mode = "OOP"
force = "8 N"

[[responses]]
name = "stuck"
kind = "contact_share"
mode = "OOP"
force = "8 N"
state = "stuck"

[[responses]]
name = "slipping"
kind = "contact_share"
mode = "OOP"
force = "8 N"
state = "slipping"

[[responses]]
name = "separated"
kind = "contact_share"
mode = "OOP"
force = "8 N"
state = "separated"

[method]
kind = "grid"
points = 2
"""


@pytest.fixture(scope="module")
def studied(tmp_path_factory):
    folder = tmp_path_factory.mktemp("rig_study")
    text = RIG.read_text().replace('window = ["432 Hz", "450 Hz"]', 'window = ["445 Hz", "460 Hz"]  # wide')
    (folder / "rig.toml").write_text(text + TINY_PRESET)
    (folder / "study.toml").write_text(STUDY)
    result = run(folder / "study.toml")
    write_outputs(result)
    return folder, result


def test_a_geometry_that_cannot_be_built_is_recorded_with_its_reason(studied):
    _, result = studied
    by_angle = {angle: [one for one in result.records if one.values["angle"] == angle] for angle in (20, 70)}
    assert [one.outcome for one in by_angle[20]] == ["done", "done"]
    for one in by_angle[70]:
        assert one.outcome == "failed"
        assert set(one.responses.values()) == {None}
        assert "must be below the junction of the platform's underside and the stem" in one.reason


def test_friction_alone_needs_no_finite_elements(studied):
    folder, result = studied
    executed = [one.executed for one in result.records if one.outcome == "done"]
    assert executed == [("static_contact", "peaks OOP")] * 2, "the finite elements are those of the rig as it stands"
    assert len(list((folder / "out" / "stages").glob("finite_elements_*.h5"))) == 1


def test_the_damper_alone_leaves_the_blade_alone(studied):
    folder, _ = studied
    shared = folder / "out" / "stages"
    blades = set(shared.glob("blade_*.h5"))
    lower = SharedStages(load_rig(folder / "rig.toml", {"damper.base_height": "2.5 mm"}), "tiny", shared)
    other = lower.finite_elements().reduced
    assert lower.executed == ["mesh", "damper", "finite_elements"]
    assert set(shared.glob("blade_*.h5")) == blades
    whole = finite_element_model(lower.mesh(), lower.rig).reduced
    for one, two in zip(other.components, whole.components, strict=True):
        np.testing.assert_allclose(one.omega, two.omega, rtol=1e-9)
        np.testing.assert_allclose(one.residual, two.residual, atol=1e-9 * np.abs(two.residual).max())


@pytest.mark.long
def test_a_response_that_is_added_later_finds_the_peak(studied):
    folder, result = studied
    added = '[[responses]]\nname = "at"\nkind = "resonance_frequency"\nmode = "OOP"\nforce = "8 N"\n\n[method]'
    (folder / "added.toml").write_text(STUDY.replace("[method]", added).replace("70 deg", "20.1 deg"))
    shutil.copytree(folder / "out", folder / "more")
    more = run(folder / "added.toml", out=folder / "more").records
    before = {tuple(one.values.values()): one for one in result.records}
    again = [one for one in more if tuple(one.values.values()) in before]
    assert len(again) == 2, "the designs at 20 degrees"
    for one in again:
        assert one.executed == (), "stages and peaks are in the common folder"
        assert one.responses["at"] == pytest.approx(one.responses["oop"], rel=0.05)
        old = before[tuple(one.values.values())].responses
        assert {name: one.responses[name] for name in old} == old


def test_contacts_at_the_peak_are_told_apart_and_friction_takes_its_share(studied):
    _, result = studied
    low, high = (one.responses for one in result.records if one.outcome == "done")
    for one in (low, high):
        assert one["stuck"] + one["slipping"] + one["separated"] == pytest.approx(1)
        assert 0 < one["friction_share"] < 1
        assert one["pressure_at_peak"] > one["pressure"] > 0
    assert low["friction_share"] > high["friction_share"]


def test_the_rig_file_of_a_design_has_its_values_and_the_rest_as_it_was(studied):
    folder, result = studied
    one = next(record for record in result.records if record.outcome == "done" and record.values["mu"] == 0.3)
    write_design_rig(folder / "out", one.number, folder / "new" / "design.toml")
    rig, text = load_rig(folder / "new" / "design.toml"), (folder / "new" / "design.toml").read_text()
    assert rig.contact.friction_coefficient == 0.3
    assert np.rad2deg(rig.platform.underside_angle) == pytest.approx(20)
    assert rig.study.modes["OOP"].window == pytest.approx((445, 460)), "the mode has not moved"
    assert text.startswith(f"# Design {one.number} of the study study.\n")
    assert "# of the underside, and so of the damper's faces, from the horizontal" in text, "comments stay"
    with pytest.raises(ValueError, match="no design 99; there are 1 to 4"):
        write_design_rig(folder / "out", 99, folder / "other.toml")
    with pytest.raises(ValueError, match="is there already"):
        write_design_rig(folder / "out", one.number, folder / "new" / "design.toml")


@pytest.fixture(scope="module")
def plain():
    rig = load_rig(RIG)
    reduced = plain_reduced_model(rig, build_mesh(rig, "small").contacts)
    return rig_model(reduced, static_contact(reduced, rig), rig)


def test_modes_are_recognised_by_their_shape_when_their_order_changes(plain):
    frequencies = plain.system.stuck.frequencies[:2]
    windows = {f"mode{i}": (f - 2, f + 2) for i, f in enumerate(frequencies)}
    references = mode_references(plain, windows, "blade_right.tip.x")
    stuck = plain.system.stuck
    for i, reference in enumerate(references):
        found = tracked_mode(stuck, reference)
        assert found.frequency == pytest.approx(frequencies[i])
        assert found.likeness == pytest.approx(1)
        assert found.window == pytest.approx(windows[reference.name])
    squared = stuck.omega_squared.copy()
    squared[0] *= 1.5**2
    moved = tracked_mode(replace(stuck, omega_squared=squared), references[0])
    assert moved.frequency == pytest.approx(1.5 * frequencies[0]), "now above the other one"
    assert moved.window == pytest.approx(tuple(1.5 * f for f in windows["mode0"]))


def test_a_window_without_a_mode_is_refused(plain):
    with pytest.raises(ValueError, match="no stuck mode between 1 and 2 Hz"):
        mode_references(plain, {"OOP": (1.0, 2.0)}, "blade_right.tip.x")


def test_the_outlines_have_the_volumes_of_the_mesh():
    rig = load_rig(RIG)
    mesh = build_mesh(rig, "small")
    for component, outline in ((mesh.blade, blade_outline(rig)), (mesh.damper, damper_outline(rig))):
        volume = area(outline) * rig.blade.width
        assert volume == pytest.approx(_volume(component.vertices[component.hexahedra]), rel=1e-9), component.name
    assert damper_mass(rig) == pytest.approx(rig.material.density * volume)


def _volume(corners):
    """(n, 8, 3): prisms on quadrilaterals; each is as long as its four edges along z, times the section's area."""
    section = corners[:, [0, 1, 2, 3]]
    flat = np.ptp(section[..., 2], axis=1).max() < 1e-12
    assert flat, "the first four corners lie in one section"
    x, y = section[..., 0], section[..., 1]
    areas = np.abs((x * np.roll(y, -1, axis=1) - y * np.roll(x, -1, axis=1)).sum(axis=1)) / 2
    return float((areas * np.abs(corners[:, 4, 2] - corners[:, 0, 2])).sum())
