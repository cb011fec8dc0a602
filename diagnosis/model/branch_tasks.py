"""Branches to be predicted, and the plainest way to do that: one after the other.

Whoever needs branches is handed a function from tasks to branches, and need not know where they are traced
(`branch_processes.py` does it in several processes).
"""

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Protocol

import numpy as np
from numpy.typing import NDArray

from updamp.diagnosis.model.condition import Condition
from updamp.diagnosis.model.moved_branch import move_branch
from updamp.diagnosis.model.parameters import Parametrisation
from updamp.diagnosis.model.predicted_branch import PredictedBranch, trace_branch
from updamp.hbm.continuation import BranchStoppedError, ContinuationOptions

Floats = NDArray[np.float64]
# Told of every branch that is done: its test's name, how many are done, of how many.
Report = Callable[[str, int, int], None]


class PredictionError(RuntimeError):
    """A branch that could not be predicted; the message begins with its test's name."""


@dataclass(frozen=True, eq=False)
class BranchTask:
    """u: (p,) parameters; near: the same test's branch at other parameters, moved from there where that works
    options: of the continuation"""

    parametrisation: Parametrisation
    u: Floats
    condition: Condition
    near: PredictedBranch | None = None
    options: ContinuationOptions | None = None

    @property
    def effort(self) -> float:
        """Larger for a branch that is likely to take longer: by its points, where these are known, else its force."""
        p = self.parametrisation
        if self.near is not None:
            return float(len(self.near.points))
        return self.condition.force * p.base.time_samples * p.base.harmonics.n_coefficients

    def predicted(self) -> PredictedBranch:
        """raises: BranchStoppedError where the branch has no beginning; PredictionError for anything else, both naming
        the test"""
        try:
            moved = self._moved(self.near) if self.near is not None else None
            return moved or trace_branch(self.parametrisation, self.u, self.condition, self.options)
        except BranchStoppedError as stop:
            raise stop.of(self.condition.name) from stop
        except Exception as error:  # whatever it is, the user is to be told where
            raise PredictionError(f"{self.condition.name}: {type(error).__name__}: {error}") from error

    def _moved(self, near: PredictedBranch) -> PredictedBranch | None:
        return move_branch(self.parametrisation, self.u, near, self.options)


class Branches(Protocol):
    """From tasks to their branches, in the same order; the numbers do not depend on how it is done."""

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
        return tuple(found)


in_turn = InTurn()
