"""Commands of a prediction: `updamp run`, `check`, `show`."""

import math
from collections.abc import Iterator, Mapping, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer
from rich.console import Console
from rich.text import Text

from updamp.commands.shared import INCOMPLETE, Debug, Jobs, Mesh, RigFile, clean_errors, interruptible, out_option
from updamp.parallel.resources import Meter, one_thread_for_numpy, usual_workers
from updamp.workflow import stages

# What a command needs is imported when it is called: JAX, scikit-fem, matplotlib and pydantic take 1 to 3 s each to
# load, of which `updamp --help`, another command or the message of a mistyped option would have nothing.
if TYPE_CHECKING:
    from updamp.rig.rig import Rig
    from updamp.workflow.products import Products
    from updamp.workflow.run_options import RunOptions


Out = Annotated[Path, out_option("Folder for all that is written; the same one to resume or to reuse.")]
Modes = Annotated[list[str] | None, typer.Option(help="Only this mode of the study; may be repeated.")]
Forces = Annotated[list[str] | None, typer.Option(help='Only this amplitude, such as "3.84 N"; may be repeated.')]
Pictures = Annotated[bool, typer.Option(help="Whether to draw pictures.")]
Check = Annotated[bool, typer.Option(help="Whether to compare the reduced with the full coupled model.")]
Accuracy = Annotated[
    bool,
    typer.Option(
        help="Whether to state every curve's error, traced again with more harmonics: two to four times as long."
    ),
]
Stability = Annotated[
    bool, typer.Option(help="Whether to say of every point whether it is stable: a third of the curves' time.")
]
Marching = Annotated[
    bool,
    typer.Option(help="Whether to march a few periods in time from every curve's peak, to see whether it stays."),
]
Resonance = Annotated[
    bool, typer.Option(help="Whether to follow every mode's resonance in the force: peak against force as a line.")
]
Quick = Annotated[
    bool,
    typer.Option(
        "--quick",
        "-q",
        help="Responses and peaks first: no stability, no numerical error, no curve at the highest force, where the "
        "followed resonance gives the peak. The same command without it goes on from there.",
    ),
]
Until = Annotated[str | None, typer.Option(help=f"Last stage: {', '.join(s.name for s in stages.STAGES)}.")]


def run(
    rig: RigFile,
    out: Out,
    mesh: Mesh = None,
    jobs: Jobs = None,
    mode: Modes = None,
    force: Forces = None,
    pictures: Pictures = True,
    check: Check = True,
    accuracy: Accuracy = True,
    stability: Stability = True,
    marching: Marching = True,
    resonance: Resonance = True,
    quick: Quick = False,
    until: Until = None,
    debug: Debug = False,
) -> None:
    """Run all stages: mesh, finite elements, static contact, response curves.

    A stage or curve whose input has not changed is taken from its file, so that after an interruption the same command
    goes on with what is missing.
    """
    with clean_errors(debug), interruptible():
        one_thread_for_numpy()

        forces, last = _forces(force or ()), _stage(until)
        with Meter() as meter:
            from updamp.model.rig_files import load_with_dimensions

            loaded = load_with_dimensions(rig)
            from updamp.workflow.run_options import RunOptions  # once the rig file is known to be sound

            preset = mesh if mesh is not None else next(iter(loaded.mesh))
            workers = jobs if jobs is not None else usual_workers()
            options = RunOptions(
                preset, out, workers, tuple(dict.fromkeys(mode or ())), forces,
                check=check, pictures=pictures, accuracy=accuracy, stability=stability, marching=marching,
                resonance=resonance, quick=quick, until=last,
            )  # fmt: skip
            complete = _run(loaded, options, meter)
    if not complete:
        raise typer.Exit(INCOMPLETE)


def _run(rig: "Rig", options: "RunOptions", meter: Meter) -> bool:
    """Whether every curve crossed its window and every picture was drawn."""
    from updamp.hbm.compilation_cache import keep_compiled
    from updamp.rig.questions import questions
    from updamp.workflow.output_folder import make_folder
    from updamp.workflow.progress import Display
    from updamp.workflow.quick_look import not_checked
    from updamp.workflow.run import Run
    from updamp.workflow.run_outputs import summarise, write_outputs
    from updamp.workflow.summary import write_summary
    from updamp.workflow.summary_tables import curves_table

    keep_compiled()  # what pictures evaluate the contact law for
    console = Console()
    with Display(console) as display:
        this = Run(rig, options, display)
        make_folder(options.folder)
        display.log = options.folder / "log.txt"
        for question in questions(rig):
            display.note("question", question)
        products = this.products()
        made, undrawn = write_outputs(this, products)
        display.done("files", ", ".join(made) or "all as they were")
        for sentence in not_checked(products, options) if this.wanted(stages.CURVE) else ():
            display.note("not checked", sentence)
    summary = summarise(this, products, meter.seconds, meter.peak_memory)
    path = options.folder / "summary.json"
    write_summary(path, summary)
    if summary.get("curves"):
        console.print(curves_table(summary["curves"]))
    for mark, line in _remarks(products, summary):
        console.print(Text.assemble((mark, "yellow"), line), soft_wrap=True)
    problems = [*_problems(products, summary), *([undrawn] if undrawn else [])]
    for line in problems:
        console.print(Text.assemble(("not complete ", "red"), line), soft_wrap=True)
    if part := summary.get("part", ""):
        console.print(Text.assemble(("part      ", "yellow"), part), soft_wrap=True)
    console.print(f"{path} after {summary['timing_s']['total']:.1f} s", highlight=False, soft_wrap=True)
    return not problems


def _remarks(products: "Products", summary: Mapping[str, Any]) -> Iterator[tuple[str, str]]:
    """What is to be known of modes and peaks, each with what it begins with."""
    from updamp.workflow.detached_summary import coexisting
    from updamp.workflow.followed_summary import different_peaks
    from updamp.workflow.marching_summary import moving_peaks
    from updamp.workflow.quick_look import ended_early, peak_sentences, peaks_followed
    from updamp.workflow.stability_summary import doubtful_peaks

    curves = summary.get("curves", ())
    yield from (("names     ", line) for line in summary.get("misnamed_modes", ()))
    followed = (*peak_sentences(peaks_followed(products)), *different_peaks(curves), *ended_early(products))
    yield from (("followed  ", line) for line in followed)
    yield from (("stability ", line) for line in doubtful_peaks(curves))
    yield from (("in time ", line) for line in moving_peaks(curves))
    yield from (("beside it ", line) for line in coexisting(curves))


def _problems(products: "Products", summary: Mapping[str, Any]) -> Iterator[str]:
    """What the run was to find and has not."""
    from updamp.workflow.quick_look import not_followed

    yield from (f"{c['mode']} {c['force_N']:g} N: {c['problem']}" for c in summary.get("curves", ()) if c["problem"])
    yield from (f"{name}: {message}" for name, message in summary.get("failed_curves", {}).items())
    yield from not_followed(products)


def _forces(texts: Sequence[str]) -> tuple[float, ...]:
    """[N], each once, in whatever unit it was said."""
    found: list[float] = []
    for force in map(_force, texts):
        if not any(math.isclose(force, known) for known in found):
            found.append(force)
    return tuple(found)


def _force(text: str) -> float:
    from updamp.rig.fields import Quantity

    try:
        return Quantity("N", "10 N", above=0).to_si(text)
    except ValueError as error:
        raise ValueError(f"--force {text}: {error}") from None


def _stage(name: str | None) -> stages.Stage | None:
    known = {stage.name: stage for stage in stages.STAGES}
    if name is not None and name not in known:
        raise ValueError(f"--until {name}: the stages are {', '.join(known)}")
    return known[name] if name else None


def check(rig: RigFile, debug: Debug = False) -> None:
    """Read a rig file and explain it: every value in SI, and what follows from them."""
    with clean_errors(debug):
        from updamp.model.rig_files import load_any
        from updamp.parallel.resources import free_memory
        from updamp.rig.modal_tables import modes_table
        from updamp.rig.questions import questions
        from updamp.rig.rig import Rig
        from updamp.rig.tables import derived_table, sizes_table, values_table

        loaded, console = load_any(rig), Console()
        console.print(values_table(loaded))
        if isinstance(loaded, Rig):
            console.print(derived_table(loaded))
            console.print(sizes_table(loaded, free_memory()))
            for question in questions(loaded):
                console.print(Text.assemble(("question  ", "yellow"), question), soft_wrap=True)
        else:
            console.print(modes_table(loaded))


def show(folder: Annotated[Path, typer.Argument(metavar="DIR", help="Folder of a run.")], debug: Debug = False) -> None:
    """Show what a run found."""
    with clean_errors(debug):
        from updamp.workflow.summary import read_summary
        from updamp.workflow.summary_tables import curves_table, overview_table

        summary, console = read_summary(folder), Console()
        console.print(overview_table(summary))
        if summary.get("curves"):
            console.print(curves_table(summary["curves"]))
