"""Commands that find missing effects and take them up: `updamp diagnose`, `add`, `remove`, `history`."""

from pathlib import Path
from typing import TYPE_CHECKING, Annotated

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
    out_option,
)
from updamp.parallel.resources import one_thread

# On call, as everywhere in this folder: JAX takes seconds to load, and has to find the number of threads stated.
if TYPE_CHECKING:
    from updamp.workflow.add import Changed

Out = Annotated[
    Path | None, out_option("The new rig file; RIG itself to change it.", show_default="RIG's name and EFFECT's")
]


HoldOut = Annotated[
    list[str] | None,
    typer.Option(
        help="Run that no fit is to see; may be repeated.",
        show_default="the second highest level of each mode with three or more",
    ),
]
HoldOutMode = Annotated[
    list[str] | None,
    typer.Option(
        metavar="MODE",
        help="Mode of which no fit is to see a run: the verdict is judged on it. May be repeated, and besides "
        "--hold-out.",
    ),
]
OwnEffect = Annotated[
    list[Path] | None, typer.Option(help="Python file of an effect of your own to look for; may be repeated.")
]
Dimensions = Annotated[
    list[str] | None,
    typer.Option(
        help="Dimension of the rig to look at whether it is other than stated, such as face_length: the model is built "
        "once more for each. May be repeated; `none` for none.",
        show_default="all that updamp knows",
    ),
]
Scheduler = Annotated[
    str, typer.Option(metavar="ADDRESS", help="Of a Dask scheduler whose workers trace branches and run fits.")
]
NextMeasurement = Annotated[
    bool, typer.Option(help="Look for the measurement that would tell apart what is left; takes a minute or two.")
]


def diagnose(
    rig: RigFile,
    measurement: Annotated[Path, typer.Argument(metavar="MEASUREMENT", help="measurement.toml.")],
    out: OutOfRun,
    mesh: Mesh = None,
    finer: Finer = None,
    hold_out: HoldOut = None,
    hold_out_mode: HoldOutMode = None,
    effect: OwnEffect = None,
    dimensions: Dimensions = None,
    jobs: Jobs = None,
    scheduler: Scheduler = "",
    next_measurement: NextMeasurement = True,
    debug: Debug = False,
) -> None:
    """Say which physical effect the model lacks: diagnosis.json and report.html.

    Effects of the catalogue are tried on some of the runs and judged on the others. What was found so far is kept, and
    a search that was stopped goes on from there.
    """
    with clean_errors(debug), interruptible():
        one_thread()
        from updamp.hbm.compilation_cache import keep_compiled
        from updamp.workflow.comparison_inputs import CompareFiles
        from updamp.workflow.diagnose_run import DiagnoseOptions
        from updamp.workflow.diagnose_run import diagnose as search_effects

        keep_compiled()
        held_out, modes = tuple(hold_out) if hold_out else None, tuple(hold_out_mode or ())
        own, workers = tuple(effect or ()), chosen_jobs(jobs)
        options = DiagnoseOptions(
            chosen_names(finer), held_out, modes, own, workers, scheduler, next_measurement=next_measurement,
            dimensions=chosen_names(dimensions),
        )  # fmt: skip
        files, console = CompareFiles(rig, measurement, out), Console()
        verdict = search_effects(files, chosen_mesh(rig, mesh), options, console)
        console.print(Text.assemble((f"{verdict.verdict}   ", "yellow"), verdict.sentence), soft_wrap=True)
        console.print(f"{files.report}", highlight=False, soft_wrap=True)


def add(
    rig: RigFile,
    effect: Annotated[
        list[str] | None,
        typer.Argument(metavar="EFFECT", help="Effects to add; those that were identified where none is named."),
    ] = None,
    folder: Annotated[
        Path | None, typer.Option("--from", metavar="DIR", help="Folder of updamp diagnose, with diagnosis.json.")
    ] = None,
    out: Out = None,
    replace: Annotated[
        bool, typer.Option("--replace", help="Replace the values of an effect, or a file, that is there already.")
    ] = False,
    with_calibration: Annotated[
        bool, typer.Option("--with-calibration", help="Take along what was calibrated together with the effects.")
    ] = False,
    file: Annotated[
        list[Path] | None, typer.Option(help="Python file of an effect of your own; may be repeated.")
    ] = None,
    debug: Debug = False,
) -> None:
    """Write a new rig file with effects that a diagnosis found, at their fitted values.

    updamp run and updamp compare take it as it is. Effects stack: add to the new file again.
    """
    with clean_errors(debug):
        from updamp.workflow.add import AddOptions
        from updamp.workflow.add import add as add_effects

        if folder is None:
            raise ValueError(f"--from: missing; give the folder of: updamp diagnose {rig} MEASUREMENT --out DIR")
        _show(add_effects(rig, effect or (), folder, AddOptions(out, replace, with_calibration, tuple(file or ()))))


def remove(
    rig: RigFile,
    effect: Annotated[list[str], typer.Argument(metavar="EFFECT", help='Effects to take off, or "calibration".')],
    out: Out = None,
    replace: Annotated[bool, typer.Option("--replace", help="Replace the new file where it is there already.")] = False,
    debug: Debug = False,
) -> None:
    """Write a new rig file without some of the effects that the rig file has taken up."""
    with clean_errors(debug):
        from updamp.workflow.add import remove as remove_effects

        _show(remove_effects(rig, effect, out, replace))


def history(
    rig: RigFile,
    picture: Annotated[
        Path | None, typer.Option(metavar="FILE", help="Draw how the error fell with each step, as PNG.")
    ] = None,
    debug: Debug = False,
) -> None:
    """Show which effects were added to a rig file and how the error fell with each of them."""
    with clean_errors(debug):
        from updamp.workflow.history import draw_history, history_file, history_table, read_history

        found, console = read_history(rig), Console()
        if not found.steps:
            raise ValueError(f"{history_file(rig)}: no history yet; it begins with: updamp add {rig} EFFECT --from DIR")
        console.print(history_table(f"History of {rig.name}", found))
        if picture is not None:
            draw_history(picture, f"History of {rig.name}", found)
            console.print(f"{picture}", highlight=False, soft_wrap=True)


def _show(changed: "Changed") -> None:
    from updamp.workflow.history import History, history_table

    console = Console()
    console.print(history_table(f"{changed.rig}", History((changed.step,))))
    for note in changed.notes:
        console.print(Text.assemble(("note      ", "yellow"), note), soft_wrap=True)
    console.print(f"{changed.rig}", highlight=False, soft_wrap=True)
