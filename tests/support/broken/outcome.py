"""A broken input, and what a person is told of it."""

from collections.abc import Callable
from dataclasses import dataclass
from enum import Enum
from pathlib import Path

from typer.testing import CliRunner

from updamp.commands.shared import BAD_INPUT
from updamp.pipeline import app


class Outcome(Enum):
    """CLEAR: every wanted word is said. UNCLEAR: refused in other words. ACCEPTED: not refused, the words not said.
    CRASH: an error that is none of the project's own, or a process that dies"""

    CLEAR = "clear"
    UNCLEAR = "unclear"
    ACCEPTED = "accepted"
    CRASH = "crash"


@dataclass(frozen=True)
class Told:
    """refused: whether the work does not begin; said: all that the person reads"""

    refused: bool
    said: str


@dataclass(frozen=True)
class Broken:
    """words: those that a clear answer has (file, key, value, remedy); give: hands the input over, made in the folder

    welcome: an input that is to be taken as it was meant, with these words said, if any
    """

    name: str
    words: tuple[str, ...]
    give: Callable[[Path], Told]
    welcome: bool = False


class CrashError(Exception):
    """A command ended with an error that is none of the project's own."""


def outcome(case: Broken, folder: Path) -> tuple[Outcome, str]:
    try:
        told = case.give(folder)
    except Exception as error:
        return Outcome.CRASH, f"{type(error).__name__}: {error}"
    there = all(word.lower() in " ".join(told.said.split()).lower() for word in case.words)
    if case.welcome and told.refused:
        return Outcome.UNCLEAR, told.said
    if there and "Traceback" not in told.said:
        return Outcome.CLEAR, told.said
    return (Outcome.UNCLEAR if told.refused else Outcome.ACCEPTED), told.said


def command(*arguments: object) -> Told:
    """`updamp ...`; raises: CrashError where it does not end by itself"""
    result = CliRunner().invoke(app, [str(argument) for argument in arguments])
    if result.exception is not None and not isinstance(result.exception, SystemExit):
        raise CrashError(f"{type(result.exception).__name__}: {result.exception}") from result.exception
    return Told(result.exit_code == BAD_INPUT, result.output)


def call(work: Callable[[], object]) -> Told:
    """A function of the project: what it returns, in words, or its refusal. What a command would not catch crashes."""
    try:
        said = work()
    except (ValueError, RuntimeError, ImportError, OSError) as error:
        return Told(True, str(error))
    return Told(False, str(said))
