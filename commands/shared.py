"""What all commands of the command line share: their arguments, and how errors and interruptions reach a person."""

import shlex
import signal
import sys
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from types import FrameType
from typing import Annotated

import typer

BAD_INPUT, INCOMPLETE, INTERRUPTED = 2, 1, 130

RigFile = Annotated[Path, typer.Argument(metavar="RIG", help="Rig file, such as rigs/pesaresi2017.toml.")]
Debug = Annotated[bool, typer.Option("--debug", help="Show the traceback of an error.")]


@contextmanager
def clean_errors(debug: bool) -> Iterator[None]:
    """What a person can mend comes as a sentence; a mistake in the program keeps its traceback.

    The project's own errors derive from ValueError, RuntimeError and ImportError.
    """
    try:
        yield
    except KeyboardInterrupt:
        command = shlex.join(["updamp", *sys.argv[1:]])
        typer.echo(
            f"\nInterrupted. What is solved so far is kept; to go on from there run again:\n  {command}", err=True
        )
        raise typer.Exit(INTERRUPTED) from None
    except typer.Exit:
        raise
    except (ValueError, RuntimeError, ImportError, OSError) as error:
        if debug:
            raise
        typer.echo(f"error: {error}", err=True)
        raise typer.Exit(BAD_INPUT) from None


@contextmanager
def interruptible() -> Iterator[None]:
    """A request to terminate is treated like Ctrl-C, so that checkpoints are written."""

    def interrupt(number: int, frame: FrameType | None) -> None:  # noqa: ARG001
        raise KeyboardInterrupt

    before = signal.signal(signal.SIGTERM, interrupt)
    try:
        yield
    finally:
        signal.signal(signal.SIGTERM, before)
