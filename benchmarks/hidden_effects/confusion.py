"""What is hidden against what is diagnosed, as a matrix and a picture."""

from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

import matplotlib as mpl
import numpy as np
from matplotlib.figure import Figure
from numpy.typing import NDArray

from updamp.benchmarks.hidden_effects.scored_case import ScoredCase
from updamp.benchmarks.virtual_rig.laboratory import HIDDEN
from updamp.effects.catalogue import CATALOGUE

Floats = NDArray[np.float64]

NOTHING = "nothing hidden"
WITHOUT_NAMES = {"adequate": "nothing missing", "unknown": "unknown", "undecidable": "cannot be decided"}
# Blues without their darkest part, on which text in black could not be read.
_SHADES = mpl.colormaps["Blues"]


@dataclass(frozen=True, eq=False)
class Confusion:
    """count: (rows, columns) verdicts; one that names k effects counts 1/k for each
    rows: what is hidden; columns: the catalogue's effects, then verdicts that name none; cases: (rows,) how many
    """

    rows: tuple[str, ...]
    columns: tuple[str, ...]
    count: Floats
    cases: tuple[int, ...]


def confusion(cases: Sequence[ScoredCase]) -> Confusion:
    """Of cases with at most one effect hidden, at 36 patches; pairs are in the table."""
    used = [c for c in cases if c.kind in ("single", "none", "outside")]
    outside = sorted({c.truth[0] for c in used if c.kind == "outside"})
    hidden = {c.truth[0] for c in used if c.kind == "single"}
    rows = (*(name for name in CATALOGUE if name in hidden), NOTHING, *outside)
    columns = (*CATALOGUE, *WITHOUT_NAMES.values())
    count = np.zeros((len(rows), len(columns)))
    for case in used:
        row = rows.index(case.truth[0] if case.truth else NOTHING)
        for name, share in outcome_shares(case):
            # an effect of a user's own has no column
            if name in columns:
                count[row, columns.index(name)] += share
    of_row = [sum((c.truth[0] if c.truth else NOTHING) == row for c in used) for row in rows]
    return Confusion(rows, columns, count, tuple(of_row))


def outcome_shares(case: ScoredCase) -> list[tuple[str, float]]:
    """Names with shares that add up to 1."""
    if not case.called.names_something:
        return [(WITHOUT_NAMES[case.called.verdict], 1.0)]
    group = case.called.group if case.called.verdict == "inseparable" else ()
    named = tuple(dict.fromkeys((*case.called.effects, *group)))
    return [(name, 1 / len(named)) for name in named]


def draw(matrix: Confusion, path: Path) -> None:
    """One square a pair; right ones are framed."""
    rows, columns = len(matrix.rows), len(matrix.columns)
    figure = Figure(figsize=(0.42 * columns + 3.6, 0.36 * rows + 3.2), layout="constrained")
    axes = figure.subplots()
    share = matrix.count / np.maximum(np.array(matrix.cases)[:, None], 1)
    axes.imshow(share, cmap=_SHADES, vmin=0, vmax=1.6, aspect="auto")
    for r, c in zip(*np.nonzero(matrix.count), strict=True):
        axes.text(c, r, f"{matrix.count[r, c]:.2g}", ha="center", va="center", fontsize=8)
    for r, name in enumerate(matrix.rows):
        for right in _right(name):
            axes.add_patch(_frame(matrix.columns.index(right), r))
    labels = [f"{_plain(name)} ({n})" for name, n in zip(matrix.rows, matrix.cases, strict=True)]
    axes.set_xticks(range(columns), [_plain(name) for name in matrix.columns], rotation=60, ha="right", fontsize=8)
    axes.set_yticks(range(rows), labels, fontsize=8)
    axes.axvline(len(CATALOGUE) - 0.5, color="0.6", lw=0.8)
    if NOTHING in matrix.rows:
        axes.axhline(matrix.rows.index(NOTHING) - 0.5, color="0.6", lw=0.8)
        axes.axhline(matrix.rows.index(NOTHING) + 0.5, color="0.6", lw=0.8)
    axes.set_xlabel("the diagnosis says")
    axes.set_ylabel("hidden (cases)")
    path.parent.mkdir(parents=True, exist_ok=True)
    figure.savefig(path, dpi=150)


def _right(row: str) -> tuple[str, ...]:
    """Columns"""
    if row == NOTHING:
        return (WITHOUT_NAMES["adequate"],)
    if row in CATALOGUE:
        return (row,)
    return (WITHOUT_NAMES["unknown"], *{HIDDEN[row].catalogue_name}.intersection(CATALOGUE))


def _frame(column: int, row: int) -> mpl.patches.Rectangle:
    return mpl.patches.Rectangle((column - 0.5, row - 0.5), 1, 1, fill=False, edgecolor="tab:green", lw=1.2)


def _plain(name: str) -> str:
    return name.replace("_", " ")
