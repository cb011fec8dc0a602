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

from rich.table import Table

from updamp.comparison.comparison import Comparison
from updamp.comparison.json_document import JsonDocument
from updamp.pictures.error_history import Fall, error_waterfall

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


HISTORY_JSON = JsonDocument(History, "updamp history 1", "updamp add")


def history_file(rig: Path) -> Path:
    return rig.with_name(f"{rig.stem}.history.json")


def read_history(rig: Path) -> History:
    """Empty where there is none; raises: ValueError naming the file and what is wrong with it"""
    path = history_file(rig)
    return HISTORY_JSON.read(path) if path.is_file() else History()


def write_history(rig: Path, history: History) -> None:
    HISTORY_JSON.write(history_file(rig), history)


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
    """Whether both are of the same rig and data."""
    return (a.kind, a.rig, a.effects, a.data) == (b.kind, b.rig, b.effects, b.data)


# The history of a rig file on the terminal.

SIGNS = {"added": "+", "removed": "\N{MINUS SIGN}"}


def history_table(title: str, history: History) -> Table:
    """One line a step; errors are weighted residual RMS; repeats: what these give alone; data: begin of their hash."""
    table = Table(title=title, title_justify="left", header_style="bold")
    for heading in ("date", "step", "error", "held-out", "repeats", "data"):
        right = heading in ("error", "held-out", "repeats")
        table.add_column(heading, justify="right" if right else "left", overflow="fold")
    for step in history.steps:
        table.add_row(
            step.day,
            step_name(step),
            _fall(step.before.fit, step.after.fit),
            _fall(step.before.held_out, step.after.held_out),
            _number(step.repeatability),
            step.data[:8],
        )
    return table


def step_name(step: HistoryStep) -> str:
    return ", ".join(f"{SIGNS[step.kind]} {name}" for name in step.changed) or "compared"


def _fall(before: float, after: float) -> str:
    return f"{_number(before)} \N{RIGHTWARDS ARROW} {_number(after)}" if math.isfinite(before) else _number(after)


def _number(value: float) -> str:
    return f"{value:.3g}" if math.isfinite(value) else "?" if math.isnan(value) else "infinite"


# The history of a rig file as a picture.


def draw_history(path: Path, title: str, history: History) -> None:
    """The waterfall of both errors; comparisons are marked at the step they followed. raises: ValueError where no error
    is known"""
    if not any(_known(step.before) or _known(step.after) for step in history.steps):
        raise ValueError("no step of the history has an error that is known: there is nothing to draw")
    panels = (("data of the fit", _falls(history, "fit")), ("held-out data", _falls(history, "held_out")))
    error_waterfall(path, title, panels)


def _falls(history: History, kind: str) -> list[Fall]:
    falls: list[Fall] = []
    for step in history.steps:
        before, after = (float(getattr(errors, kind)) for errors in (step.before, step.after))
        if step.kind != "compared":
            falls.append(Fall(step_name(step), before, after, (), step.repeatability))
        elif falls and math.isfinite(after):
            falls[-1] = replace(falls[-1], compared=(*falls[-1].compared, after))
    return falls


def _known(errors: Errors) -> bool:
    return math.isfinite(errors.fit) or math.isfinite(errors.held_out)
