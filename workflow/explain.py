"""What a changed rig file would run again, and why: stage by stage, which of its inputs differ.

It compares two rig files by the sections that each stage reads (`workflow/stages.py`); no folder is looked at.
"""

from collections.abc import Iterator, Mapping, Sequence, Set
from dataclasses import dataclass
from typing import Any

from rich.table import Table

from updamp.rig.rig import APART, Rig
from updamp.workflow import stages

_ABSENT = "not stated"


@dataclass(frozen=True)
class Change:
    """One input. path: dotted; old, new: in SI, as text"""

    path: str
    old: str
    new: str


@dataclass(frozen=True)
class StageVerdict:
    """name: of the stage, with the mode of a curve; again: whether it would run again
    changes: of what it reads itself; after: names of earlier stages that run again, on whose products it depends"""

    name: str
    changes: tuple[Change, ...]
    after: tuple[str, ...]

    @property
    def again(self) -> bool:
        return bool(self.changes or self.after)

    @property
    def because(self) -> str:
        own = [f"{one.path}: {one.old} -> {one.new}" for one in self.changes]
        return ", ".join([*own, *(f"{name} runs again" for name in self.after)])


def explain(new: Rig, old: Rig, preset: str) -> tuple[StageVerdict, ...]:
    """All stages in their order, curves by mode. preset: of the mesh

    raises: ValueError naming a preset that one of the files does not have
    """
    for rig in (new, old):
        if preset not in rig.mesh:
            raise ValueError(f"--mesh {preset}: the rig {rig.name} has {', '.join(rig.mesh)}")
    entries = {"new": _leaves(new), "old": _leaves(old)}
    found: dict[str, StageVerdict] = {}
    for stage in (*stages.STAGES, stages.RESONANCE):
        for mode in new.study.modes if stage in (stages.CURVE, stages.RESONANCE) else ("",):
            name = f"{stage.name} {mode}".strip()
            choice = {"preset": preset, "mode": mode}
            read = {*stage.read(new, choice), *stage.read(old, choice)}
            changes = list(_changes(read, entries["new"], entries["old"]))
            if stage is stages.CURVE and not changes:
                changes += _further_forces(new, old)
            after = tuple(one.name for one in stage.after if one.name in found and found[one.name].again)
            found[name] = StageVerdict(name, tuple(changes), after)
    return tuple(found.values())


def _further_forces(new: Rig, old: Rig) -> Iterator[Change]:
    """A curve is of one force: those at forces that were there are kept."""
    known, wanted = list(old.study.force_levels), list(new.study.force_levels)
    if further := [force for force in wanted if force not in known]:
        yield Change("study.force_levels", _written(known), f"{_written(wanted)}, at {_written(further)} alone")


def other_changes(new: Rig, old: Rig, verdicts: Sequence[StageVerdict]) -> tuple[Change, ...]:
    """What differs and makes no stage run again: names, forces left out, other presets."""
    told = {one.path for verdict in verdicts for one in verdict.changes}
    return tuple(one for one in _differing(_leaves(new), _leaves(old)) if one.path not in told)


def _changes(read: Set[str], new: Mapping[str, Any], old: Mapping[str, Any]) -> Iterator[Change]:
    """read: sections"""
    for one in _differing(new, old):
        if any(_within(one.path, section) for section in read):
            yield one


def _within(path: str, section: str) -> bool:
    """As `Rig.digest` has it: what is in a table of `APART` is not part of the table about that."""
    apart = any(path.startswith(f"{table}.") and not section.startswith(table) for table in APART)
    return path == section or (path.startswith(f"{section}.") and not apart)


def _differing(new: Mapping[str, Any], old: Mapping[str, Any]) -> Iterator[Change]:
    for path in dict.fromkeys((*new, *old)):
        if new.get(path, _ABSENT) != old.get(path, _ABSENT):
            yield Change(path, _written(old.get(path, _ABSENT)), _written(new.get(path, _ABSENT)))


def _leaves(rig: Rig) -> dict[str, Any]:
    """Dotted path -> value, as it enters the stages' keys; effects by their names."""
    stated = rig.model_dump(mode="json")
    effects = {one["name"]: {**one["values"], **_code(one["code"])} for one in stated.pop("effects")}
    return dict(_flat({**stated, "effects": effects, "calibration": stated["calibration"]["factors"]}, ""))


def _code(code: str) -> dict[str, str]:
    """What defines a user's own effect; updamp's own have none, which is no input that could differ."""
    return {"code": code} if code else {}


def _flat(value: Any, path: str) -> Iterator[tuple[str, Any]]:
    if isinstance(value, Mapping):
        for name, entry in value.items():
            yield from _flat(entry, f"{path}.{name}" if path else name)
    elif value is not None:  # a key that is not set, as one that is not stated
        yield path, value


def _written(value: Any) -> str:
    if isinstance(value, float):
        return f"{value:.12g}"
    if isinstance(value, list):
        return f"[{', '.join(map(_written, value))}]" if len(value) <= 6 else f"{len(value)} entries"
    return str(value)


def explain_table(verdicts: Sequence[StageVerdict]) -> Table:
    table = Table(title_justify="left", header_style="bold")
    for heading in ("stage", "", "because (values in SI)"):
        table.add_column(heading)
    for one in verdicts:
        table.add_row(one.name, "[yellow]runs again[/]" if one.again else "[dim]is kept[/]", one.because)
    return table
