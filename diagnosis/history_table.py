"""The history of a rig file on the terminal."""

import math

from rich.table import Table

from updamp.diagnosis.history import History, HistoryStep

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
