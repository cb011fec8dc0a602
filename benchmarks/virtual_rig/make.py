"""Measurements from the virtual laboratory.

.venv/bin/python benchmarks/virtual_rig/make.py OUT [--hide NAME:STRENGTH ...] [--seed N]
"""

from updamp.parallel.resources import one_thread

one_thread()  # before numpy is loaded: threads make small products many times slower

from dataclasses import replace
from pathlib import Path
from typing import Annotated

import typer
from rich.console import Console

from updamp.benchmarks.virtual_rig.laboratory import HIDDEN, hidden
from updamp.benchmarks.virtual_rig.measurement import RIG, make_measurement
from updamp.benchmarks.virtual_rig.plan import QUIET, SIX_CURVES, NoiseLevels, TestPlan
from updamp.model.rig_files import load_rig


def main(
    out: Annotated[Path, typer.Argument(help="folder to write into")],
    hide: Annotated[list[str], typer.Option(help=f"NAME:STRENGTH, NAME one of {', '.join(HIDDEN)}")] = [],  # noqa: B006
    seed: int = 0,
    assemblies: int = 3,
    points: Annotated[int, typer.Option(help="of each run")] = 40,
    both_ways: Annotated[bool, typer.Option(help="sweep upwards too")] = False,
    corners: Annotated[bool, typer.Option(help="measure the damper's corners too")] = False,
    uff: Annotated[bool, typer.Option(help="write UFF58 too")] = False,
    quiet: Annotated[bool, typer.Option(help="no noise, no scatter")] = False,
    rig: Path = RIG,
    preset: Annotated[str, typer.Option(help="the laboratory's mesh, of the rig file")] = "laboratory",
) -> None:
    """Six curves on several assemblies, with measurement.toml and the sealed truth."""
    console = Console(stderr=True)
    runs = SIX_CURVES + tuple(replace(run, upwards=True) for run in SIX_CURVES if both_ways)
    plan = TestPlan(runs, assemblies, points, corners=corners, uff=uff)
    try:
        effects = [hidden(*(text.split(":", 1) if ":" in text else (text, "medium"))) for text in hide]
    except ValueError as error:
        console.print(f"[red]{error}[/red]")
        raise typer.Exit(2) from None
    noise = QUIET if quiet else NoiseLevels()
    with console.status("measuring") as status:
        make_measurement(out, plan, effects, seed, noise, load_rig(rig), preset, progress=status.update)
    console.print(f"written into {out}")


if __name__ == "__main__":
    typer.run(main)
