"""How a diagnosis grows with the number of curves and of effects, up to where the first fit of an effect would begin.

.venv/bin/python benchmarks/triage_growth.py --data FOLDER [--mesh diagnosis] [--jobs 2] [--curves 4 --curves 8]

FOLDER: of benchmarks/full_resolution.py, whose measurement is taken, all eight curves or some of them. Prints a table
and writes FOLDER/growth_MESH.json; what the file has is not measured again.
"""

import json
import os
import time
from collections.abc import Callable, Sequence
from pathlib import Path
from typing import Annotated

from updamp.parallel.resources import thread_limits

# Before numpy and jax are loaded, here and in the processes that are started.
os.environ.update(thread_limits(1))

import typer
from rich.console import Console
from rich.table import Table

from updamp.benchmarks.hidden_effects.fitted_model import FINER
from updamp.benchmarks.hidden_effects.layout import write_whole
from updamp.benchmarks.virtual_rig.measurement import RIG
from updamp.comparison.fit.observations import Plan, plan_of
from updamp.comparison.prediction.branch_tasks import BranchesBy
from updamp.diagnosis.candidate_models.baseline import baseline
from updamp.diagnosis.candidate_models.refit import fails_badly
from updamp.diagnosis.score_tests.probe import probes
from updamp.diagnosis.score_tests.signature import extend
from updamp.effects.catalogue import CATALOGUE
from updamp.effects.effect import Effect
from updamp.hbm.compilation_cache import keep_compiled
from updamp.parallel.processes import processes
from updamp.parallel.workers import Elsewhere, Workers
from updamp.workflow.comparison_inputs import CompareFiles, ComparisonInputs, comparison_inputs
from updamp.workflow.progress import Display

# Of the eight curves: the levels of each mode, lowest and highest first.
ORDER = (0, 3, 1, 2)
STEPS = ("prediction and numerical error", "calibration", "signatures", "probes")


def some(plan: Plan, curves: int) -> Plan:
    """So many curves, of both modes in turn."""
    modes = tuple(dict.fromkeys(c.mode for c in plan.conditions))
    by_mode = {mode: [i for i, c in enumerate(plan.conditions) if c.mode == mode] for mode in modes}
    wanted = [by_mode[mode][i] for i in ORDER for mode in modes][:curves]
    return plan.only(sorted(wanted))


def effect_sets() -> dict[str, tuple[Effect, ...]]:
    """Their number in words -> effects: some that have derivatives, all of these, and all."""
    every = tuple(CATALOGUE.values())
    smooth = tuple(e for e in every if not e.finite_step)
    return {
        f"{len(smooth[:4])} with derivatives": smooth[:4],
        f"{len(smooth)} with derivatives": smooth,
        f"{len(every)}, {len(every) - len(smooth)} of them by finite steps": every,
    }


def seconds(
    inputs: ComparisonInputs, plan: Plan, sets: Sequence[tuple[Effect, ...]], workers: Workers
) -> tuple[int, list[dict[str, float]]]:
    """Number of curves that are fitted to, and for each set of effects what each step takes."""
    marks: list[float] = [time.perf_counter()]

    def note_time(step: str) -> None:
        if step == "calibration":
            marks.append(time.perf_counter())

    branches_of = BranchesBy(workers)
    start = baseline(inputs.before_effects, inputs.rig_effects, plan, inputs.finer, None, note_time, branches_of)
    shared = {STEPS[0]: marks[1] - marks[0], STEPS[1]: time.perf_counter() - marks[1]}
    found = []
    for effects in sets:
        of_signatures = _timed(lambda effects=effects: extend(start.fitted, start.train_plan, effects, workers=workers))
        badly = fails_badly(start.fitted)
        of_probes = _timed(lambda effects=effects: probes(start, effects, workers=workers)) if badly else 0.0
        found.append({**shared, STEPS[2]: of_signatures, STEPS[3]: of_probes})
    return len(start.training), found


def _timed(work: Callable[[], object]) -> float:
    begun = time.perf_counter()
    work()
    return time.perf_counter() - begun


def show(rows: Sequence[dict[str, object]], console: Console) -> None:
    table = Table("curves", "fitted to", "effects", *(f"{step} [s]" for step in STEPS))
    for row in rows:
        steps = row["seconds"]
        assert isinstance(steps, dict)
        table.add_row(
            str(row["curves"]), str(row["fitted to"]), str(row["effects"]), *(f"{steps[s]:.0f}" for s in STEPS)
        )
    console.print(table)


def main(
    data: Annotated[Path, typer.Option(help="folder of full_resolution.py")] = Path("full"),
    mesh: Annotated[str, typer.Option(help=f"preset that is fitted: {', '.join(FINER)}")] = "diagnosis",
    jobs: Annotated[int, typer.Option(min=1, help="processes")] = 2,
    curves: Annotated[list[int], typer.Option(min=2, max=8, help="measured; repeatable")] = [4, 6, 8],  # noqa: B006
) -> None:
    """Measure and print."""
    if mesh not in FINER:
        raise typer.BadParameter(f"--mesh {mesh}: one of {', '.join(FINER)} is wanted")
    keep_compiled()
    console, out = Console(width=160), data / f"growth_{mesh}.json"
    files = CompareFiles(RIG, data / "data" / "measurement.toml", data / f"growth_{mesh}")
    with Display(console) as display:
        inputs = comparison_inputs(files, mesh, jobs, display, FINER[mesh])
    plan, sets = plan_of(inputs.measurement), effect_sets()
    rows = json.loads(out.read_text(encoding="utf-8"))["rows"] if out.is_file() else []
    with processes(jobs) as pool:
        workers = Elsewhere(pool, keep_compiled=True)
        # what is compiled at first use is not to be measured with the first row
        seconds(inputs, some(plan, 2), list(sets.values())[-1:], workers)
        for number in curves:
            if any((row["curves"], row["jobs"]) == (number, jobs) for row in rows):
                continue
            trained, found = seconds(inputs, some(plan, number), list(sets.values()), workers)
            rows += [
                {"curves": number, "fitted to": trained, "jobs": jobs, "effects": name, "seconds": steps}
                for name, steps in zip(sets, found, strict=True)
            ]
            write_whole(out, {"rows": rows})
            console.print(f"{number} curves are done")
    show(rows, console)
    console.print(str(out), soft_wrap=True)


if __name__ == "__main__":
    typer.run(main)
