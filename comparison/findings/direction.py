"""What every kind of misfit can be asked (the kinds are in `kinds.py`), and how far off the model is in one of them.

A misfit is a direction in the residual of the curves, a combination of what is read off peaks, or the ratio of what is
read off resonances. A kind need not be told in all three ways.
"""

from abc import ABC, abstractmethod
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from typing import ClassVar, TypeVar

import numpy as np
from numpy.typing import NDArray

from updamp.comparison.comparison import Finding
from updamp.comparison.fit.matching import Matched
from updamp.comparison.fit.observations import Plan

Floats = NDArray[np.float64]
Sensor = tuple[str, int]  # point of the model, harmonic

ALL = -1  # in place of a test: what is the same in all of them


@dataclass(frozen=True)
class Direction(ABC):
    """A kind of misfit and where it is. test: place of the condition in the plan

    quantity: name in `Finding`, and so in stored comparisons
    modes_share: whether modes that agree share a sentence
    """

    quantity: ClassVar[str]
    modes_share: ClassVar[bool]

    test: int = ALL

    @property
    def in_all_tests(self) -> "Direction":
        """The same, wherever it is."""
        return replace(self, test=ALL)

    # Along whole curves, to first order.

    @classmethod
    def along_curves(cls, plan: Plan) -> "Sequence[Direction]":  # noqa: ARG003
        """Those of the kind that are estimated together with all others; none of a kind that others make up."""
        return ()

    @abstractmethod
    def prior(self, plan: Plan) -> float:
        """Size that it is expected to have, of the logarithm: keeps what the data do not tell at zero."""

    def column(self, m: Matched, sensors: Sequence[Sensor], parameters: Sequence[str]) -> Floats:
        """(values,) what a unit of it takes from the residual of a run; nothing where the run is of another test.

        sensors: of the run's condition; parameters: names of the fitted ones
        """
        if not self.is_in(m.observations.test, sensors):
            return np.zeros(m.residual.size)
        return self.taken(m, sensors, parameters).ravel()

    def is_in(self, test: int, sensors: Sequence[Sensor]) -> bool:  # noqa: ARG002
        return self.test in (ALL, test)

    @abstractmethod
    def taken(self, m: Matched, sensors: Sequence[Sensor], parameters: Sequence[str]) -> Floats:
        """`column` of a run that it is in, by point."""

    @classmethod
    def stated(
        cls,
        rows: "Mapping[Direction, Floats]",
        damping_share: Sequence[float],
        misfit: "Callable[[Direction, Floats], Misfit]",
    ) -> "Iterator[Misfit]":
        """What is said of those that were estimated: each by itself.

        rows: combination of all estimates that each is; damping_share: as for `misfits`; misfit: of a combination
        """
        for direction, row in rows.items():
            if isinstance(direction, cls):
                yield misfit(direction, row * direction.share(damping_share))

    def share(self, damping_share: Sequence[float]) -> float:  # noqa: ARG002
        """By how much what is said of it changes with what is estimated."""
        return 1.0

    @classmethod
    @abstractmethod
    def sentences(cls, found: "Sequence[Misfit]", standing: "Sequence[Misfit]", plan: Plan) -> Sequence[Finding]:
        """On misfits of the kind. found: misfits of all kinds; standing: those that stand out"""

    # At peaks.

    @classmethod
    def at_tops(cls, test: int, sensors: Sequence[Sensor]) -> "Sequence[tuple[Direction, Floats]]":  # noqa: ARG003
        """Those that are read off the tops of a test, each as a combination of their values (2 s,): frequencies at the
        sensors, and logarithms of heights."""
        return ()

    def unit(self, half_width: float, sensors: int) -> float:  # noqa: ARG002
        """Logarithm by which it is off where some amplitude is wrong by as much as the peak's height.

        half_width: of the resonance, relative; sensors: how many
        """
        return 1.0

    @abstractmethod
    def subject(self, plan: Plan, names: Mapping[str, str], plural: bool) -> tuple[str, str]:
        """What reads high or low, and the channel, "" of no one.

        names: of channels, by point of the model; plural: of several modes
        """


@dataclass(frozen=True)
class Misfit:
    """relative: model over measurement less 1; deviation: its standard deviation"""

    direction: Direction
    relative: float
    deviation: float

    @property
    def significance(self) -> float:
        return self.relative / self.deviation if self.deviation > 0 else 0.0

    @property
    def size(self) -> float:
        """Of the logarithm: as much for twice as for half of what was measured."""
        return abs(float(np.log1p(self.relative)))


One = TypeVar("One")


def farthest_first(ones: Sequence[One], against: Callable[[One, Sequence[One]], Misfit | None]) -> Iterator[Misfit]:
    """How far each sensor is from the others: the farthest first, which the next ones are not held against. Of two,
    which are as far from each other, the first.

    against: misfit of one sensor against others, None where it cannot be told
    """
    left = list(ones)
    while len(left) > 1:
        each = {one: found for one in left if (found := against(one, [s for s in left if s != one])) is not None}
        if not each:
            return
        worst = max(each, key=lambda one: round(abs(each[one].significance), 6))
        yield each[worst]
        left.remove(worst)
