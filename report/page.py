"""The report as one HTML file that needs nothing but a browser: styles, plotly.js, data and scripts are all inside."""

import json
import math
from collections.abc import Mapping, Sequence
from html import escape
from pathlib import Path
from typing import Any

import numpy as np
from plotly.offline import get_plotlyjs

from updamp.comparison.comparison import Comparison
from updamp.diagnosis.verdict import Verdict
from updamp.parallel.whole_file import write_whole
from updamp.report.document import POLICY, asset
from updamp.report.markup import FOR_SCRIPTS, drawn_units, level_word, pretty
from updamp.report.registry import SECTIONS
from updamp.report.section import Content, Report, ReportSection

# Of numbers on the page, so that a report stays small: 430.0001 Hz and 430.0002 Hz stay apart, as curves of 0.01 %
# bandwidth need it.
DIGITS = 7
NO_PICTURES: Mapping[str, bytes] = {}


def script_json(value: Any) -> str:
    """JSON that may stand inside a script element. Arrays and floats to 7 digits, nan and infinities as null."""
    text = json.dumps(_plain(value), allow_nan=False, separators=(",", ":"), ensure_ascii=False)
    return text.replace("&", "\\u0026").replace("<", "\\u003c").replace(">", "\\u003e")


def _plain(value: Any) -> Any:
    if isinstance(value, np.ndarray | np.generic):
        value = value.tolist()
    if isinstance(value, Mapping):
        return {str(key): _plain(entry) for key, entry in value.items()}
    if isinstance(value, tuple | list):
        return [_plain(entry) for entry in value]
    if isinstance(value, float):
        return _short(value)
    return value


def _short(value: float) -> float | int | None:
    if not math.isfinite(value):
        return None
    short = float(f"{value:.{DIGITS}g}")
    return int(short) if short.is_integer() and abs(short) < 1e7 else short


def build_page(report: Report, sections: Sequence[ReportSection]) -> str:
    """HTML of the `sections` that have something to show, in their order"""
    rendered = [(section, content) for section in sections if (content := section.render(report)) is not None]
    title = escape(report.comparison.title)
    data = _page_data(rendered, report.comparison)
    return "\n".join(
        (
            '<!DOCTYPE html>\n<html lang="en">\n<head>\n<meta charset="utf-8">',
            f'<meta http-equiv="Content-Security-Policy" content="{POLICY}">',
            '<meta name="viewport" content="width=device-width, initial-scale=1">',
            '<link rel="icon" href="data:,">',
            f"<title>{title}</title>\n<style>\n{asset('report.css')}</style>\n</head>\n<body>",
            f"<header>\n<h1>{title}</h1>\n{_contents_list(rendered)}\n</header>\n<main>",
            *(_section_html(section, content) for section, content in rendered),
            "</main>",
            f'<script type="application/json" id="report-data">{data}</script>',
            f"<script>{get_plotlyjs()}</script>",
            *(f"<script>\n{asset(name)}</script>" for name in _scripts(rendered)),
            "</body>\n</html>\n",
        )
    )


def _contents_list(rendered: Sequence[tuple[ReportSection, Content]]) -> str:
    links = "".join(
        f'<li><a href="#{section.identifier}">{escape(section.short or section.title)}</a></li>'
        for section, _ in rendered
    )
    return f'<nav aria-label="Contents"><ul>{links}</ul></nav>'


def _section_html(section: ReportSection, content: Content) -> str:
    name = section.identifier
    return (
        f'<section id="{name}" aria-labelledby="{name}-heading">\n'
        f'<h2 id="{name}-heading">{escape(section.title)}</h2>\n{content.html}\n</section>'
    )


def _page_data(rendered: Sequence[tuple[ReportSection, Content]], comparison: Comparison) -> str:
    drawn = drawn_units(comparison)
    return script_json(
        {
            "palette": FOR_SCRIPTS,
            "level": {"unit": pretty(comparison.level_unit), "word": level_word(comparison)},
            "units": {"displacement": drawn.displacement[0], "receptance": drawn.receptance[0]},
            "figures": {name: figure for _, content in rendered for name, figure in content.figures.items()},
            "sections": {section.identifier: content.data for section, content in rendered if content.data},
        }
    )


def _scripts(rendered: Sequence[tuple[ReportSection, Content]]) -> list[str]:
    """Each once, the common ones about them."""
    own = [name for _, content in rendered for name in content.scripts]
    return list(dict.fromkeys(("core.js", *own, "start.js")))


def write_report(
    comparison: Comparison, path: Path, pictures: Mapping[str, bytes] = NO_PICTURES, verdict: Verdict | None = None
) -> None:
    """One self-contained HTML file.

    pictures: caption -> PNG
    verdict: of the diagnosis; its sections are left out without one
    raises: ValueError for a picture that is no PNG, naming it; DiskError where the file cannot be written
    """
    write_whole(path, build_page(Report(comparison, verdict, pictures), SECTIONS).encode())
