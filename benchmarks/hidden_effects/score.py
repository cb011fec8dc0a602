"""Open the seals: verdicts against the truth, into results.json, a picture and tables: goals into
docs/hidden_effects.md, every case into NOTES.md beside this file.

.venv/bin/python benchmarks/hidden_effects/score.py [--folder FOLDER] [--results FILE] [--docs FILE] [--notes FILE]
"""

from collections.abc import Mapping, Sequence
from dataclasses import fields
from pathlib import Path
from typing import Annotated, Any

import typer

from updamp.benchmarks.hidden_effects.confusion import confusion, draw
from updamp.benchmarks.hidden_effects.goals import Goal, carried_over, gains, identification, median_seconds, speed
from updamp.benchmarks.hidden_effects.kinds_of_test import EASY
from updamp.benchmarks.hidden_effects.layout import HERE, Layout, read, write_whole
from updamp.benchmarks.hidden_effects.scored_case import SCORE, VISIBILITY, ScoredCase, scored
from updamp.benchmarks.hidden_effects.tables import all_cases, document, goal_table
from updamp.comparison.json_document import decode, encode

DOCS = HERE.parents[1] / "docs" / "hidden_effects.md"
NOTES = HERE / "NOTES.md"
RESULTS = "<!-- results: score.py -->", "<!-- end of results -->"
CASES = "<!-- cases: score.py -->", "<!-- end of cases -->"


def score_all(layout: Layout) -> tuple[list[ScoredCase], list[str]]:
    """Cases with a verdict, and names of those without."""
    done, missing = [], []
    for path in sorted(layout.truth("*").parent.glob("case_*.json")):
        truth = read(path)
        assert truth is not None, "it was found"
        case = scored(layout, truth)
        if case is None:
            missing.append(truth["case"])
        else:
            done.append(case)
    return done, missing


def with_kept(cases: Sequence[ScoredCase], missing: Sequence[str], earlier: Path) -> tuple[list[ScoredCase], list[str]]:
    """The cases, and those that a file of earlier results has beside them.

    raises: ValueError naming the field of a case that cannot be read
    """
    before = read(earlier) or {"cases": [], "without a verdict": []}
    known = {case.case for case in cases}
    kept = [decode(ScoredCase, only_fields(entry), entry["case"]) for entry in before["cases"]]
    both = sorted([*cases, *(case for case in kept if case.case not in known)], key=lambda case: case.case)
    return both, sorted({*missing, *before["without a verdict"]} - {case.case for case in both})


def only_fields(entry: Mapping[str, Any]) -> dict[str, Any]:
    """Of a case in the file, without what follows from the others. Cases that name no test are of before there were
    several."""
    return {"test": EASY.name} | {field.name: entry[field.name] for field in fields(ScoredCase) if field.name in entry}


def all_goals(cases: Sequence[ScoredCase]) -> tuple[Goal, ...]:
    found = identification(cases, lambda c: c.mark, lambda c: c.detectable)
    return (*found, carried_over(cases), *gains(cases), speed(cases))


def results(cases: Sequence[ScoredCase], missing: Sequence[str]) -> dict[str, Any]:
    by_diagnosis = identification(cases, lambda c: c.mark, lambda c: c.detectable_by_diagnosis)[:2]
    return {
        "schema": "updamp hidden effects 1",
        "detectable": {"score": SCORE, "visibility": VISIBILITY},
        "goals": [encode(g) for g in all_goals(cases)],
        "goals where the diagnosis itself says what is detectable": [encode(g) for g in by_diagnosis],
        "median_seconds": median_seconds(cases) if cases else None,
        "without a verdict": list(missing),
        "cases": [
            {**encode(c), "detectable": c.detectable, "detectable_by_diagnosis": c.detectable_by_diagnosis}
            for c in cases
        ],
    }


def put_into(page: str, tables: str, marks: tuple[str, str] = RESULTS) -> str:
    """The page with what stands between its marks replaced. raises: ValueError for a page without them"""
    begin, end = marks
    if page.count(begin) != 1 or page.count(end) != 1 or page.index(begin) > page.index(end):
        raise ValueError(f"the page needs a line '{begin}' and, after it, a line '{end}': the tables go between them")
    before, _, rest = page.partition(begin)
    return f"{before}{begin}\n{tables}\n{end}{rest.partition(end)[2]}"


def main(
    folder: Annotated[Path, typer.Option(help="with truth/, expected/ and verdicts/")] = Layout().folder,
    out: Annotated[Path, typer.Option("--results", help="every case and the counts")] = HERE / "results.json",
    docs: Annotated[Path, typer.Option(help="page whose tables are written anew; the picture goes beside it")] = DOCS,
    notes: Annotated[Path, typer.Option(help="page whose tables of every case are written anew")] = NOTES,
    keep: Annotated[
        bool, typer.Option("--keep", help="cases of the results there are that have no verdict now")
    ] = False,
) -> None:
    """Score all cases that have a verdict."""
    cases, missing = score_all(Layout(folder))
    if keep:
        cases, missing = with_kept(cases, missing, out)
    if not cases:
        typer.echo(f"{folder}: no verdicts; make some with run.py", err=True)
        raise typer.Exit(1)
    write_whole(out, results(cases, missing))
    tables = document(cases, all_goals(cases), len(cases) + len(missing))
    for path, option, text, marks in (
        (docs, "--docs", tables, RESULTS),
        (notes, "--notes", all_cases(cases), CASES),
    ):
        try:
            page = put_into(path.read_text(encoding="utf-8"), text, marks)
        except ValueError as error:
            raise typer.BadParameter(f"{path}: {error}", param_hint=option) from None
        path.write_text(page, encoding="utf-8")
    draw(confusion(cases), docs.with_suffix(".png"))
    typer.echo(goal_table(all_goals(cases)))
    typer.echo(f"{out}, {docs}, {notes}, {docs.with_suffix('.png')}")


if __name__ == "__main__":
    typer.run(main)
