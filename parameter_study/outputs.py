"""Everything that a parameter study leaves for people and other programs."""

import hashlib
from collections.abc import Sequence

from rich.table import Table

from updamp.parameter_study.families import Family
from updamp.parameter_study.family_pictures import PICTURES
from updamp.parameter_study.findings.finding import Checked, checked
from updamp.parameter_study.page import write_page
from updamp.parameter_study.solved_study import SolvedStudy
from updamp.parameter_study.study_file import FINDINGS
from updamp.parameter_study.study_json import STUDY_JSON, study_content, write_study_json
from updamp.pictures.style import FORMATS, style_key
from updamp.workflow.progress import Display
from updamp.workflow.run_outputs import Outputs

VERSION = 3  # to be raised when pictures of the same curves look different
_WORDS = {True: "[green]met[/]", False: "[red]not met[/]", None: "[yellow]not known[/]"}


def check_findings(solved: SolvedStudy) -> tuple[Checked, ...]:
    return tuple(checked(one, solved) for one in FINDINGS.get(solved.study.findings, ()))


def write_outputs(solved: SolvedStudy, findings: Sequence[Checked], display: Display) -> tuple[str, ...]:
    """Names of the files. raises: OSError where one cannot be written"""
    pictures: dict[str, str] = {}
    with display.stage("pictures") as update:
        for i, family in enumerate(solved.study.families):
            update(i / len(solved.study.families), family.name)
            pictures |= _draw(solved, family)
    content = study_content(solved, findings, pictures)
    write_study_json(solved.folder / STUDY_JSON, content)
    write_page(solved.folder / "study.html", solved, findings, pictures)
    return (STUDY_JSON, "study.html", f"{len(pictures)} pictures")


def _draw(solved: SolvedStudy, family: Family) -> dict[str, str]:
    """file -> caption; drawn anew only where the curves have changed"""
    outputs, drawn = Outputs(solved.folder, solved.folder / "stages" / f"pictures_{family.name}.json"), {}
    sources = [_fingerprint(solved, family), repr(family), repr(solved.study.contacts), repr(solved.study.measured)]
    for kind in family.pictures:
        for picture in PICTURES[kind](solved, family):
            file = f"pictures/{picture.name}.png"
            outputs.make(file, [*sources, style_key()], VERSION, picture.draw, FORMATS)
            drawn[file] = picture.caption
    return drawn


def _fingerprint(solved: SolvedStudy, family: Family) -> str:
    digest = hashlib.sha256()
    for name in family.curves():
        curve = solved.curves.get(name)
        digest.update(repr(name).encode())
        for part in () if curve is None else (curve.frequency, curve.response, curve.displacement):
            digest.update(part.tobytes())
    return digest.hexdigest()


def findings_table(findings: Sequence[Checked]) -> Table:
    met = sum(one.met is True for one in findings)
    table = Table(title=f"Findings: {met} of {len(findings)} met", title_justify="left", header_style="bold")
    for heading in ("no.", "the paper", "updamp", ""):
        table.add_column(heading, overflow="fold")
    for one in findings:
        table.add_row(str(one.finding.number), one.finding.paper, one.updamp.replace("[", "\\["), _WORDS[one.met])
    return table
