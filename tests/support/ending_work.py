"""A run of two jobs to be interrupted: one looks whether it is to stop, one is in compiled code and never does."""

import ctypes
import os
import sys
import time
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path

import typer

from updamp.commands.shared import clean_errors, interruptible
from updamp.workflow.job_pool import JobEnd, run_all


def compiled_code() -> None:
    """A lock taken twice: blocks without the interpreter, whatever signal comes, and takes no processor time."""
    lock, library = ctypes.create_string_buffer(64), ctypes.CDLL(None)
    library.pthread_mutex_lock(lock)
    library.pthread_mutex_lock(lock)


@dataclass(frozen=True)
class Polite:
    output: Path
    name: str = "polite"
    key: str = ""
    ease: tuple[float, ...] = (0.0,)

    def run(self, report: object, should_stop: Callable[[], bool], memory_of: object) -> JobEnd:  # noqa: ARG002
        os.write(1, b"begun\n")
        while not should_stop():
            time.sleep(0.05)
        self.output.write_text("stored")
        return JobEnd.INTERRUPTED

    def said(self) -> tuple[bool, str]:
        return True, ""


@dataclass(frozen=True)
class Stubborn(Polite):
    name: str = "stubborn"

    def run(self, report: object, should_stop: Callable[[], bool], memory_of: object) -> JobEnd:  # noqa: ARG002
        os.write(1, b"begun\n")
        compiled_code()
        return JobEnd.FINISHED


class Deaf:
    def __del__(self) -> None:
        os.write(1, b"begun\n")
        time.sleep(60)


def main(folder: Path, where: str) -> None:
    """where: what compiled code blocks: "worker" or "command"; or "finaliser", that loses what is raised in it"""
    with clean_errors(False), interruptible():
        if where == "command":
            os.write(1, b"begun\n")
            compiled_code()
        if where == "finaliser":
            Deaf()
            time.sleep(60)
        jobs = [Polite(folder / "polite"), Stubborn(folder / "stubborn")]
        run_all(jobs, 2, lambda *_: None, lambda _: None)


if __name__ == "__main__":
    try:
        main(Path(sys.argv[1]), sys.argv[2])
    except typer.Exit as end:
        sys.exit(end.exit_code)
