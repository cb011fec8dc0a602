"""The rig file of one design of a study: the study's rig with the design's values, its windows moved with the modes."""

import json
from collections.abc import Iterator, Mapping
from dataclasses import replace
from pathlib import Path
from typing import Any

from updamp.design.records import Record, read_record
from updamp.design.rig_numbers import AnyRig
from updamp.design.run_study import StudyFolder
from updamp.design.solved_design import DesignInput, SolvedDesign, window_change
from updamp.design.study_json import STUDY_JSON
from updamp.design.tracked_modes import ModeReference, mode_references
from updamp.design.variables import Variable, overrides
from updamp.effects.rig_model import RigModel
from updamp.model.rig_files import is_modal, load_any
from updamp.rig.toml_file import read_toml
from updamp.workflow.rig_text import EffectText, moved, with_effect, with_values


def write_design_rig(path: Path, number: int, out: Path, overwrite: bool = False) -> None:
    """path: folder of a study; number: of the design; out: the new rig file

    raises: ValueError where there is no such study or design, the file is there already, or the design has no rig
    """
    folder = StudyFolder(path)
    study = _study(folder)
    record = read_record(folder.designs, number)
    if out.exists() and not overwrite:
        raise ValueError(f"{out}: is there already; give another name, or --replace")
    variables = [Variable(**stated) for stated in study["variables"]]
    if set(record.values) != {one.name for one in variables}:
        raise ValueError(f"{path}: design {number} has other variables than the study; take one of designs.csv")
    if record.setup != study.get("setup"):
        raise ValueError(
            f"{path}: design {number} is of another study (rig, mesh, units or responses); take one of designs.csv, or "
            "run updamp design again"
        )
    changes = overrides(read_toml(folder.rig, "a rig file"), variables, record.values)
    windows = _windows(folder, str(study["mesh"]), changes)
    text = moved(folder.rig.read_text(encoding="utf-8"), path, out.parent)
    out.parent.mkdir(parents=True, exist_ok=True)
    out.write_text(_with_changes(text, {**changes, **windows}, _origin(study, record)), encoding="utf-8")


def _study(folder: StudyFolder) -> Mapping[str, Any]:
    file = folder.path / STUDY_JSON
    if not file.is_file():
        raise ValueError(f"{file}: no such file; make it with: updamp design STUDY --out {folder.path}")
    study: Mapping[str, Any] = json.loads(file.read_text(encoding="utf-8"))
    return study


def _origin(study: Mapping[str, Any], record: Record) -> str:
    return f"design {record.number} of the study {study['study']}"


def _windows(folder: StudyFolder, mesh: str, changes: Mapping[str, Any]) -> dict[str, Any]:
    """Where the rig's modes have moved to, those too that no response is about; raises: what the stages raise for a
    design that cannot be built
    """
    if is_modal(folder.rig):
        return {}
    given = DesignInput(folder.rig, {}, mesh, folder.stages, ())
    references = tuple(_references(load_any(folder.rig), SolvedDesign(given).model))
    design = SolvedDesign(replace(given, changes=changes, references=references))
    windows: dict[str, Any] = {}
    for one in references:
        windows |= window_change(one.name, design.mode(one.name).window)
    return windows


def _references(rig: AnyRig, model: RigModel) -> Iterator[ModeReference]:
    """Of all modes whose window has one in the study's rig; where it has none there is nothing to move it with."""
    for name, window in rig.windows.items():
        try:
            yield from mode_references(model, {name: window}, rig.response_point)
        except ValueError:
            continue


def _with_changes(text: str, changes: Mapping[str, Any], origin: str) -> str:
    plain = {path: value for path, value in changes.items() if path != "effects"}
    text = with_values(text, plain)
    for table in changes.get("effects", ()):
        effect = EffectText(table["name"], table["values"], table.get("origin") or origin, table.get("file", ""))
        text = with_effect(text, effect)
    return f"# {origin[0].upper()}{origin[1:]}.\n{text}"
