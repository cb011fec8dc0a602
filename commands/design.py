"""Commands of design studies: `updamp design`, `design-rig`, `explain`."""

from pathlib import Path
from typing import Annotated

import typer
from rich.console import Console
from rich.text import Text

from updamp.commands.shared import (
    Debug,
    JobsOfStudy,
    Mesh,
    OutOfStudy,
    RigFile,
    chosen_jobs,
    chosen_mesh,
    clean_errors,
    interruptible,
    out_option,
)
from updamp.parallel.ending import INTERRUPTED
from updamp.parallel.resources import one_thread

# What a command needs is imported when it is called, as everywhere in this folder.


def design(
    study: Annotated[Path, typer.Argument(metavar="STUDY", help="Study file, such as rigs/studies/friction.toml.")],
    out: OutOfStudy = None,
    jobs: JobsOfStudy = None,
    scheduler: Annotated[
        str,
        typer.Option(metavar="ADDRESS", help="Of a Dask scheduler whose workers solve designs, in the same folders."),
    ] = "",
    debug: Debug = False,
) -> None:
    """Run a design study on a rig: variables, responses, objectives, constraints and a method, stated in STUDY.

    Every design is kept as soon as it is solved; the same command goes on after an interruption. What a design shares
    with another one (mesh, finite elements) is computed once. Writes designs.csv and .parquet, study.json, study.html.
    docs/design_studies.md has all words of a study file.
    """
    with clean_errors(debug), interruptible():
        one_thread()
        from updamp.design.outputs import best_table, write_outputs
        from updamp.design.run_study import run_study
        from updamp.design.study_file import read_study
        from updamp.hbm.compilation_cache import keep_compiled
        from updamp.workflow.progress import Display

        keep_compiled()
        read, console = read_study(study), Console()
        folder = out or read.out
        if folder is None:
            raise ValueError(f"{study}: no folder is stated; add out to [study], or give --out")
        with Display(console) as display:
            result = run_study(read, folder, chosen_jobs(read.jobs if jobs is None else jobs), scheduler, display)
            display.done("files", ", ".join(write_outputs(result)))
        console.print(best_table(result, console.width))
        for note in result.method.notes if result.method else ():
            console.print(Text.assemble(("note      ", "yellow"), note), soft_wrap=True)
        console.print(f"{folder}", highlight=False, soft_wrap=True)
        if result.method is None:
            typer.echo("Interrupted. What is solved is kept; to go on run the same command again.", err=True)
            raise typer.Exit(INTERRUPTED)


def design_rig(
    folder: Annotated[Path, typer.Argument(metavar="DIR", help="Folder of a study.")],
    number: Annotated[int, typer.Argument(metavar="NUMBER", help="Of the design, as in designs.csv.")],
    out: Annotated[Path, out_option("The new rig file.")],
    replace: Annotated[bool, typer.Option("--replace", help="Replace the file where it is there already.")] = False,
    debug: Debug = False,
) -> None:
    """Write the rig file of a design: that of the study with the design's values, its windows moved with the modes.

    updamp run, compare and diagnose take it as it is.
    """
    with clean_errors(debug):
        from updamp.design.design_rig import write_design_rig

        write_design_rig(folder, number, out, replace)
        Console().print(f"{out}", highlight=False, soft_wrap=True)


def explain(
    rig: RigFile,
    against: Annotated[Path, typer.Option(metavar="OLD", help="Rig file whose products are there already.")],
    mesh: Mesh = None,
    debug: Debug = False,
) -> None:
    """Say what a changed rig file would run again in the folder of the old one, and which inputs make it so.

    Mesh and finite elements take most of the time: what leaves them alone is quick to try.
    """
    with clean_errors(debug):
        from updamp.model.rig_files import load_with_dimensions
        from updamp.workflow.explain import explain as compare_rigs
        from updamp.workflow.explain import explain_table, other_changes

        new, old, console = load_with_dimensions(rig), load_with_dimensions(against), Console()
        verdicts = compare_rigs(new, old, chosen_mesh(rig, mesh))
        console.print(explain_table(verdicts))
        for one in other_changes(new, old, verdicts):
            console.print(Text.assemble(("kept by  ", "dim"), f"{one.path}: {one.old} -> {one.new}"), soft_wrap=True)
