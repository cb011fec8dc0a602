"""What all commands of the command line share: their arguments, and how errors and interruptions reach a person."""

import errno
import shlex
import sys
from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from pathlib import Path
from typing import Annotated, Any

import typer

from updamp.parallel.ending import INTERRUPTED, Command, heard
from updamp.parallel.resources import checked_workers, usual_workers

BAD_INPUT, INCOMPLETE = 2, 1


def named_path(text: str) -> Path:
    """raises: typer.BadParameter where nothing is named: Path("") is the current folder, which nobody asked for"""
    if not text.strip():
        raise typer.BadParameter('nothing is named; give a path, such as results ("." is the folder you are in)')
    return Path(text)


def out_option(meaning: str, show_default: bool | str = True) -> Any:
    """The option --out of a command. meaning: its line of help"""
    return typer.Option("--out", "-o", parser=named_path, metavar="<path>", help=meaning, show_default=show_default)


RigFile = Annotated[Path, typer.Argument(metavar="RIG", help="Rig file, such as rigs/pesaresi2017.toml.")]
Mesh = Annotated[
    str | None,
    typer.Option(
        "--mesh", "-m", help="Mesh preset of the rig file; small for first looks.", show_default="the rig file's first"
    ),
]
Jobs = Annotated[
    int | None,
    typer.Option("--jobs", "-j", help="Processes at the same time.", show_default="the CPUs, at most 4"),
]
Finer = Annotated[
    list[str] | None,
    typer.Option(
        help="Preset with a finer mesh or more contact elements: what it changes counts as numerical error. "
        "May be repeated; `none` for none.",
        show_default="the next finer ones of the rig file",
    ),
]
OutOfRun = Annotated[Path, out_option("Folder for all that is written; that of a run, to use its model.")]
OutOfStudy = Annotated[Path | None, out_option("Folder for all that is written.", "`out` of the study file")]
JobsOfStudy = Annotated[
    int | None,
    typer.Option(
        "--jobs",
        "-j",
        min=1,
        help="Processes at the same time.",
        show_default="`jobs` of STUDY, or the CPUs, at most 4",
    ),
]
Debug = Annotated[bool, typer.Option("--debug", help="Show the traceback of an error.")]


def chosen_mesh(rig: Path, mesh: str | None) -> str:
    """The preset that is asked for, or the first of the rig file; raises: RigError"""
    from updamp.model.rig_files import load_any

    presets = getattr(load_any(rig), "mesh", {})
    return mesh if mesh is not None else next(iter(presets), "")


def chosen_names(names: Sequence[str] | None) -> tuple[str, ...] | None:
    """Those that are asked for, "none" for none; None, for the usual ones, where nothing is said"""
    if not names:
        return None
    return tuple(name for name in names if name != "none")


def chosen_jobs(jobs: int | None) -> int:
    """raises: ValueError where the memory does not hold as many"""
    return checked_workers(usual_workers() if jobs is None else jobs)


@contextmanager
def clean_errors(debug: bool) -> Iterator[None]:
    """What a person can mend comes as a sentence; a mistake in the program keeps its traceback.

    The project's own errors derive from ValueError, RuntimeError and ImportError.
    """
    try:
        yield
    except KeyboardInterrupt:
        typer.echo(_go_on(), err=True)
        raise typer.Exit(INTERRUPTED) from None
    except typer.Exit:
        raise
    except (ValueError, RuntimeError, ImportError, OSError) as error:
        if debug:
            raise
        typer.echo(f"error: {_of_system(error) if isinstance(error, OSError) else error}", err=True)
        raise typer.Exit(BAD_INPUT) from None


def _of_system(error: OSError) -> str:
    """What the operating system refused, where nobody nearer to it said so: of a full disk it names no file."""
    if error.strerror is None:
        return str(error)
    if error.errno in (errno.ENOSPC, errno.EDQUOT) or error.filename is None:
        place = error.filename or "a file"
        return (
            f"{place}: {error.strerror}; make room on the disk of --out, and run the same again: what is done is kept"
        )
    return f"{error.filename}: {error.strerror}; give another path"


@contextmanager
def interruptible() -> Iterator[None]:
    """SIGTERM is treated like Ctrl-C: what is solved is stored, and all processes end within 10 s."""
    command = Command(_go_on)
    try:
        yield
    except KeyboardInterrupt:
        heard()
        raise
    finally:
        command.over()


def _go_on() -> str:
    command = shlex.join(["updamp", *sys.argv[1:]])
    return f"\nInterrupted. What is finished is kept; to go on from there run again:\n  {command}"
