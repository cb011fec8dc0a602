"""Predictor and corrector: how the points of one branch follow each other.

A corrector that fails shortens the step. Where no shorter step helps, the recoveries of the options follow in turn
(hbm/continuation/recovery). First is what is exact, the far side's own tangent at a kink; then what may pass over
something.
"""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Protocol

from updamp.hbm.continuation.branch import BranchPoint
from updamp.hbm.continuation.corrector import Corrector, StepOptions
from updamp.hbm.continuation.recovery.jump import Jump
from updamp.hbm.continuation.recovery.lowering_step import LoweringStep
from updamp.hbm.continuation.recovery.switch_branch import SwitchBranch
from updamp.hbm.continuation.retracing import TracedBranch
from updamp.hbm.newton.newton import Status


class Recovery(Protocol):
    """A way on beyond a place where no step is solved, however small. Immutable: its numbers are options."""

    def __call__(self, corrector: Corrector, traced: TracedBranch) -> Sequence[BranchPoint]:
        """The next points; none where it finds no way on."""
        ...


# Without jumps: for branches of which every part is wanted.
CONNECTED: tuple[Recovery, ...] = (SwitchBranch(), LoweringStep())


@dataclass(frozen=True)
class ContinuationOptions(StepOptions):
    """recoveries: tried in turn where the corrector fails at the smallest step
    outside: where no first point is found at the end of the window, so far beyond it, in shares of its width;
        negative: so far inside it
    max_points: at most this many points a branch

    raises: ValueError naming the option that is out of range
    """

    recoveries: tuple[Recovery, ...] = (*CONNECTED, Jump())
    outside: tuple[float, ...] = (-0.01, -0.04, 0.1, 0.3)
    max_points: int = 2000

    def __post_init__(self) -> None:
        super().__post_init__()
        if self.max_points < 2:
            raise ValueError(f"max_points = {self.max_points}: at least 2")


class BranchStoppedError(RuntimeError):
    """A branch that cannot go on. What was computed has been handed out already.

    whose: name of the branch, where the message is to say it
    """

    def __init__(self, frequency: float, error: float, status: Status, whose: str = "") -> None:
        self.frequency, self.error, self.status, self.whose = frequency, error, status, whose
        super().__init__(
            f"{whose}{': ' if whose else ''}the branch stops at {frequency:.6g} Hz: {status.value}, residual "
            f"{error:.1e} of the displacement; {status.advice}"
        )

    def of(self, whose: str) -> "BranchStoppedError":
        return BranchStoppedError(self.frequency, self.error, self.status, whose)

    def __reduce__(self) -> tuple[type["BranchStoppedError"], tuple[float, float, Status, str]]:
        return BranchStoppedError, (self.frequency, self.error, self.status, self.whose)


@dataclass(frozen=True, eq=False)
class PredictorCorrector(Corrector):
    """Finds the next points of a branch from those traced so far."""

    options: ContinuationOptions

    def next_points(self, traced: TracedBranch, step: float) -> tuple[Sequence[BranchPoint], float]:
        """The next point, or those beyond a jump, and the step to try after them.

        raises: BranchStoppedError
        """
        options, asked_for = self.options, step
        while True:
            point, solution = self.step(traced, step)
            if point is not None:
                return [point], options.following(step, point.step, solution.iterations, step < asked_for)
            if step <= options.smallest_step:
                break
            step = options.shortened(step)
        for recovery in options.recoveries:
            if points := recovery(self, traced):
                return points, options.recovered(points[-1].step)
        raise BranchStoppedError(traced.last.frequency, solution.errors[-1], solution.status)
