"""The command that lays a model over a measurement: `updamp compare`."""

from pathlib import Path
from typing import Annotated

import typer
from rich.console import Console
from rich.text import Text

from updamp.commands.shared import (
    Debug,
    Finer,
    Jobs,
    Mesh,
    OutOfRun,
    RigFile,
    chosen_jobs,
    chosen_mesh,
    chosen_names,
    clean_errors,
    interruptible,
)
from updamp.parallel.resources import one_thread


def compare(
    rig: RigFile,
    measurement: Annotated[
        Path, typer.Argument(metavar="MEASUREMENT", help="measurement.toml, or a file of stated features.")
    ],
    out: OutOfRun,
    mesh: Mesh = None,
    finer: Finer = None,
    jobs: Jobs = None,
    debug: Debug = False,
) -> None:
    """Lay the model over a measurement and say where it fails: comparison.json and report.html.

    What is known only roughly (stiffness, damping, friction) is fitted within its bounds first.
    """
    with clean_errors(debug), interruptible():
        one_thread()
        # On call: JAX takes seconds to load, and has to find the number of threads stated.
        from updamp.comparison.comparison import MOVED_BY_NUMERICS
        from updamp.hbm.compilation_cache import keep_compiled
        from updamp.report.sections.calibration import far_calibrated
        from updamp.report.sections.outcome import verdict_sentence
        from updamp.workflow.compare_run import run_compare
        from updamp.workflow.comparison_inputs import CompareFiles

        keep_compiled()
        console = Console()
        files = CompareFiles(rig, measurement, out)
        comparison, _ = run_compare(files, chosen_mesh(rig, mesh), chosen_jobs(jobs), console, chosen_names(finer))
        console.print(Text.assemble(("verdict   ", "yellow"), verdict_sentence(comparison)), soft_wrap=True)
        if moved := comparison.provenance.get(MOVED_BY_NUMERICS):
            console.print(Text.assemble(("numerics  ", "yellow"), f"{MOVED_BY_NUMERICS}: {moved}"), soft_wrap=True)
        if far := far_calibrated(comparison):
            console.print(Text.assemble(("calibrated", "yellow"), f" {far}"), soft_wrap=True)
        for finding in comparison.findings:
            console.print(Text.assemble(("finding   ", "yellow"), finding.text), soft_wrap=True)
        console.print(f"{files.report_of_comparison}", highlight=False, soft_wrap=True)
