"""The command that lays a model over a measurement: `updamp compare`."""

from pathlib import Path
from typing import Annotated

import typer
from rich.console import Console
from rich.text import Text

from updamp.commands.shared import Debug, RigFile, clean_errors, interruptible
from updamp.parallel.resources import one_thread, usual_workers


def compare(
    rig: RigFile,
    measurement: Annotated[
        Path, typer.Argument(metavar="MEASUREMENT", help="measurement.toml, or a file of stated features.")
    ],
    out: Annotated[Path, typer.Option(help="Folder for all that is written; that of a run, to use its model.")],
    mesh: Annotated[str, typer.Option(help="Preset of the rig file: small (first looks), medium or full.")] = "full",
    finer: Annotated[
        list[str],
        typer.Option(help="Preset with a finer mesh: what it changes counts as numerical error. Repeatable."),
    ] = [],  # noqa: B006
    jobs: Annotated[
        int | None,
        typer.Option(min=1, help="Branches traced at the same time.", show_default="the CPUs, at most 4"),
    ] = None,
    debug: Debug = False,
) -> None:
    """Lay the model over a measurement and say where it fails: comparison.json and report.html.

    What is known only roughly (stiffness, damping, friction) is fitted within its bounds first.
    """
    with clean_errors(debug), interruptible():
        one_thread()
        # On call: JAX takes seconds to load, and has to find the number of threads stated.
        from updamp.hbm.compilation_cache import keep_compiled
        from updamp.workflow.compare_run import CompareFiles, run_compare, sentences

        keep_compiled()
        console = Console()
        files = CompareFiles(rig, measurement, out)
        comparison, _ = run_compare(files, mesh, jobs if jobs is not None else usual_workers(), console, tuple(finer))
        for sentence in sentences(comparison):
            console.print(Text.assemble(("finding   ", "yellow"), sentence), soft_wrap=True)
        console.print(f"{files.report}", highlight=False, soft_wrap=True)
