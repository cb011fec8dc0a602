"""Branches predicted by several processes, each with one thread.

The model goes over with every task: 0.3 MB with 36 contacts, some MB with 146, which is milliseconds beside the
seconds of a branch. Branches come back without matrices (`light_points.py`).
"""

from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from dataclasses import dataclass

from updamp.diagnosis.model.branch_tasks import BranchTask, PredictionError, Report, in_turn
from updamp.diagnosis.model.predicted_branch import PredictedBranch
from updamp.diagnosis.model.processes import processes
from updamp.diagnosis.model.workers import Elsewhere, LongestFirst, WorkerLostError, Workers


@dataclass(frozen=True)
class BranchesBy:
    """report: called in this process"""

    workers: Workers
    report: Report = in_turn.report

    def __call__(self, tasks: Sequence[BranchTask]) -> tuple[PredictedBranch, ...]:
        """raises: as `BranchTask.predicted`; PredictionError where a worker was ended from outside"""
        names: list[str] = []

        def done(place: int, _: PredictedBranch) -> None:
            names.append(tasks[place].condition.name)
            self.report(names[-1], len(names), len(tasks))

        try:
            return tuple(LongestFirst(self.workers, _effort)(_predicted, None, tasks, done))
        except WorkerLostError as error:
            raise PredictionError(f"{tasks[error.place].condition.name}: {error}") from error


def _effort(task: BranchTask) -> float:
    return task.effort


def _predicted(_: None, task: BranchTask) -> PredictedBranch:
    return task.predicted()


@contextmanager
def by_processes(number: int, report: Report = in_turn.report) -> Iterator[BranchesBy]:
    """Processes for as long as the context lasts (`processes.py`)."""
    with processes(number) as pool:
        yield BranchesBy(Elsewhere(pool), report)
