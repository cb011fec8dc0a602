"""One interactive page of a study, that needs nothing but a browser: styles, plotly.js, data and scripts are inside."""

import math
from collections.abc import Iterator, Mapping
from html import escape
from importlib.resources import files
from pathlib import Path
from typing import Any

from updamp.design.goals import Constraint
from updamp.design.page.pictures import section_pictures
from updamp.design.page.sensitivities import sensitivity_figures
from updamp.design.records import BROKEN, FAILED
from updamp.design.run_study import StudyResult
from updamp.design.table import best_records, feasible, problem_of
from updamp.report.document import DocumentSection, document, document_data
from updamp.report.markup import figure_element, number, paragraph, table
from updamp.report.page import script_json

_BEST = 20  # designs in the table


def write_page(path: Path, result: StudyResult) -> None:
    """raises: OSError where the file cannot be written"""
    temporary = path.with_suffix(".tmp")
    temporary.write_text(study_page(result), encoding="utf-8")
    temporary.replace(path)


def study_page(result: StudyResult) -> str:
    """HTML"""
    figures = sensitivity_figures(result)
    sections = (
        DocumentSection("overview", "Study", _overview(result)),
        DocumentSection("tradeoff", "Designs", _designs_section()),
        DocumentSection(
            "parallel", "Parallel coordinates", figure_element("parallel", "Each design as a line through all axes")
        ),
        DocumentSection("sensitivities", "Sensitivities", _figures_section(figures)),
        DocumentSection("best", "Best designs", _best(result)),
        *_failed(result),
    )
    data = {"designs": designs_data(result), "pictures": section_pictures(result)}
    text = script_json(document_data(figures, {"study": data}))
    return document(f"Design study {result.study.name}", sections, text, (_own("study.js"),), _own("study.css"))


def designs_data(result: StudyResult) -> dict[str, Any]:
    """columns: name -> label and values (null where not known); first: names that are shown to begin with"""
    study, problem = result.study, problem_of(result.study)
    columns: dict[str, Any] = {}
    for variable in study.variables:
        values = [one.values[variable.name] for one in result.records]
        columns[variable.name] = {"label": variable.label, "values": values, "log": variable.logarithmic}
    for response in study.responses:
        label = f"{response.name} [{response.unit}]" if response.unit else response.name
        known = [one.responses.get(response.name) for one in result.records]
        columns[response.name] = {"label": label, "values": known, "log": False}
    best = {one.number for one in best_records(problem, result.records)}
    return {
        "columns": columns,
        "numbers": [one.number for one in result.records],
        "best": [one.number in best for one in result.records],
        "kept": [feasible(problem, one) is not False for one in result.records],
        "first": _first(result),
    }


def _first(result: StudyResult) -> list[str]:
    """Two objectives against each other; else the first response against the first variable."""
    objectives = list(dict.fromkeys(one.response for one in result.study.objectives))
    if len(objectives) >= 2:
        return objectives[:2]
    return [result.study.variables[0].name, (objectives or [result.study.responses[0].name])[0]]


def _own(name: str) -> str:
    return (files("updamp.design.page") / "assets" / name).read_text(encoding="utf-8")


def _overview(result: StudyResult) -> str:
    study = result.study
    outcomes = [one.outcome for one in result.records]
    rows = [
        ("rig", f"{result.rig.name}, mesh {study.mesh}"),
        ("method", study.method_name if result.method else f"{study.method_name}, not ended"),
        ("designs", ", ".join(f"{outcomes.count(one)} {one}" for one in dict.fromkeys(outcomes)) or "none"),
        ("variables", ", ".join(f"{v.label} from {v.lower:g} to {v.upper:g}" for v in study.variables)),
        ("objectives", ", ".join(f"{one.response}: {one.goal.words}" for one in study.objectives) or "none"),
        ("constraints", ", ".join(map(_limits, study.constraints)) or "none"),
    ]
    notes = [paragraph(note, "note") for note in result.method.notes] if result.method else []
    cells = [(escape(name), escape(value)) for name, value in rows]
    return table(("", ""), cells, numbers_from=2) + "".join(notes)


def _limits(one: Constraint) -> str:
    low = f"{one.lower:g} <= " if math.isfinite(one.lower) else ""
    return f"{low}{one.response}" + (f" <= {one.upper:g}" if math.isfinite(one.upper) else "")


def _failed(result: StudyResult) -> Iterator[DocumentSection]:
    """Designs without any response, which no picture of responses can show; none where all have some"""
    variables, failed = result.study.variables, [one for one in result.records if one.outcome in (FAILED, BROKEN)]
    if failed:
        cells = [
            [str(one.number), *(number(one.values[v.name]) for v in variables), escape(one.reason)] for one in failed
        ]
        head = ("design", *(escape(v.label) for v in variables), "reason")
        yield DocumentSection("failed", "Designs that failed", table(head, cells))


def _designs_section() -> str:
    return (
        '<div class="controls"><label>across <select id="study-x"></select></label>'
        '<label>up <select id="study-y"></select></label></div>'
        '<div class="study-plot">'
        + figure_element("designs", "All designs, one quantity against another", _CAPTION, 460)
        + '<div id="study-picture" class="study-picture" aria-live="polite"></div></div>'
    )


_CAPTION = (
    "Each point is a design; the best ones (the Pareto front of several objectives) are marked, those that pass a "
    "limit are grey. Pointing at a design shows its values and its section."
)


def _figures_section(figures: Mapping[str, Any]) -> str:
    if not figures:
        return paragraph("There are too few designs to tell.")
    return "".join(figure_element(name, figure["layout"]["title"]["text"], "", 320) for name, figure in figures.items())


def _best(result: StudyResult) -> str:
    study = result.study
    if not study.objectives:
        return paragraph("The study has no objective.")
    best = best_records(problem_of(study), result.records)[:_BEST]
    if not best:
        return paragraph("No design keeps all limits with all its objectives known.")
    units = {**{v.name: v.unit for v in study.variables}, **{r.name: r.unit for r in study.responses}}
    head = ["design", *(escape(f"{name} [{unit}]" if unit else name) for name, unit in units.items())]
    cells = []
    for record in best:
        known = {**record.values, **record.responses}
        values = [known[name] for name in units]
        cells.append([str(record.number), *(number(float("nan") if v is None else v) for v in values)])
    return table(head, cells, f"updamp design-rig {escape(result.folder.path.name)} NUMBER writes the rig file of one.")
