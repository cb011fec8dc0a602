"""A step whose Newton tangents keep a part of the contacts' stiffness in the mean position."""

from collections.abc import Sequence
from dataclasses import dataclass, replace

from updamp.hbm.continuation.branch import BranchPoint
from updamp.hbm.continuation.corrector import Corrector
from updamp.hbm.continuation.retracing import TracedBranch


@dataclass(frozen=True)
class SupportedStep:
    """The predictor is as good as without: from a residual of 1e-10 the exact step leads far away (`NewtonOptions`).

    supports: shares of stiffness that are tried; lengths: of the steps, in units of arc

    raises: ValueError naming a support that is out of range
    """

    supports: tuple[float, ...] = (0.0, 1e-5, 1e-3)
    lengths: tuple[float, ...] = (0.01, 1e-3, 1e-4)

    def __post_init__(self) -> None:
        if not all(0 <= support < 1 for support in self.supports):
            raise ValueError(f"supports = {self.supports}: each at least 0 and below 1")

    def __call__(self, corrector: Corrector, traced: TracedBranch) -> Sequence[BranchPoint]:
        options = corrector.options
        if 0 not in corrector.system.harmonics.orders:
            return []
        for support in (s for s in self.supports if s != traced.last.solution.support):
            for length in options.no_shorter(self.lengths):
                point, _ = corrector.step(traced, length, replace(options.newton, support=support))
                if point is not None:
                    return [point]
        return []
