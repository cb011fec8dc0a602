"""Does `updamp compare` say where the model fails? Its sentences on hidden effects, against what these do.

.venv/bin/python benchmarks/hidden_effects/sentences.py [--data FOLDER] [--out FOLDER] [--only CASE] [--docs FILE]

Calibrations are kept (0.5 GB each), so that another way of saying what they show takes seconds. The rule by which a
sentence counts as right is in `sentence_rule.py`. The cases here are none that the blind benchmark is still to score.
"""

from updamp.parallel.resources import one_thread

one_thread()  # before numpy is loaded: threads make small products many times slower

from collections.abc import Mapping, Sequence
from functools import partial
from pathlib import Path
from typing import Annotated, Any

import typer

from updamp.benchmarks.hidden_effects.cases import Case
from updamp.benchmarks.hidden_effects.fitted_model import FINER, build
from updamp.benchmarks.hidden_effects.in_turn import in_turn
from updamp.benchmarks.hidden_effects.layout import HERE, Layout, read, write_whole
from updamp.benchmarks.hidden_effects.sentence_rule import Judged, judged, laboratory_changes
from updamp.benchmarks.hidden_effects.sentence_runs import FITTED, calibrated
from updamp.benchmarks.hidden_effects.version_2 import Only, chosen_cases
from updamp.benchmarks.virtual_rig.measurement import RIG
from updamp.comparison.compare import comparison_of
from updamp.comparison.comparison import COMPARISON_JSON, Comparison
from updamp.hbm.compilation_cache import keep_compiled

USED = tuple(
    f"case_{n:03d}" for n in (17, 20, 28, 33, 35, 58, 67, 70, 94, 87, 29, 8, 84, 21, 75, 95, 3, 14)
)  # fmt: skip
DOCS = HERE / "NOTES.md"
BEGIN, END = "<!-- sentences: sentences.py -->", "<!-- end of sentences -->"
NOTHING = "no misfit beyond repeatability"


def judge_case(case: Case, data: Layout, out: Path) -> dict[str, Any]:
    """Calibrate where that is not done, compare, judge; the result is a row of the table."""
    keep_compiled()
    folder = out / case.name
    kept = calibrated(case, data, folder, out / "models")
    comparison = comparison_of(kept.calibration, kept.measurement, (), kept.provenance)
    COMPARISON_JSON.write(folder / "comparison.json", comparison)
    changes = laboratory_changes(case, out / "laboratory")
    verdict = judged(comparison, changes)
    row = _row(case, comparison, verdict, kept.seconds)
    write_whole(folder / "sentences.json", row)
    return row


def _row(case: Case, comparison: Comparison, verdict: Judged, seconds: float) -> dict[str, Any]:
    return {
        "case": case.name,
        "hidden": case.detail,
        "does": verdict.does,
        "excess": comparison.chi2_after / comparison.values,
        "sentences": [finding.text for finding in comparison.findings] or [NOTHING],
        "plain": verdict.plain,
        "mark": verdict.mark,
        "why": verdict.why,
        "main": verdict.main,
        "seconds": seconds,
    }


def table(rows: Sequence[Mapping[str, Any]]) -> str:
    lines = [
        "| case | hidden | what it does (laboratory) | mean squared misfit | findings | right? |",
        "|---" * 6 + "|",
    ]
    for row in rows:
        statements = "; ".join(f"**{text}**" if i == 0 else text for i, text in enumerate(row["sentences"]))
        cells = (row["case"].removeprefix("case_"), row["hidden"], row["does"], f"{row['excess']:.3g}", statements)
        why = row["why"] or ("" if row["main"] or row["hidden"] == "nothing" else "not of what changes most")
        lines.append("| " + " | ".join((*cells, f"{row['mark']}; {why}" if why else row["mark"])) + " |")
    effects = [r for r in rows if r["hidden"] != "nothing"]
    right = [r for r in effects if r["mark"].startswith("yes")]
    plain = [r for r in effects if r["mark"] == "yes"]
    nulls = [r for r in rows if r["hidden"] == "nothing"]
    quiet = sum(r["mark"] == "yes" for r in nulls)
    lines.append(
        f"\n{len(right)} of {len(effects)} right, {len(plain)} of them with the sign that the effect has by itself, "
        f"{sum(r['main'] for r in right)} of the quantity that it changes most; "
        f"nothing said in {quiet} of {len(nulls)} with nothing hidden."
    )
    return "\n".join(lines)


def main(
    data: Annotated[Path, typer.Option(help="folder with data/, as of make_data.py")] = Layout().folder,
    out: Annotated[Path, typer.Option(help="folder for calibrations and models")] = HERE / "sentences",
    only: Only = None,
    docs: Annotated[Path, typer.Option(help="file whose table is written anew")] = DOCS,
    jobs: Annotated[int, typer.Option(min=1, help="processes")] = 1,
) -> None:
    """Calibrate, say, judge, and write the table."""
    for preset in (FITTED, *FINER[FITTED]):
        build(RIG, preset, out / "models")
    wanted = chosen_cases(None, only or USED)
    work = partial(judge_case, data=Layout(data), out=out)
    in_turn(work, wanted, jobs, "sentences", lambda row: str(row["sentences"][0]))
    done = [read(out / case / "sentences.json") for case in USED]
    text, rows = docs.read_text(encoding="utf-8"), [row for row in done if row is not None]
    head, rest = text.split(BEGIN)
    docs.write_text(f"{head}{BEGIN}\n{table(rows)}\n{END}{rest.split(END)[1]}", encoding="utf-8")


if __name__ == "__main__":
    typer.run(main)
