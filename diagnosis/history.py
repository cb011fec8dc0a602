"""The history of a rig file: which effects came and went, and what each step did to the error.

It stands beside the rig file, `<rig>.history.json`. A rig file made from another one takes its history along.
"""

import hashlib
import math
from collections.abc import Mapping
from dataclasses import dataclass, replace
from datetime import date
from pathlib import Path
from typing import Literal

from updamp.diagnosis.comparison import Comparison
from updamp.diagnosis.json_document import JsonDocument

NOT_KNOWN = math.nan


@dataclass(frozen=True)
class Errors:
    """Weighted residual RMS on the data of the fit and on what was held out; nan where it is not known"""

    fit: float = NOT_KNOWN
    held_out: float = NOT_KNOWN


@dataclass(frozen=True)
class HistoryStep:
    """One step.

    kind: effects were added or removed, or the rig was compared with a measurement (all its data count as `fit` then)
    changed: the effects that came or went; effects: those in the rig file after it
    before, after: errors, both with the model calibrated; repeatability: what repeats alone give, nan where not known
    rig, parent: names of the rig file and of the one it was made from, "" for none; seen from the rig file's folder
    measurement: its file; data: SHA-256 of its data, "" where not known; day: YYYY-MM-DD
    """

    kind: Literal["added", "removed", "compared"]
    changed: tuple[str, ...]
    effects: tuple[str, ...]
    before: Errors
    after: Errors
    repeatability: float
    rig: str
    parent: str
    measurement: str
    data: str
    day: str


@dataclass(frozen=True)
class History:
    steps: tuple[HistoryStep, ...] = ()

    def then(self, step: HistoryStep) -> "History":
        return History((*self.steps, step))

    def reached_with(self, effects: tuple[str, ...]) -> Errors:
        """The last errors of a model with these effects, in any order; unknown ones are nan."""
        for step in reversed(self.steps):
            if step.kind == "compared":
                continue
            if set(step.effects) == set(effects):
                return step.after
            if step.kind == "added" and set(step.effects) - set(step.changed) == set(effects):
                return step.before
        return Errors()


DOCUMENT = JsonDocument(History, "updamp history 1", "updamp add")


def history_file(rig: Path) -> Path:
    return rig.with_name(f"{rig.stem}.history.json")


def read_history(rig: Path) -> History:
    """Empty where there is none; raises: ValueError naming the file and what is wrong with it"""
    path = history_file(rig)
    return DOCUMENT.read(path) if path.is_file() else History()


def write_history(rig: Path, history: History) -> None:
    DOCUMENT.write(history_file(rig), history)


def data_hash(provenance: Mapping[str, str]) -> str:
    """One SHA-256 of all the data that a comparison or a diagnosis names in its provenance; "" where it names none."""
    hashes = sorted((name, value) for name, value in provenance.items() if name.startswith("SHA-256 of "))
    return hashlib.sha256(repr(hashes).encode()).hexdigest() if hashes else ""


def record_comparison(rig: Path, effects: tuple[str, ...], comparison: Comparison) -> None:
    """A line with the error that a comparison found, where the rig file has a history and the comparison had curves.

    It takes the place of an earlier one of the same rig and data.
    """
    if not history_file(rig).is_file() or not comparison.values:
        return
    step = HistoryStep(
        kind="compared",
        changed=(),
        effects=effects,
        before=Errors(),
        after=Errors(math.sqrt(comparison.chi2_after / comparison.values)),
        repeatability=NOT_KNOWN,
        rig=rig.name,
        parent="",
        measurement=comparison.provenance.get("measurement", ""),
        data=data_hash(comparison.provenance),
        day=date.today().isoformat(),
    )
    history = read_history(rig)
    kept = tuple(old for old in history.steps if not _same(old, step))
    write_history(rig, replace(history, steps=kept).then(step))


def _same(a: HistoryStep, b: HistoryStep) -> bool:
    """Whether both tell of the same rig and data."""
    return (a.kind, a.rig, a.effects, a.data) == (b.kind, b.rig, b.effects, b.data)
