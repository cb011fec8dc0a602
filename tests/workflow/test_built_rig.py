"""A rig built once more for each dimension: in folders of their own, only what the dimension touches, and only once."""

from io import StringIO
from pathlib import Path

import numpy as np
import pytest
from rich.console import Console
from support.plain_rig import TINY, plain_blade, plain_damper
from typer.testing import CliRunner

from updamp.effects.dimension_blend import blended
from updamp.model.rig_files import load_rig
from updamp.pipeline import app
from updamp.rig.dimensions import DIMENSIONS
from updamp.rig.errors import RigError
from updamp.workflow import built_rig as module
from updamp.workflow import stages
from updamp.workflow.built_rig import BuiltRig, chosen_dimensions
from updamp.workflow.progress import Display
from updamp.workflow.run import Run
from updamp.workflow.run_options import RunOptions
from updamp.workflow.stage_functions import StageFunctions

RIG = Path(__file__).parents[2] / "rigs" / "virtual_rig.toml"
PRESETS = {"mesh.tiny": TINY, "mesh.wider": {**TINY, "width": 6}, "mesh.patches": {**TINY, "contact_elements": 80}}
QUICK = StageFunctions(blade=plain_blade, damper=plain_damper)


def built(
    folder: Path, preset: str = "tiny", functions: StageFunctions = QUICK, **changes: object
) -> tuple[BuiltRig, StringIO]:
    said = StringIO()
    rig = load_rig(RIG, {**PRESETS, **changes})
    options = RunOptions(preset, folder, check=False, until=stages.STATIC_CONTACT)
    return BuiltRig(Run(rig, options, Display(Console(file=said, width=200)), functions)), said


def stages_in(folder: Path) -> set[str]:
    return {path.stem for path in (folder / "stages").iterdir()}


def test_each_has_a_folder_and_is_built_once(tmp_path: Path) -> None:
    first, _ = built(tmp_path)
    found = first.varied(tuple(DIMENSIONS))
    assert list(found) == list(DIMENSIONS)
    assert {varied.step for varied in found.values()} == {0.02}
    assert {path.name for path in (tmp_path / "dimensions").iterdir()} == {f"{name}+0.02" for name in DIMENSIONS}

    def must_not_run(*_: object) -> None:
        raise AssertionError("this is known")

    again, said = built(tmp_path, functions=StageFunctions(*5 * [must_not_run]))
    for name, varied in again.varied(tuple(DIMENSIONS)).items():
        assert np.array_equal(varied.stiffening, found[name].stiffening)
    assert "done" not in said.getvalue()


def test_what_a_dimension_leaves_alone_is_not_built_again(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    runs: list[Run] = []

    def noted(*arguments: object) -> Run:
        runs.append(Run(*arguments))
        return runs[-1]

    monkeypatch.setattr(module, "Run", noted)
    one, _ = built(tmp_path)
    _ = one.model
    one.varied(("blade_thickness", "face_length"))
    thickness, length = (set(run.executed) for run in runs)
    assert "damper" not in thickness
    assert {"blade", "mesh"} <= thickness
    assert {"blade", "damper"} <= length
    assert stages_in(tmp_path / "dimensions" / "blade_thickness+0.02") == stages_in(tmp_path)


def test_another_step_is_taken_where_contact_elements_would_lie_otherwise_or_nothing_can_be_built(
    tmp_path: Path,
) -> None:
    one, _ = built(tmp_path / "patches", "patches")
    assert one.varied(("face_length",))["face_length"].step == -0.02
    # of the underside 22.8 % of a millimetre are left: the damper would not fit between the blades
    rig = load_rig(RIG)
    most = rig.underside_length - rig.damper.face_start
    tight, _ = built(tmp_path / "tight", **{"damper.face_length": f"{1e3 * most / 1.01:.4f} mm"})
    assert tight.varied(("face_length",))["face_length"].step == -0.02


def test_a_finer_mesh_takes_over_and_other_contact_elements_are_built(tmp_path: Path) -> None:
    coarse, _ = built(tmp_path)
    varied = coarse.varied(("face_length",))
    finer, _ = built(tmp_path / "wider", "wider")
    assert finer.varied_as(coarse, varied)["face_length"].step == 0.02
    assert not (tmp_path / "wider" / "dimensions").exists()
    patches, _ = built(tmp_path / "patches", "patches")
    own = patches.varied_as(coarse, varied)["face_length"]
    assert (tmp_path / "patches" / "dimensions").is_dir()
    assert len(own.growth["kt"]) == 80
    model = patches.before_effects({"face_length": own})
    np.testing.assert_allclose(
        blended(model, own, -0.02).contacts.parameters.kt, 0.98 * model.contacts.parameters.kt, rtol=1e-9
    )


def test_names_are_checked() -> None:
    assert chosen_dimensions(None) == tuple(DIMENSIONS)
    assert chosen_dimensions(()) == ()
    with pytest.raises(ValueError, match="--dimensions width: there are face_length"):
        chosen_dimensions(("width",))
    shown = CliRunner().invoke(app, ["diagnose", "--help"], env={"COLUMNS": "200"}).output
    assert "--dimensions" in shown


def test_a_rig_file_states_a_dimension_where_it_stands() -> None:
    """What `updamp add` runs into too, since it reads what it has written."""
    effect = {"name": "face_length", "values": {"change": 0.021}}
    with pytest.raises(
        RigError, match=r'write damper.face_length = "4.7252 mm" in place of damper.face_length = "4.628'
    ):
        load_rig(RIG, {"effects": [effect]})
    angle = {"name": "face_angle", "values": {"change": -0.05}}
    with pytest.raises(RigError, match=r'platform.underside_angle = "19 deg"'):
        load_rig(RIG, {"effects": [angle]})
    assert load_rig(RIG, {"effects": [{"name": "face_length", "values": {"change": 0.0}}]}).effects
