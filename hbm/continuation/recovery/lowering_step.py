"""A step whose Newton iterates each lower the residual."""

from collections.abc import Sequence
from dataclasses import dataclass

from updamp.hbm.continuation.branch import BranchPoint
from updamp.hbm.continuation.corrector import Corrector
from updamp.hbm.continuation.retracing import TracedBranch


@dataclass(frozen=True)
class LoweringStep:
    """Full steps of Newton's method may go to and fro between two states of a contact for ever, however short the step.
    Where none of them is of use there is nothing to be lost by shortened ones, which end at kinks otherwise.

    A solution that was so hard to find may be another branch's: one with another orientation
    (hbm/continuation/recovery/switch_branch.py) does not count.

    lengths: of the steps, in units of arc
    """

    lengths: tuple[float, ...] = (0.01, 1e-3, 1e-4)

    def __call__(self, corrector: Corrector, traced: TracedBranch) -> Sequence[BranchPoint]:
        options = corrector.options
        for length in options.no_shorter(self.lengths):
            point, _ = corrector.step(traced, length, options.newton.lowering)
            if point is not None and point.orientation == traced.last.orientation:
                return [point]
        return []
