"""Branches to be predicted, one after the other or by several processes with one thread each.

Whoever needs branches is handed a function from tasks to branches, and need not know where they are traced. The model
goes to a process with every task: 0.3 MB with 36 contacts, some MB with 146, which is milliseconds beside the seconds
of a branch. Branches come back without matrices (`observed_point.py`).
"""

from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager
from dataclasses import dataclass
from itertools import chain
from typing import Protocol

import numpy as np
from numpy.typing import NDArray

from updamp.comparison.prediction.moved_branch import move_sweeps
from updamp.comparison.prediction.parameters import Parametrisation
from updamp.comparison.prediction.predicted_branch import PredictedBranch
from updamp.comparison.prediction.run_condition import RunCondition
from updamp.comparison.prediction.traced_branch import trace_sweeps
from updamp.hbm.continuation.continuation import BranchStoppedError, ContinuationOptions
from updamp.parallel.processes import processes
from updamp.parallel.workers import Elsewhere, LongestFirst, WorkerLostError, Workers

Floats = NDArray[np.float64]
# Called with every branch that is done: its test's name, how many are done, of how many.
Report = Callable[[str, int, int], None]


class PredictionError(RuntimeError):
    """A branch that could not be predicted; the message begins with its test's name."""


@dataclass(frozen=True, eq=False)
class BranchTask:
    """u: (p,) parameters; near: the same test's branch at other parameters, moved from there where that works
    options: of the continuation; others: tests that sweep the same branch in another direction or window"""

    parametrisation: Parametrisation
    u: Floats
    condition: RunCondition
    near: PredictedBranch | None = None
    options: ContinuationOptions | None = None
    others: tuple[RunCondition, ...] = ()

    @property
    def conditions(self) -> tuple[RunCondition, ...]:
        return self.condition, *self.others

    @property
    def effort(self) -> float:
        """Larger for a branch that is likely to take longer: by its points, where these are known, else its force."""
        p = self.parametrisation
        if self.near is not None:
            return float(len(self.near.points))
        return self.condition.force * p.base.time_samples * p.base.harmonics.n_coefficients

    def predicted(self) -> tuple[PredictedBranch, ...]:
        """Of its tests.

        raises: BranchStoppedError where the branch has no beginning; PredictionError for anything else, both naming
        the test"""
        try:
            moved = self._moved(self.near) if self.near is not None else None
            return moved or trace_sweeps(self.parametrisation, self.u, self.conditions, self.options)
        except BranchStoppedError as stop:
            raise stop.of(self.condition.name) from stop
        except Exception as error:  # whatever it is, the user is to know where
            raise PredictionError(f"{self.condition.name}: {type(error).__name__}: {error}") from error

    def _moved(self, near: PredictedBranch) -> tuple[PredictedBranch, ...] | None:
        return move_sweeps(self.parametrisation, self.u, near, self.conditions, self.options)


class Branches(Protocol):
    """From tasks to the branches of their tests, in the same order; the numbers do not depend on how it is done."""

    def __call__(self, tasks: Sequence[BranchTask]) -> tuple[PredictedBranch, ...]:
        """raises: as `BranchTask.predicted`"""


@dataclass(frozen=True)
class InTurn:
    """In this process, one after the other."""

    report: Report = lambda _name, _done, _of: None

    def __call__(self, tasks: Sequence[BranchTask]) -> tuple[PredictedBranch, ...]:
        found = []
        for task in tasks:
            found.append(task.predicted())
            self.report(task.condition.name, len(found), len(tasks))
        return tuple(chain.from_iterable(found))


in_turn = InTurn()


@dataclass(frozen=True)
class BranchesBy:
    """By workers, the branches that are likely to take longest first. report: called in this process"""

    workers: Workers
    report: Report = in_turn.report

    def __call__(self, tasks: Sequence[BranchTask]) -> tuple[PredictedBranch, ...]:
        """raises: as `BranchTask.predicted`; PredictionError where a worker was ended from outside"""
        names: list[str] = []

        def done(place: int, _: tuple[PredictedBranch, ...]) -> None:
            names.append(tasks[place].condition.name)
            self.report(names[-1], len(names), len(tasks))

        try:
            found = LongestFirst(self.workers, _effort)(_predicted, None, tasks, done)
            return tuple(chain.from_iterable(found))
        except WorkerLostError as error:
            raise PredictionError(f"{tasks[error.place].condition.name}: {error}") from error


def _effort(task: BranchTask) -> float:
    return task.effort


def _predicted(_: None, task: BranchTask) -> tuple[PredictedBranch, ...]:
    return task.predicted()


@contextmanager
def by_processes(number: int, report: Report = in_turn.report) -> Iterator[BranchesBy]:
    """Processes for as long as the context lasts (`processes.py`)."""
    with processes(number) as pool:
        yield BranchesBy(Elsewhere(pool), report)
