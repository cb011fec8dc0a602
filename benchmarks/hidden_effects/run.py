"""Diagnose all cases, blind. Resumable.

.venv/bin/python benchmarks/hidden_effects/run.py [--draw N] [--folder FOLDER] [--jobs N] [--only case_012 ...]
"""

import os
import shutil
import time
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from hashlib import sha256
from pathlib import Path
from typing import Annotated, Any

from updamp.parallel.resources import thread_limits

# Before numpy and jax are loaded, here and in the processes that are started.
os.environ.update(thread_limits(1))

import typer

from updamp.benchmarks.harmonic_balance.results import commit_of_code
from updamp.benchmarks.hidden_effects.cases import Case
from updamp.benchmarks.hidden_effects.fitted_model import FINER, build, build_dimensions, diagnose_case, place
from updamp.benchmarks.hidden_effects.in_turn import in_turn
from updamp.benchmarks.hidden_effects.layout import Layout, read, write_whole
from updamp.benchmarks.hidden_effects.version_2 import Draw, Only, chosen_cases
from updamp.diagnosis.verdict import VERDICT_JSON
from updamp.workflow.code_version import SEARCH, code_version


@dataclass(frozen=True)
class Task:
    """All that a diagnosis is given; nothing of the truth. rig: file; model: folder with stages of the fitted model"""

    name: str
    rig: Path
    preset: str
    measurement: Path
    model: Path
    out: Path

    @property
    def digest(self) -> str:
        """Of the measurement's files."""
        content = b"".join(path.read_bytes() for path in sorted(self.measurement.parent.iterdir()))
        return sha256(content).hexdigest()[:16]

    @property
    def done(self) -> bool:
        return self._ran.get("digest") == self.digest

    @property
    def by_this_version(self) -> bool:
        """Whether this version of updamp has given the verdict."""
        return self._ran.get("code") == code_version(*SEARCH)

    @property
    def _ran(self) -> Mapping[str, Any]:
        return read(self.out / "run.json") or {}


@dataclass(frozen=True)
class Ran:
    case: str
    verdict: str
    seconds: float


def diagnose(task: Task) -> Ran:
    """Verdict and time; run.json is written last, so that what has one is complete."""
    shutil.rmtree(task.out, ignore_errors=True)
    task.out.mkdir(parents=True)
    place(task.model, task.out, FINER[task.preset])
    started, processor = time.perf_counter(), time.process_time()
    verdict = diagnose_case(task.rig, task.preset, task.measurement, task.out)
    seconds, processor = time.perf_counter() - started, time.process_time() - processor
    VERDICT_JSON.write(task.out / "diagnosis.json", verdict)
    write_whole(
        task.out / "run.json",
        {
            "case": task.name, "digest": task.digest, "code": code_version(*SEARCH), "preset": task.preset,
            "seconds": seconds, "processor": processor, "commit": commit_of_code(),
        },
    )  # fmt: skip
    return Ran(task.name, verdict.verdict, seconds)


def tasks(layout: Layout, cases: Sequence[Case]) -> tuple[list[Task], list[str]]:
    """Of cases that have data, and names of those that have none."""
    found, missing = [], []
    for case in cases:
        if not layout.truth(case.name).is_file():
            missing.append(case.name)
            continue
        rig, out = case.kind_of_test.rig, layout.verdict(case.name)
        model = layout.models(rig) / case.fitted
        found.append(Task(case.name, rig, case.fitted, layout.measurement(case.name), model, out))
    return found, missing


def build_models(layout: Layout, found: Sequence[Task]) -> None:
    """All that the tasks fit, those of finer meshes and of other dimensions too; what is there is kept."""
    for rig, preset in dict.fromkeys((task.rig, task.preset) for task in found):
        for one in (preset, *FINER[preset]):
            build(rig, one, layout.models(rig))
        build_dimensions(rig, preset, layout.models(rig))


def main(
    folder: Annotated[Path, typer.Option(help="with data/; verdicts/ goes there")] = Layout().folder,
    jobs: Annotated[int, typer.Option(min=1, help="processes")] = 1,
    only: Only = None,
    draw: Draw = None,
    again: Annotated[bool, typer.Option("--again", help="those with a verdict too")] = False,
) -> None:
    """Diagnose every case that has data and no verdict yet."""
    layout = Layout(folder)
    found, missing = tasks(layout, chosen_cases(draw, only))
    if missing:
        typer.echo(f"{len(missing)} cases have no data yet (make_data.py): {', '.join(missing)}", err=True)
    left = [task for task in found if again or not task.done]
    typer.echo(f"{len(found) - len(left)} of {len(found)} cases are diagnosed already")
    if older := [task.name for task in found if task not in left and not task.by_this_version]:
        typer.echo(f"by another version of updamp: {', '.join(older)}; --again diagnoses them anew", err=True)
    build_models(layout, left)
    try:
        in_turn(diagnose, left, jobs, "diagnosing", lambda ran: f"{ran.verdict}, {ran.seconds:.0f} s")
    except RuntimeError as error:
        typer.echo(error, err=True)
        raise typer.Exit(1) from None


if __name__ == "__main__":
    typer.run(main)
