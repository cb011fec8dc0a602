"""How the misfit fell with each effect added, down towards what repeats allow."""

import math
from collections.abc import Sequence
from html import escape
from itertools import pairwise
from typing import Any

from updamp.diagnosis.verdict import Step
from updamp.report.markup import BLUE, GREEN, GREY, MINUS, MISSING, VERMILLION, figure_element, number, table
from updamp.report.section import Content, Report, ReportSection

HEAD = ("Step", "Effects in the model", "Misfit in the fit", "Misfit on held-out data")
PANELS = (("data of the fit", (0.0, 0.46)), ("held-out data", (0.54, 1.0)))


def render(report: Report) -> Content | None:
    if report.verdict is None or not report.verdict.history:
        return None
    history, floor = report.verdict.history, report.verdict.error.repeatability
    names = [_step_name(history, k) for k in range(len(history))]
    rows = [
        (escape(name), escape(", ".join(step.effects)) or MISSING, number(step.error, 3), number(step.held_out, 3))
        for name, step in zip(names, history, strict=True)
    ]
    known = not math.isnan(floor)
    spoken = "Misfit step by step, on data of the fit and held out" + known * f"; repeatability is {number(floor, 3)}."
    dashed = f"Dashed: repeatability, {number(floor, 3)}: what repeats alone give." if known else ""
    html = figure_element("waterfall", spoken, dashed, 400)
    html += table(HEAD, rows, numbers_from=2)
    return Content(html, {"waterfall": _waterfall(names, history, floor)})


def _step_name(history: Sequence[Step], k: int) -> str:
    if k == 0:
        return "calibrated"
    before, after = set(history[k - 1].effects), set(history[k].effects)
    changes = [f"+ {name}" for name in history[k].effects if name not in before]
    changes += [f"{MINUS} {name}" for name in history[k - 1].effects if name not in after]
    return ", ".join(changes) or "refitted"


def _waterfall(names: Sequence[str], history: Sequence[Step], floor: float) -> dict[str, Any]:
    series = ([step.error for step in history], [step.held_out for step in history])
    layout: dict[str, Any] = {"showlegend": False, "shapes": [], "annotations": []}
    traces, bars = [], _bars(names)
    for axis, errors, (title, domain) in zip(("", "2"), series, PANELS, strict=True):
        layout[f"xaxis{axis}"] = {
            "domain": domain, "anchor": f"y{axis}", "showgrid": False, "automargin": True, "tickmode": "array",
            "tickvals": list(range(len(bars))), "ticktext": [_broken(bar) for bar in bars],
        }  # fmt: skip
        layout[f"yaxis{axis}"] = {
            "title": {"text": "" if axis else "misfit [weighted RMS]"}, "anchor": f"x{axis}", "rangemode": "tozero",
        }  # fmt: skip
        layout["annotations"].append(
            {"text": f"<b>{title}</b>", "x": domain[0], "y": 1, "xref": "paper", "yref": "paper", "xanchor": "left",
             "yanchor": "bottom", "showarrow": False, "font": {"size": 14}}
        )  # fmt: skip
        known = [not math.isnan(error) for error in errors]
        if any(known):
            traces.append(_trace(names, errors, axis))
            layout["shapes"] += [] if math.isnan(floor) else [_floor(floor, axis)]
        else:
            layout["annotations"].append(
                {"text": "nothing was held out", "x": sum(domain) / 2, "y": 0.5, "xref": "paper", "yref": "paper",
                 "showarrow": False}
            )  # fmt: skip
    return {"data": traces, "layout": layout}


def _trace(names: Sequence[str], errors: Sequence[float], axis: str) -> dict[str, Any]:
    """At whole numbers: two steps may have the same name."""
    falls = [after - before for before, after in pairwise(errors)]
    several = len(errors) > 1
    return {
        "type": "waterfall", "xaxis": f"x{axis}", "yaxis": f"y{axis}",
        "x": list(range(len(errors) + several)), "y": [errors[0], *falls, *([0.0] if several else [])],
        "customdata": _bars(names),
        "measure": ["absolute", *["relative"] * len(falls), *(["total"] if several else [])],
        "text": [number(errors[0], 3), *(f"{fall:+.2f}".replace("-", MINUS) for fall in falls),
                 *([number(errors[-1], 3)] if several else [])],
        "textposition": "auto", "insidetextfont": {"color": "#ffffff"}, "textangle": 0, "cliponaxis": False,
        "connector": {"line": {"color": GREY, "width": 1}},
        "decreasing": {"marker": {"color": GREEN}}, "increasing": {"marker": {"color": VERMILLION}},
        "totals": {"marker": {"color": BLUE}}, "hovertemplate": "%{customdata}: %{y:.3g}<extra></extra>",
    }  # fmt: skip


def _bars(names: Sequence[str]) -> list[str]:
    return [escape(name) for name in names] + (["result"] if len(names) > 1 else [])


def _broken(name: str) -> str:
    """Over lines short enough to stand below a bar"""
    return name.replace(", ", ",<br>").replace("_", "_<br>")


def _floor(floor: float, axis: str) -> dict[str, Any]:
    return {
        "type": "line", "xref": f"x{axis} domain", "yref": f"y{axis}", "x0": 0, "x1": 1, "y0": floor, "y1": floor,
        "line": {"color": GREY, "width": 2, "dash": "dash"}, "layer": "below",
    }  # fmt: skip


SECTION = ReportSection("steps", "How the misfit fell", render, "Steps")
