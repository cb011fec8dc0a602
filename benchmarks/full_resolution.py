"""How long a diagnosis of eight curves takes with 146 contact elements, and which of its steps take it.

.venv/bin/python benchmarks/full_resolution.py [--out FOLDER] [--jobs 2] [--effect edge_gap:strong] [--curves 8]

The measurement comes from the virtual laboratory (docs/virtual_rig.md): three assemblies, 40 points a curve, all noise
and scatter. Writes FOLDER/times.json; a second run of the same folder goes on where the first was stopped, and its
times are then those of what was left.
"""

import json
import os
import time
from dataclasses import dataclass, field
from pathlib import Path
from typing import Annotated
from unittest.mock import patch

from updamp.parallel.resources import thread_limits

# Before numpy and jax are loaded, here and in the processes that are started.
os.environ.update(thread_limits(1))

import typer
from rich.console import Console

from updamp.benchmarks.hidden_effects.fitted_model import FINER, build, build_dimensions, place
from updamp.benchmarks.virtual_rig.laboratory import hidden
from updamp.benchmarks.virtual_rig.measurement import RIG, make_measurement
from updamp.benchmarks.virtual_rig.plan import NoiseLevels, PlannedRun, TestPlan
from updamp.diagnosis.verdict import Verdict
from updamp.hbm.compilation_cache import keep_compiled
from updamp.model.rig_files import load_rig
from updamp.workflow import diagnose_run as diagnosing
from updamp.workflow.comparison_inputs import CompareFiles
from updamp.workflow.progress import Display

FITTED, LABORATORY = "diagnosis_146", "laboratory"
LEVELS = {"IP": (2.0, 4.0, 6.0, 8.0), "OOP": (4.0, 12.0, 22.0, 32.0)}
SEED = 7
# What is told when the first fit of an effect has ended, and so the ranking of all of them before it.
_FITTED = "leaves"


@dataclass
class Clock:
    """What was told, and when [s]."""

    started: float = field(default_factory=time.perf_counter)
    steps: list[tuple[float, str]] = field(default_factory=list)

    def progress_bar(self, _: Display) -> "Clock":
        return self

    def __call__(self, step: str) -> None:
        at = time.perf_counter() - self.started
        self.steps.append((at, step))
        print(f"{at:7.1f} s  {step}", flush=True)

    def first(self, text: str) -> float | None:
        """When the first step that contains the text was told."""
        return next((at for at, step in self.steps if text in step), None)


def plan(curves: int) -> TestPlan:
    """So many curves, as many of each mode as can be, lowest and highest levels first."""
    order = (0, 3, 1, 2)
    wanted = [PlannedRun(mode, levels[i]) for i in order for mode, levels in LEVELS.items()][:curves]
    return TestPlan(tuple(sorted(wanted, key=lambda run: (run.mode, run.force))), assemblies=3, points=40)


def diagnose(out: Path, jobs: int, clock: Clock) -> Verdict:
    for preset in (FITTED, *FINER[FITTED]):
        build(RIG, preset, out / "models")
    build_dimensions(RIG, FITTED, out / "models")
    place(out / "models" / FITTED, out / "diagnosis", FINER[FITTED])
    keep_compiled()
    files = CompareFiles(RIG, out / "data" / "measurement.toml", out / "diagnosis")
    options = diagnosing.DiagnoseOptions(finer=FINER[FITTED], jobs=jobs)
    clock.started = time.perf_counter()
    with patch.object(diagnosing, "_progress_bar", clock.progress_bar):
        return diagnosing.diagnose(files, FITTED, options, Console(quiet=True))


def main(
    out: Annotated[Path, typer.Option(help="folder for data, models, diagnosis and times.json")] = Path("full"),
    jobs: Annotated[int, typer.Option(min=1, help="processes")] = 2,
    effect: Annotated[str, typer.Option(help="what is hidden, with its strength")] = "friction_gradient:medium",
    curves: Annotated[int, typer.Option(min=4, max=8, help="measured")] = 8,
) -> None:
    """Measure, diagnose, print."""
    name, _, strength = effect.partition(":")
    try:
        chosen = hidden(name, strength)
    except ValueError as error:
        raise typer.BadParameter(f"{effect}: {error}; give an effect and its strength, as edge_gap:strong") from error
    if not (out / "data" / "measurement.toml").is_file():
        make_measurement(out / "data", plan(curves), [chosen], SEED, NoiseLevels(), load_rig(RIG), LABORATORY)
    clock = Clock()
    verdict = diagnose(out, jobs, clock)
    seconds = time.perf_counter() - clock.started
    triage = clock.first(_FITTED)
    found = {
        "hidden": effect, "curves": curves, "jobs": jobs, "verdict": verdict.verdict, "effects": verdict.effects,
        "seconds": seconds, "first_fit_s": triage, "signatures_s": clock.first("signatures"), "steps": clock.steps,
    }  # fmt: skip
    (out / "times.json").write_text(json.dumps(found, indent=1) + "\n", encoding="utf-8")
    print(f"{curves} curves, {jobs} jobs, {effect}: {verdict.verdict} {', '.join(verdict.effects)}, {seconds:.0f} s")
    if triage is not None:
        print(f"signatures begin after {found['signatures_s']:.0f} s, the first fit ends after {triage:.0f} s")


if __name__ == "__main__":
    typer.run(main)
