"""Which effects look alike in these data."""

from html import escape

import numpy as np

from updamp.report.markup import TWO_SIDED_SCALE, figure_element
from updamp.report.section import Content, Report, ReportSection

CELL = 34  # px
FEW = 20  # effects, up to which numbers fit into the cells


def render(report: Report) -> Content | None:
    if report.verdict is None or len(report.verdict.confounding.effects) < 2:
        return None
    found = report.verdict.confounding
    names = list(found.effects)
    trace = {
        "type": "heatmap", "x": names, "y": names, "z": found.cosine, "zmin": -1, "zmax": 1, "xgap": 1, "ygap": 1,
        "colorscale": TWO_SIDED_SCALE, "colorbar": {"title": {"text": "cosine"}, "thickness": 14},
        "hovertemplate": "%{y} and %{x}: %{z:.2f}<extra></extra>",
        **({"texttemplate": "%{z:.2f}", "textfont": {"size": 10}} if len(names) <= FEW else {}),
    }  # fmt: skip
    layout = {
        "xaxis": {"tickangle": -45, "automargin": True, "showgrid": False, "showline": False, "ticks": ""},
        "yaxis": {"autorange": "reversed", "automargin": True, "showgrid": False, "showline": False, "ticks": ""},
    }  # fmt: skip
    groups = "".join(f"<li>{escape(' or '.join(group))}</li>" for group in found.groups)
    text = (
        f"<p>Cosine between what two effects do to the data to first order, calibration taken out: beyond "
        f"±{found.threshold:g} they look alike. How large an effect is may still tell it from another one: what fits "
        "do not tell apart is said by the verdict.</p>"
    )
    text += f"<p>Look alike:</p><ul>{groups}</ul>" if groups else "<p>No two of them look alike.</p>"
    spoken = f"Matrix of cosines between the signatures of {len(names)} effects. {_alike(names, found.cosine)}"
    plot = figure_element("confounding", spoken, height=220 + CELL * len(names))
    return Content(text + plot, {"confounding": {"data": [trace], "layout": layout}})


def _alike(names: list[str], cosine: np.ndarray) -> str:
    rows, columns = np.triu_indices(len(names), 1)
    order = np.argsort(-np.abs(cosine[rows, columns]))[:5]
    pairs = (f"{names[rows[k]]} and {names[columns[k]]}: {cosine[rows[k], columns[k]]:.2f}" for k in order)
    return f"Most alike: {'; '.join(pairs)}."


SECTION = ReportSection("confounding", "Which effects look alike", render, "Look-alikes")
