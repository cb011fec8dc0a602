"""The history of a rig file as a picture."""

import math
from dataclasses import replace
from pathlib import Path

from updamp.diagnosis.history import Errors, History
from updamp.diagnosis.history_table import step_name
from updamp.pictures.error_history import Fall, error_waterfall


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
