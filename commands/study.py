"""The command of parameter studies: `updamp study`."""

from pathlib import Path
from typing import Annotated

import typer
from rich.console import Console

from updamp.commands.shared import Debug, JobsOfStudy, OutOfStudy, chosen_jobs, clean_errors, interruptible
from updamp.parallel.ending import INTERRUPTED
from updamp.parallel.resources import one_thread

# What the command needs is imported when it is called, as everywhere in this folder.


def study(
    file: Annotated[Path, typer.Argument(metavar="STUDY", help="Study file, such as rigs/studies/pesaresi2017.toml.")],
    mesh: Annotated[
        str | None,
        typer.Option("--mesh", "-m", help="Mesh preset of the rig file.", show_default="`mesh` of the study file"),
    ] = None,
    out: OutOfStudy = None,
    jobs: JobsOfStudy = None,
    solve: Annotated[bool, typer.Option(help="Whether to trace curves; without, what is there is shown.")] = True,
    debug: Debug = False,
) -> None:
    """Run a parameter study: response curves of many variants of a rig, their pictures, findings that are checked.

    Every curve is kept as soon as it is traced; the same command goes on after an interruption. Writes study.html,
    study.json and pictures. docs/parameter_study.md has all words of a study file.
    """
    with clean_errors(debug), interruptible():
        one_thread()
        from updamp.hbm.compilation_cache import keep_compiled
        from updamp.parameter_study.outputs import check_findings, findings_table, write_outputs
        from updamp.parameter_study.run_study import run_parameter_study
        from updamp.parameter_study.study_file import read_parameter_study
        from updamp.workflow.progress import Display

        keep_compiled()
        read, console = read_parameter_study(file, mesh), Console()
        with Display(console) as display:
            run = run_parameter_study(
                read, out or read.out, chosen_jobs(read.jobs if jobs is None else jobs), display, solve
            )
            findings = check_findings(run.result)
            display.done("files", ", ".join(write_outputs(run.result, findings, display)))
        if findings:
            console.print(findings_table(findings))
        console.print(f"{run.result.folder / 'study.html'}", highlight=False, soft_wrap=True)
        if run.interrupted:
            typer.echo("Interrupted. What is traced is kept; to go on run the same command again.", err=True)
            raise typer.Exit(INTERRUPTED)
