"""What harmonic balance costs: on the problem other codes were measured on, on the rig, and how it grows.

    .venv/bin/python benchmarks/bench.py                       (the rig from results/pesaresi2017, see `make run`)
    .venv/bin/python benchmarks/bench.py --run FOLDER --workers 1

Prints tables; writes bench.json and, beside it, bench_growth.png.
"""

import json
import subprocess
import sys
from pathlib import Path
from typing import Annotated, Any

import typer
from rich.console import Console

from updamp.benchmarks.harmonic_balance.growth import draw, growth
from updamp.benchmarks.harmonic_balance.peers_problem import costs
from updamp.benchmarks.harmonic_balance.results import Results
from updamp.benchmarks.harmonic_balance.rig_curves import RIG, all_curves, point_cost, stages_of
from updamp.model.rig_files import load_rig

RESULTS = Path(__file__).parents[1] / "results"
SENSITIVITY_COST = Path(__file__).with_name("sensitivity_cost.py")


def main(
    out: Annotated[Path, typer.Option(help="file to write")] = RESULTS / "bench.json",
    run: Annotated[Path, typer.Option(help="folder of a run of the rig at full size")] = RESULTS / "pesaresi2017",
    stress: Annotated[Path, typer.Option(help="result of the stress grid")] = RESULTS / "stress.json",
    sensitivities: Annotated[Path, typer.Option(help="cost of sensitivities; measured where it is missing")] = RESULTS
    / "sensitivities.json",
    workers: Annotated[int, typer.Option(help="processes for the ten curves")] = 2,
    threads: Annotated[int, typer.Option(help="at most so many, 1 or 2, where both are measured")] = 2,
    ten: Annotated[bool, typer.Option(help="whether to trace all ten curves: minutes")] = True,
) -> None:
    """Measure, print and write."""
    console = Console(width=160)
    stages, rig = stages_of(run), load_rig(RIG)
    console.print("146 contacts, the problem of the peers ...")
    problem = costs(threads)
    console.print("sensitivities ...")
    if not sensitivities.is_file():  # in a process of its own, with one thread
        subprocess.run([sys.executable, SENSITIVITY_COST, "--out", sensitivities], check=True)
    console.print("a curve of the rig ...")
    point = point_cost(stages) if stages is not None else None
    if ten:
        console.print(f"the ten curves of the rig, {workers} workers ...")
    curves = all_curves(stages, rig, workers) if stages is not None and ten else None
    console.print("growth with contacts and harmonics ...")
    grown = growth()
    results = Results(problem, point, curves, grown, _kept(stress), _kept(sensitivities))
    results.show(console)
    results.write(out)
    picture = out.with_name("bench_growth.png")
    draw(grown, picture)
    console.print(f"{out}, {picture}", soft_wrap=True)


def _kept(path: Path) -> dict[str, Any] | None:
    return json.loads(path.read_text(encoding="utf-8")) if path.is_file() else None


if __name__ == "__main__":
    typer.run(main)
