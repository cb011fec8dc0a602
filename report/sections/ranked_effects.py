"""Every effect that was looked at, best first: what the score test promised and what the refit gave."""

import math
from html import escape

from updamp.diagnosis.verdict import Candidate, FittedParameter
from updamp.report.markup import BLUE, MISSING, SKY, bar, figure_element, number, percent, table, with_unit
from updamp.report.section import Content, Report, ReportSection

TEXT = """<p>Score: how far the effect stands out of the scatter, in standard deviations. Visibility: the share of its
signature that calibration cannot imitate; below 0.2 these data cannot show it. Predicted: by the score test; obtained:
by fitting it. Held-out gain: fall of the misfit on force levels and mode that no fit saw.</p>"""
HEAD = (
    "Effect",
    "Score",
    "Visibility",
    "",
    "Predicted Δχ²",
    "Obtained Δχ²",
    "ΔBIC",
    "Held-out gain",
    '<span class="wrapped">Verdict</span>',
)
VISIBLE = 0.2
DECIMALS = 3  # of deviations and of chi-square: what is smaller is round-off
PARAMETER_HEAD = ("Effect", "Parameter", "Fitted", "95 % interval", "Absent at", "Physical bounds")
ROW_HEIGHT = 34  # px


def render(report: Report) -> Content | None:
    if report.verdict is None or not report.verdict.candidates:
        return None
    candidates = report.verdict.candidates
    html = TEXT + table(HEAD, [_row(each) for each in candidates])
    fitted = [_parameter_row(each, p) for each in candidates for p in each.parameters]
    if fitted:
        html += "<h3>Fitted parameters</h3>" + table(PARAMETER_HEAD, fitted, numbers_from=2)
    html += "<h3>Predicted and obtained gain</h3>" + figure_element(
        "gains",
        "Bars of the predicted and the obtained fall of chi-square, effect by effect; the table above has the numbers.",
        height=130 + ROW_HEIGHT * len(candidates),
    )
    return Content(html, {"gains": _gains(candidates)})


def _row(each: Candidate) -> tuple[str, ...]:
    visibility = number(each.visibility, 2)
    return (
        f'<strong>{escape(each.name)}</strong><br><span class="small">{escape(each.sentence)}</span>',
        number(round(each.score, DECIMALS), 3),
        visibility if each.visibility >= VISIBLE else f'<strong class="far">{visibility}</strong>',
        f'<span class="narrow">{bar(each.visibility)}</span>',
        *(number(round(value, DECIMALS), 3) for value in (each.predicted_drop, each.obtained_drop, each.delta_bic)),
        MISSING if math.isnan(each.held_out_gain) else percent(each.held_out_gain),
        f'<span class="wrapped">{"<strong>accepted</strong>" if each.accepted else escape(each.reason)}</span>',
    )


def _parameter_row(each: Candidate, parameter: FittedParameter) -> tuple[str, ...]:
    outside = not parameter.lower_bound < parameter.value < parameter.upper_bound
    value = " or ".join(with_unit(each, parameter.unit) for each in (parameter.value, *parameter.also))
    return (
        f"<strong>{escape(each.name)}</strong>",
        escape(parameter.name.replace("_", " ")),
        f'<strong class="far">{value} (at its bound)</strong>' if outside else value,
        f"{number(parameter.lower)} … {with_unit(parameter.upper, parameter.unit)}",
        with_unit(parameter.null, parameter.unit),
        f"{number(parameter.lower_bound)} … {with_unit(parameter.upper_bound, parameter.unit)}",
    )


def _gains(candidates: tuple[Candidate, ...]) -> dict[str, object]:
    names = [each.name for each in candidates][::-1]  # plotly draws the first bar at the bottom
    bars = (
        ("obtained by the refit", BLUE, [each.obtained_drop for each in candidates][::-1]),
        ("predicted by the score test", SKY, [each.predicted_drop for each in candidates][::-1]),
    )
    traces = [
        {"type": "bar", "orientation": "h", "name": name, "y": names, "x": drops, "marker": {"color": colour},
         "hovertemplate": f"%{{y}}: %{{x:.4g}}<br>{name}<extra></extra>"}
        for name, colour, drops in bars
    ]  # fmt: skip
    layout = {
        "barmode": "group", "xaxis": {"title": {"text": "fall of χ²"}, "rangemode": "tozero"},
        "yaxis": {"automargin": True, "showgrid": False},
        "legend": {"orientation": "h", "traceorder": "reversed", "x": 0, "y": 1.0, "yanchor": "bottom"},
    }  # fmt: skip
    return {"data": traces, "layout": layout}


SECTION = ReportSection("effects", "Candidate effects", render, "Candidates")
