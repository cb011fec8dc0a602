"""One HTML page of a parameter study, that needs nothing but a browser."""

import base64
from collections.abc import Mapping, Sequence
from dataclasses import asdict
from html import escape
from pathlib import Path
from typing import Any

from updamp.parameter_study.design_numbers import LETTERS, design_numbers
from updamp.parameter_study.families import Family
from updamp.parameter_study.findings.finding import Checked
from updamp.parameter_study.mode_peak import Peak
from updamp.parameter_study.response_figures import response_figures
from updamp.parameter_study.solved_study import SolvedStudy, UnknownResultError
from updamp.report.document import DocumentSection, document, document_data
from updamp.report.markup import figure_element, number, paragraph, table
from updamp.report.page import script_json

_WORDS = {True: "met", False: "not met", None: "not known"}
_PLOTTED = "_responses_"  # pictures that the page has as interactive figures


def write_page(path: Path, solved: SolvedStudy, findings: Sequence[Checked], pictures: Mapping[str, str]) -> None:
    """pictures: file in the study's folder -> caption. raises: OSError where a file cannot be read or written"""
    temporary = path.with_suffix(".tmp")
    temporary.write_text(study_page(solved, findings, pictures), encoding="utf-8")
    temporary.replace(path)


def study_page(solved: SolvedStudy, findings: Sequence[Checked], pictures: Mapping[str, str]) -> str:
    """HTML"""
    study, figures = solved.study, dict[str, Any]()
    sections = [DocumentSection("overview", "Study", _overview(solved))]
    if findings:
        sections.append(DocumentSection("findings", "Findings", _findings(findings)))
    for family in study.families:
        own = response_figures(solved, family)
        figures |= own
        html = "".join(figure_element(name, figure["layout"]["title"]["text"]) for name, figure in own.items())
        html += _pictures(solved.folder, family, pictures)
        html = html or paragraph("No curve is known yet.")
        sections.append(DocumentSection(family.name, family.title, html, family.title.split(" (")[0]))
    sections.append(DocumentSection("design-numbers", "Design numbers", _design_numbers(solved)))
    sections.append(DocumentSection("curves", "All curves", _curves(solved)))
    data = script_json(document_data(figures, {}))
    return document(f"Parameter study {study.name}", sections, data, contents=True)


def _overview(solved: SolvedStudy) -> str:
    study, curves = solved.study, solved.curves
    complete = sum(curve.complete for curve in curves.values())
    rows = [
        ("rig", f"{solved.rig.name}, mesh {study.mesh}"),
        ("curves", f"{len(curves)} traced, {complete} of them complete; {len(solved.missing)} missing"),
        ("time of the curves", f"{sum(curve.seconds for curve in curves.values()):.0f} s"),
    ]
    return table(("", ""), [(escape(a), escape(b)) for a, b in rows], numbers_from=2)


def _findings(findings: Sequence[Checked]) -> str:
    met = sum(one.met is True for one in findings)
    head = ("no.", "the paper", "seen in", "updamp", "", "met if")
    rows = [
        (
            str(one.finding.number), escape(one.finding.paper), escape(one.finding.seen_in), escape(one.updamp),
            f"<strong>{_WORDS[one.met]}</strong>", f'<span class="small">{escape(one.finding.criterion)}</span>',
        )
        for one in findings
    ]  # fmt: skip
    return paragraph(f"{met} of {len(findings)} are met.") + table(head, rows, numbers_from=len(head))


def _pictures(folder: Path, family: Family, pictures: Mapping[str, str]) -> str:
    """Small ones, of the pressure, side by side."""
    shown: dict[bool, list[str]] = {True: [], False: []}
    for file, caption in pictures.items():
        name = Path(file).name
        if name.startswith(f"{family.name}_") and _PLOTTED not in name:
            data = base64.b64encode((folder / file).read_bytes()).decode()
            shown["_pressure_" in name].append(
                f'<figure class="picture"><img alt="{escape(caption)}" src="data:image/png;base64,{data}">'
                f"<figcaption>{escape(caption)}</figcaption></figure>"
            )
    small = f'<div class="pictures">{"".join(shown[True])}</div>' if shown[True] else ""
    return small + "".join(shown[False])


def _design_numbers(solved: SolvedStudy) -> str:
    """Table 1b of the first family's variants."""
    head = ["variant", "mode", "force [N]", *LETTERS.values()]
    words = ", ".join(f"{letter}: {name.replace('_', ' ')}" for name, letter in LETTERS.items())
    rows = []
    for name in solved.study.families[0].curves():
        try:
            values = asdict(design_numbers(solved, name)).values()
        except UnknownResultError:
            continue
        rows.append([escape(name.variant), escape(name.mode), f"{name.force:g}", *(number(v) for v in values)])
    caption = f"At the resonances, as Table 1b of Pesaresi et al. (2017) has them. {words}."
    return table(head, rows, caption, numbers_from=2)


def _curves(solved: SolvedStudy) -> str:
    head = ("variant", "mode", "force [N]", "peak [mm/N]", "at [Hz]", "points", "s", "")
    rows = []
    for name, curve in solved.curves.items():
        peak = solved.peak_of(name, curve) if len(curve) else Peak(float("nan"), float("nan"), 0)
        rows.append(
            (
                escape(name.variant), escape(name.mode), f"{name.force:g}", number(1e3 * peak.receptance),
                number(peak.frequency, 6), str(len(curve)), f"{curve.seconds:.1f}",
                "" if curve.complete else f"not complete: {escape(curve.stopped)}",
            )
        )  # fmt: skip
    rows += [
        (escape(n.variant), escape(n.mode), f"{n.force:g}", "", "", "", "", f"missing: {escape(reason)}")
        for n, reason in solved.missing.items()
    ]
    return table(head, rows, numbers_from=2)
