"""Sections to one page that needs nothing but a browser: styles, plotly.js, data and scripts are all inside."""

from collections.abc import Sequence
from html import escape
from importlib.resources import files

from plotly.offline import get_plotlyjs

from updamp.diagnosis.report.compact import script_json
from updamp.diagnosis.report.markup import level_word, pretty
from updamp.diagnosis.report.palette import FOR_SCRIPTS
from updamp.diagnosis.report.section import Content, Report, Section

# The browser refuses whatever would leave the page; blob: and data: are plotly's way to save a plot as a picture.
POLICY = (
    "default-src 'none'; img-src data: blob:; style-src 'unsafe-inline'; script-src 'unsafe-inline'; "
    "base-uri 'none'; form-action 'none'"
)


def build_page(report: Report, sections: Sequence[Section]) -> str:
    """HTML of the `sections` that have something to show, in their order"""
    rendered = [(section, content) for section in sections if (content := section.render(report)) is not None]
    title = escape(report.comparison.title)
    data = _page_data(rendered, report.comparison.level_unit)
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


def asset(name: str) -> str:
    """Text of a file in `assets/`"""
    return (files("updamp.diagnosis.report") / "assets" / name).read_text(encoding="utf-8")


def _contents_list(rendered: Sequence[tuple[Section, Content]]) -> str:
    links = "".join(
        f'<li><a href="#{section.identifier}">{escape(section.short or section.title)}</a></li>'
        for section, _ in rendered
    )
    return f'<nav aria-label="Contents"><ul>{links}</ul></nav>'


def _section_html(section: Section, content: Content) -> str:
    name = section.identifier
    return (
        f'<section id="{name}" aria-labelledby="{name}-heading">\n'
        f'<h2 id="{name}-heading">{escape(section.title)}</h2>\n{content.html}\n</section>'
    )


def _page_data(rendered: Sequence[tuple[Section, Content]], unit: str) -> str:
    return script_json(
        {
            "palette": FOR_SCRIPTS,
            "level": {"unit": pretty(unit), "word": level_word(unit)},
            "figures": {name: figure for _, content in rendered for name, figure in content.figures.items()},
            "sections": {section.identifier: content.data for section, content in rendered if content.data},
        }
    )


def _scripts(rendered: Sequence[tuple[Section, Content]]) -> list[str]:
    """Each once, the common ones about them."""
    own = [name for _, content in rendered for name in content.scripts]
    return list(dict.fromkeys(("core.js", *own, "start.js")))
