"""What is tried where the corrector fails even at the smallest step."""

from collections.abc import Sequence
from typing import Protocol

from updamp.hbm.continuation.branch import BranchPoint
from updamp.hbm.continuation.corrector import Corrector
from updamp.hbm.continuation.retracing import TracedBranch


class Recovery(Protocol):
    """A way on beyond a place where no step is solved. Immutable: its numbers are options."""

    def __call__(self, corrector: Corrector, traced: TracedBranch) -> Sequence[BranchPoint]:
        """The next points; none where it finds no way on."""
        ...
