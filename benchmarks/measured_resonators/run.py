"""Resonators measured in a laboratory that is not updamp's, diagnosed by someone who sees the files alone. Resumable.

.venv/bin/python benchmarks/measured_resonators/run.py --seed N --out FOLDER [--jobs N] [--first N]

Results go to FOLDER/results.json, what was hidden beside what was said.
"""

import os
from collections import Counter
from dataclasses import asdict, dataclass
from pathlib import Path
from typing import Annotated

from updamp.parallel.resources import thread_limits

# Before numpy and jax are loaded, here and in the processes that are started.
os.environ.update(thread_limits(1))

import time

import numpy as np
import typer
from rich.console import Console

from updamp.benchmarks.harmonic_balance.results import commit_of_code
from updamp.benchmarks.hidden_effects.in_turn import in_turn
from updamp.benchmarks.hidden_effects.judgement import Called, judged
from updamp.benchmarks.hidden_effects.layout import read, write_whole
from updamp.benchmarks.measured_resonators.laws import LAWS
from updamp.benchmarks.measured_resonators.measured import FAULTS, measure
from updamp.hbm.compilation_cache import keep_compiled
from updamp.workflow.comparison_inputs import CompareFiles
from updamp.workflow.diagnose_run import DiagnoseOptions, diagnose

# What is hidden, and in how many resonators.
HIDDEN: dict[tuple[str, ...], int] = {
    (): 6,
    ("cubic",): 3,
    ("quadratic",): 3,
    ("microslip",): 3,
    ("coulomb",): 2,
    ("fading",): 1,
    ("phase",): 2,
    ("background",): 2,
    ("trend",): 2,
    ("cubic", "quadratic"): 2,
    ("cubic", "microslip"): 1,
    ("cubic", "coulomb"): 1,
    ("cubic", "phase"): 1,
    ("quadratic", "background"): 1,
    ("cubic", "background", "phase"): 2,
    ("cubic", "quadratic", "background"): 2,
    ("cubic", "quadratic", "background", "phase"): 2,
    ("threshold",): 2,
    ("quintic",): 3,
    ("clearance",): 3,
    ("clearance", "quadratic"): 1,
    ("square",): 2,
    ("saturating",): 2,
}


@dataclass(frozen=True)
class Case:
    name: str
    hidden: tuple[str, ...]
    seed: int
    folder: Path

    @property
    def expected(self) -> tuple[str, ...]:
        """In the catalogue's terms, "" for what it has no name for."""
        return tuple(FAULTS[name] if name in FAULTS else LAWS[name].called for name in self.hidden)


@dataclass(frozen=True)
class Outcome:
    """before, after, held_out: errors in units of the scatter, of the runs of the fit and of the others"""

    case: str
    hidden: tuple[str, ...]
    verdict: str
    effects: tuple[str, ...]
    group: tuple[str, ...]
    mark: str
    before: float
    after: float
    held_out: float
    sentence: str
    seconds: float
    commit: str


def cases(seed: int, out: Path) -> list[Case]:
    """In an order that is drawn: the first so many are a fair sample."""
    rng = np.random.default_rng(seed)
    wanted = [hidden for hidden, n in HIDDEN.items() for _ in range(n)]
    seeds = rng.choice(10**6, size=len(wanted), replace=False).tolist()
    order = rng.permutation(len(wanted)).tolist()
    names = [f"resonator_{number:02d}" for number in range(1, len(wanted) + 1)]
    return [Case(name, wanted[i], seeds[i], out / name) for name, i in zip(names, order, strict=True)]


def solve(case: Case) -> Outcome:
    keep_compiled()
    started = time.perf_counter()
    measure(case.seed, case.hidden, case.folder)
    files = CompareFiles(case.folder / "rig.toml", case.folder / "measurement.toml", case.folder / "verdict")
    options = DiagnoseOptions(report=False, next_measurement=False)
    found = diagnose(files, "", options, Console(quiet=True))
    effects, group = tuple(found.effects), tuple(found.group)
    said = judged("outside" if "" in case.expected else "", case.expected, Called(found.verdict, effects, group))
    error, seconds = found.error, time.perf_counter() - started
    outcome = Outcome(
        case.name, case.hidden, found.verdict, effects, group, said, error.before, error.after, error.held_out_after,
        found.sentence, seconds, commit_of_code(),
    )  # fmt: skip
    write_whole(case.folder / "outcome.json", asdict(outcome))
    return outcome


def _line(outcome: Outcome) -> str:
    return f"{outcome.mark}: {'+'.join(outcome.hidden) or 'nothing'}, {outcome.seconds:.0f} s"


def main(
    seed: Annotated[int, typer.Option(help="of all draws; to be drawn itself once the code is frozen")],
    out: Annotated[Path, typer.Option(help="folder of measurements, verdicts and results.json")],
    jobs: Annotated[int, typer.Option(min=1, help="processes")] = 1,
    first: Annotated[int | None, typer.Option(help="how many of them, in the order drawn; all by default")] = None,
) -> None:
    chosen = cases(seed, out)[:first]
    left = [case for case in chosen if not (case.folder / "outcome.json").is_file()]
    in_turn(solve, left, jobs, "resonators", _line)
    outcomes = [read(case.folder / "outcome.json") for case in chosen]
    write_whole(out / "results.json", {"seed": seed, "cases": outcomes})
    for text, count in Counter(o["mark"] for o in outcomes if o is not None).most_common():
        typer.echo(f"{text:<12} {count}")


if __name__ == "__main__":
    typer.run(main)
