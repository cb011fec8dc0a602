"""What the contacts do at the peak of each curve."""

from updamp.report.markup import BLUE, GREY, ORANGE, PURPLE, figure_element
from updamp.report.section import Content, Report, ReportSection

STATES = (("stuck", BLUE), ("slipping", ORANGE), ("separating", PURPLE), ("open", GREY))


def render(report: Report) -> Content | None:
    states = report.comparison.contact_states
    if not states:
        return None
    names = list(states)[::-1]  # plotly draws the first bar at the bottom
    traces = [
        {
            "type": "bar", "orientation": "h", "name": state, "y": names, "marker": {"color": colour},
            "x": [100 * states[name][i] for name in names],
            "hovertemplate": f"%{{y}}: %{{x:.0f}} % {state}<extra></extra>",
        }
        for i, (state, colour) in enumerate(STATES)
    ]  # fmt: skip
    layout = {
        "barmode": "stack", "xaxis": {"title": {"text": "share of the contacts at the peak [%]"}, "range": [0, 100]},
        "yaxis": {"automargin": True, "showgrid": False},
        "legend": {"orientation": "h", "traceorder": "normal", "x": 0, "y": 1.0, "yanchor": "bottom"},
    }  # fmt: skip
    spoken = "; ".join(f"{name}: {_in_words(shares)}" for name, shares in states.items())
    html = figure_element("contact-states", f"Share of contacts at the peak. {spoken}.", height=120 + 28 * len(names))
    return Content(html, {"contact-states": {"data": traces, "layout": layout}})


def _in_words(shares: tuple[float, ...]) -> str:
    return ", ".join(f"{100 * share:.0f} % {state}" for share, (state, _) in zip(shares, STATES, strict=True))


SECTION = ReportSection("contacts", "Contacts at the peak", render, "Contacts")
