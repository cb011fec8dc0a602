"""An HTML file that needs nothing but a browser: styles, plotly.js, data and scripts are all inside."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from html import escape
from importlib.resources import files
from typing import Any

from plotly.offline import get_plotlyjs

from updamp.report.markup import FOR_SCRIPTS

# The browser refuses whatever would leave the page; blob: and data: are plotly's way to save a plot as a picture.
POLICY = (
    "default-src 'none'; img-src data: blob:; style-src 'unsafe-inline'; script-src 'unsafe-inline'; "
    "base-uri 'none'; form-action 'none'"
)
LEVEL = {"unit": "N", "word": "force level"}


@dataclass(frozen=True)
class DocumentSection:
    """identifier: a word, for links; title: its heading; html: below it; short: its name among the links, where the
    heading is too long"""

    identifier: str
    title: str
    html: str
    short: str = ""


def asset(name: str) -> str:
    """Text of a file in `assets/`"""
    return (files("updamp.report") / "assets" / name).read_text(encoding="utf-8")


def document(
    title: str,
    sections: Sequence[DocumentSection],
    data_json: str,
    scripts: Sequence[str] = (),
    styles: str = "",
    contents: bool = False,
) -> str:
    """HTML. title: plain; data_json: see `document_data`; scripts, styles: texts, beside the report's own
    contents: whether links to the sections stand on top"""
    name, links = escape(title), _contents(sections) if contents else ""
    return "\n".join(
        (
            '<!DOCTYPE html>\n<html lang="en">\n<head>\n<meta charset="utf-8">',
            f'<meta http-equiv="Content-Security-Policy" content="{POLICY}">',
            '<meta name="viewport" content="width=device-width, initial-scale=1">\n<link rel="icon" href="data:,">',
            f"<title>{name}</title>\n<style>\n{asset('report.css')}{styles}</style>\n</head>\n<body>",
            f"<header>\n<h1>{name}</h1>\n{links}</header>\n<main>",
            *map(_section, sections),
            f'</main>\n<script type="application/json" id="report-data">{data_json}</script>',
            f"<script>{get_plotlyjs()}</script>",
            *(f"<script>\n{text}</script>" for text in (asset("core.js"), *scripts, asset("start.js"))),
            "</body>\n</html>\n",
        )
    )


def document_data(figures: Mapping[str, Any], sections: Mapping[str, Any]) -> dict[str, Any]:
    """What the scripts read. figures: name -> plotly's, drawn as they are; sections: identifier -> data"""
    return {"palette": FOR_SCRIPTS, "level": LEVEL, "figures": dict(figures), "sections": dict(sections)}


def _contents(sections: Sequence[DocumentSection]) -> str:
    links = "".join(f'<li><a href="#{one.identifier}">{escape(one.short or one.title)}</a></li>' for one in sections)
    return f'<nav aria-label="Contents"><ul>{links}</ul></nav>\n'


def _section(one: DocumentSection) -> str:
    name = one.identifier
    return (
        f'<section id="{name}" aria-labelledby="{name}-heading">\n'
        f'<h2 id="{name}-heading">{escape(one.title)}</h2>\n{one.html}\n</section>'
    )
