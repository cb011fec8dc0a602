"""Open the seals of version 2: every case and the counts, in all and for each kind of test.

.venv/bin/python benchmarks/hidden_effects/score_version_2.py --draw N --folder FOLDER [--results FILE] [--docs FILE]

An effect counts where the laboratory's own curves say that it can be seen (`detectability.py`).
"""

from collections.abc import Sequence
from math import isfinite
from pathlib import Path
from typing import Annotated, Any

import typer

from updamp.benchmarks.hidden_effects.goals import OUTSIDE, Goal, goal_of_counts, median_seconds
from updamp.benchmarks.hidden_effects.judgement import CONFIDENTLY_WRONG, CORRECT
from updamp.benchmarks.hidden_effects.kinds_of_test import KINDS_OF_TEST
from updamp.benchmarks.hidden_effects.layout import HERE, Layout, read, write_whole
from updamp.benchmarks.hidden_effects.score import DOCS, put_into, score_all, with_kept
from updamp.benchmarks.hidden_effects.scored_case import ScoredCase
from updamp.benchmarks.hidden_effects.tables import KINDS, case_table, goal_table
from updamp.benchmarks.hidden_effects.version_2 import version_2
from updamp.comparison.json_document import encode

MARKS = "<!-- version 2: score_version_2.py -->", "<!-- end of version 2 -->"
# Of what strong effects are to reach: the error on held-out runs falls so many times.
FALL = 3.0


def counts(cases: Sequence[ScoredCase]) -> dict[str, int]:
    """How many there are of each kind that can be seen, and how many of them came out right; of all with something
    hidden, seen or not, for how many something else was named."""
    seen = [c for c in cases if c.detectable or c.kind == "none"]
    single, none, outside, pairs = ([c for c in seen if c.kind == k] for k in ("single", "none", "outside", "pair"))
    right = [c for c in single if c.mark in CORRECT]
    strong = [c for c in right if c.strength == "strong" and isfinite(c.error.held_out_before)]
    hidden = [c for c in cases if c.kind != "none"]
    intervals = [r for c in right for r in c.recovered]
    return {
        "cases": len(cases),
        "single": len(single),
        "single_right": len(right),
        "hidden": len(hidden),
        "confidently_wrong": sum(c.mark in CONFIDENTLY_WRONG for c in hidden),
        "null": len(none),
        "false_alarms": sum(c.mark == "false alarm" for c in none),
        "outside": len(outside),
        "outside_right": sum(c.mark in CORRECT for c in outside),
        "pairs": len(pairs),
        "pairs_right": sum(c.mark in CORRECT for c in pairs),
        "strong": len(strong),
        "strong_heldout_3x": sum(c.error.held_out_before >= FALL * c.error.held_out_after for c in strong),
        "intervals": len(intervals),
        "intervals_hold": sum(r.inside for r in intervals),
    }


def goals(cases: Sequence[ScoredCase]) -> tuple[Goal, ...]:
    n = counts(cases)

    def of(name: str, wanted: str, hits: str, all_of: str, share: float, most: bool = False) -> Goal:
        met = (lambda k, of: k <= share * of) if most else (lambda k, of: k >= share * of)
        return goal_of_counts(name, wanted, n[hits], n[all_of], met)

    return (
        of("right effect, or its group of two", "95 %", "single_right", "single", 0.95),
        of("confidently wrong, of all with something hidden", "at most 1 %", "confidently_wrong", "hidden", 0.01, True),
        of("false alarms where nothing is hidden", "at most 1 of 40", "false_alarms", "null", 1 / 40, True),
        of(OUTSIDE, "22 of 24", "outside_right", "outside", 22 / 24),
        of("both of two effects", "20 of 24", "pairs_right", "pairs", 20 / 24),
        of(f"strong: error on held-out runs {FALL:g} times lower", "95 %", "strong_heldout_3x", "strong", 0.95),
        of("95 % intervals that hold the truth", "90 %", "intervals_hold", "intervals", 0.9),
    )


def results(cases: Sequence[ScoredCase], draw: int, commits: Sequence[str]) -> dict[str, Any]:
    of_tests = {test: [c for c in cases if c.test == test] for test in KINDS_OF_TEST}
    planned = version_2(draw)
    scored = {c.case for c in cases}
    return {
        "schema": "updamp hidden effects 2",
        "draw": draw,
        "commit": commits[0] if len(commits) == 1 else list(commits),
        "planned": len(planned),
        "without a verdict": [c.name for c in planned if c.name not in scored],
        "counts": counts(cases) | {test: counts(some) for test, some in of_tests.items()},
        "median_seconds": {test: median_seconds(some) for test, some in {"all": cases, **of_tests}.items() if some},
        "cases": [{**encode(c), "detectable": c.detectable} for c in cases],
    }


def document(cases: Sequence[ScoredCase], found: dict[str, Any]) -> str:
    """Everything between the marks of the page."""
    parts = [
        f"{len(cases)} of {found['planned']} cases (`results_v2.json` has which are left); draw {found['draw']}, on "
        f"commit `{str(found['commit'])[:10]}`.",
        goal_table(goals(cases)),
    ]
    for test in KINDS_OF_TEST:
        some = [c for c in cases if c.test == test]
        if some:
            seconds = found["median_seconds"][test]
            parts += [f"### {test.capitalize()} tests: median {seconds:.0f} s of one core", goal_table(goals(some))]
            parts += [case_table([c for c in some if c.kind == kind]) for kind in KINDS if _any(some, kind)]
    return "\n\n".join(parts)


def _any(cases: Sequence[ScoredCase], kind: str) -> bool:
    return any(c.kind == kind for c in cases)


def commits_of(layout: Layout, cases: Sequence[ScoredCase]) -> tuple[str, ...]:
    """Of the code that gave the verdicts."""
    ran = (read(layout.verdict(c.case) / "run.json") or {} for c in cases)
    return tuple(sorted({str(one.get("commit", "")) for one in ran}))


def earlier_commits(earlier: Path, draw: int) -> tuple[str, ...]:
    """Of the verdicts in a file of results, none where there is no such file. raises: ValueError for another draw"""
    before = read(earlier)
    if before is None:
        return ()
    if before["draw"] != draw:
        raise ValueError(f"{earlier} has cases of the draw {before['draw']}, not {draw}: name another file")
    commit = before["commit"]
    return (commit,) if isinstance(commit, str) else tuple(commit)


def main(
    draw: Annotated[int, typer.Option(help="the number that the cases were drawn from")],
    folder: Annotated[Path, typer.Option(help="with truth/, expected/ and verdicts/")] = Layout().folder,
    out: Annotated[Path, typer.Option("--results", help="every case and the counts")] = HERE / "results_v2.json",
    docs: Annotated[Path, typer.Option(help="page whose tables are written anew")] = DOCS,
    keep: Annotated[
        bool, typer.Option("--keep", help="cases of the results there are that have no verdict now")
    ] = False,
) -> None:
    """Score all cases that have a verdict."""
    layout = Layout(folder)
    cases, missing = score_all(layout)
    commits = set(commits_of(layout, cases))
    if keep:
        try:
            commits |= set(earlier_commits(out, draw))
        except ValueError as error:
            raise typer.BadParameter(str(error), param_hint="--results") from None
        cases, _ = with_kept(cases, missing, out)
    if not cases:
        typer.echo(f"{folder}: no verdicts; make some with run.py --draw {draw}", err=True)
        raise typer.Exit(1)
    found = results(cases, draw, sorted(commits))
    write_whole(out, found)
    docs.write_text(put_into(docs.read_text(encoding="utf-8"), document(cases, found), MARKS), encoding="utf-8")
    typer.echo(goal_table(goals(cases)))
    typer.echo(f"{out}, {docs}")


if __name__ == "__main__":
    typer.run(main)
