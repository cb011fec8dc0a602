"""Data of all cases from the virtual laboratory, the truth beside but apart. Resumable.

.venv/bin/python benchmarks/hidden_effects/make_data.py [--draw N] [--out FOLDER] [--jobs N] [--only case_012 ...]
"""

from updamp.parallel.resources import one_thread

one_thread()  # before numpy is loaded: threads make small products many times slower

import time
from collections.abc import Mapping
from dataclasses import dataclass
from functools import partial
from pathlib import Path
from typing import Annotated, Any

import typer

from updamp.benchmarks.hidden_effects.cases import Case
from updamp.benchmarks.hidden_effects.in_turn import in_turn
from updamp.benchmarks.hidden_effects.layout import Layout, read, write_whole
from updamp.benchmarks.hidden_effects.version_2 import Draw, Only, chosen_cases
from updamp.benchmarks.virtual_rig.bodies import bodies_of
from updamp.benchmarks.virtual_rig.measurement import make_measurement
from updamp.model.rig_files import load_rig
from updamp.rig.rig import Rig


@dataclass(frozen=True)
class Made:
    """points: recorded, of those planned; jumps: of all runs; seconds: of wall time"""

    case: str
    points: int
    planned: int
    jumps: int
    seconds: float


def make_case(case: Case, layout: Layout, rig: Rig | None = None) -> Made:
    """Measurement and truth; the truth last, so that what has one is complete. rig: that of the test by default"""
    test = case.kind_of_test
    plan = test.plan
    started = time.perf_counter()
    rig = rig or load_rig(test.rig)
    folder = layout.data(case.name)
    draws = layout.truth(case.name).with_suffix(".draws.json")
    draws.parent.mkdir(parents=True, exist_ok=True)
    layout.truth(case.name).unlink(missing_ok=True)
    make_measurement(
        folder, plan, case.hidden, case.seed, test.noise, rig, case.laboratory, sealed=draws, options=test.solver
    )
    record = read(draws) or {}
    seconds = time.perf_counter() - started
    write_whole(layout.truth(case.name), truth_of(case, record, seconds))
    draws.unlink()
    runs = record["runs"]
    planned = len(runs) * plan.points
    lost, jumps = (sum(len(run[key]) for run in runs) for key in ("lost", "jumps"))
    return Made(case.name, planned - lost, planned, jumps, seconds)


def truth_of(case: Case, record: Mapping[str, Any], seconds: float) -> dict[str, Any]:
    """record: every draw of the laboratory, as `make_measurement` seals it"""
    return {
        "case": case.name, "digest": case.digest, "kind": case.kind, "strength": case.strength, "test": case.test,
        "in_catalogue": case.in_catalogue, "effects": list(case.effects), "parameters": case.catalogue_values,
        "seed": case.seed, "laboratory": case.laboratory, "fitted": case.fitted, "repeats": case.repeats,
        "seconds": seconds, "record": record,
    }  # fmt: skip


def is_made(case: Case, layout: Layout) -> bool:
    truth = read(layout.truth(case.name))
    return truth is not None and truth["digest"] == case.digest and layout.measurement(case.name).is_file()


def main(
    out: Annotated[Path, typer.Option(help="folder for data/ and truth/")] = Layout().folder,
    jobs: Annotated[int, typer.Option(min=1, help="processes")] = 1,
    only: Only = None,
    draw: Draw = None,
    reveal: Annotated[bool, typer.Option("--list", help="list the cases, truth and all, and make nothing")] = False,
) -> None:
    layout = Layout(out)
    wanted = chosen_cases(draw, only)
    if reveal:
        for case in wanted:
            made = "made" if is_made(case, layout) else "-"
            typer.echo(f"{case.name}  {case.test:<8} {case.kind:<10} {made:<5} {case.detail}")
        return
    open_cases = [case for case in wanted if not is_made(case, layout)]
    typer.echo(f"{len(wanted) - len(open_cases)} of {len(wanted)} cases are made already")
    # Once for all: processes that start together would each compute the same finite elements.
    for rig, preset in {(case.kind_of_test.rig, case.laboratory) for case in open_cases}:
        bodies_of(load_rig(rig), preset)
    try:
        in_turn(partial(make_case, layout=layout), open_cases, jobs, "measuring", _line)
    except RuntimeError as error:
        typer.echo(error, err=True)
        raise typer.Exit(1) from None


def _line(made: Made) -> str:
    jumps = f", {made.jumps} jumps" if made.jumps else ""
    return f"{made.points} of {made.planned} points{jumps}, {made.seconds:.0f} s"


if __name__ == "__main__":
    typer.run(main)
