"""The kinds of misfit: a mode's resonance or damping at a test, the amplitude of all sensors, and one sensor's gain.

A new kind is a class here, and its place in `KINDS`. How it can be told is in `direction.py`.
"""

from abc import abstractmethod
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from typing import ClassVar

import numpy as np
from numpy.typing import NDArray

from updamp.comparison.comparison import Backbone, Finding
from updamp.comparison.findings.direction import ALL, Direction, Misfit, Sensor, farthest_first
from updamp.comparison.findings.mode_sentence import mode_sentence
from updamp.comparison.findings.words import in_percent
from updamp.comparison.fit.matching import Matched
from updamp.comparison.fit.observations import Plan
from updamp.comparison.fit.scatter import Scatter
from updamp.model.calibration import LOSS_FACTOR

Floats = NDArray[np.float64]

# Steepest slope of an oscillator's amplitude, of its peak's height by the half-width.
_STEEPEST = 2 / (3 * np.sqrt(3))


@dataclass(frozen=True)
class OfMode(Direction):
    """What a mode has at each test. word: what it is called in sentences"""

    modes_share: ClassVar[bool] = False
    word: ClassVar[str]

    @classmethod
    def along_curves(cls, plan: Plan) -> Sequence[Direction]:
        return [cls(test) for test in range(len(plan.conditions))]

    @classmethod
    def sentences(cls, found: Sequence[Misfit], standing: Sequence[Misfit], plan: Plan) -> Sequence[Finding]:
        said: list[Finding] = []
        for mode in dict.fromkeys(c.mode for c in plan.conditions):
            of_mode = [
                m for m in found if isinstance(m.direction, cls) and plan.conditions[m.direction.test].mode == mode
            ]
            said += mode_sentence(cls.word, mode, of_mode, [m for m in standing if m in of_mode], plan)
        return said

    def subject(self, plan: Plan, names: Mapping[str, str], plural: bool) -> tuple[str, str]:  # noqa: ARG002
        return self.word, ""

    @staticmethod
    @abstractmethod
    def of(resonances: Backbone) -> Floats:
        """As it was read off them."""

    @staticmethod
    @abstractmethod
    def scatter(scatter: Scatter) -> float:
        """Deviation of its logarithm from test to test."""


@dataclass(frozen=True)
class Frequency(OfMode):
    quantity: ClassVar[str] = "frequency"
    word: ClassVar[str] = "resonance"

    def prior(self, plan: Plan) -> float:
        """A tenth of the measured window, over which the model is taken as linear here. Shifts of all tests alike are
        what Young's modulus is for: they are left to it."""
        low, high = plan.conditions[self.test].window
        return 0.1 * float(np.log(high / low))

    def taken(self, m: Matched, sensors: Sequence[Sensor], parameters: Sequence[str]) -> Floats:  # noqa: ARG002
        return m.by_observation[:, :, 0]

    @classmethod
    def at_tops(cls, test: int, sensors: Sequence[Sensor]) -> Sequence[tuple[Direction, Floats]]:
        n = len(sensors)
        return [(cls(test), np.append(np.full(n, 1 / n), np.zeros(n)))]

    def unit(self, half_width: float, sensors: int) -> float:  # noqa: ARG002
        """What a shift does on the flank."""
        return float(half_width / _STEEPEST)

    @staticmethod
    def of(resonances: Backbone) -> Floats:
        return resonances.frequency

    @staticmethod
    def scatter(scatter: Scatter) -> float:
        return scatter.drift


@dataclass(frozen=True)
class Damping(OfMode):
    quantity: ClassVar[str] = "damping"
    word: ClassVar[str] = "damping"

    def prior(self, plan: Plan) -> float:  # noqa: ARG002
        """Losses are known to a factor of two or three."""
        return 1.0

    def taken(self, m: Matched, sensors: Sequence[Sensor], parameters: Sequence[str]) -> Floats:  # noqa: ARG002
        return m.by_parameter[:, :, parameters.index(LOSS_FACTOR.name)]

    def share(self, damping_share: Sequence[float]) -> float:
        """The material's loss factor is estimated, all the damping is told."""
        return damping_share[self.test]

    @staticmethod
    def of(resonances: Backbone) -> Floats:
        return resonances.damping

    @staticmethod
    def scatter(scatter: Scatter) -> float:
        """No smaller than expected, even where one assembly cannot tell."""
        return max(LOSS_FACTOR.scatter, scatter.parameters[LOSS_FACTOR.name])


@dataclass(frozen=True)
class OfSensors(Direction):
    """What sensors read, in all runs or at one test."""

    modes_share: ClassVar[bool] = True

    @classmethod
    def sentences(cls, found: Sequence[Misfit], standing: Sequence[Misfit], plan: Plan) -> Sequence[Finding]:  # noqa: ARG003
        return [
            Finding(
                m.direction.said(m.relative), "", None, cls.quantity, m.direction.channel, m.relative, m.significance
            )
            for m in standing
            if isinstance(m.direction, cls)
        ]

    @property
    def channel(self) -> str:
        return ""

    @abstractmethod
    def said(self, relative: float) -> str:
        """That the model is off by so much in all runs."""


@dataclass(frozen=True)
class Amplitude(OfSensors):
    """Of all sensors: at a peak its height; of all runs where the sensors' gains have it in common."""

    quantity: ClassVar[str] = "amplitude"

    def prior(self, plan: Plan) -> float:  # noqa: ARG002
        """Whole runs are off by twice or half where they are."""
        return float(np.log(2))

    def taken(self, m: Matched, sensors: Sequence[Sensor], parameters: Sequence[str]) -> Floats:  # noqa: ARG002
        return np.asarray(np.sum(m.by_observation[:, :, 1::2], axis=2))

    def said(self, relative: float) -> str:
        return f"amplitude {in_percent(relative)} in all runs, at all sensors"

    @classmethod
    def at_tops(cls, test: int, sensors: Sequence[Sensor]) -> Sequence[tuple[Direction, Floats]]:
        n = len(sensors)
        return [(cls(test), np.append(np.zeros(n), np.full(n, 1 / n)))]

    def subject(self, plan: Plan, names: Mapping[str, str], plural: bool) -> tuple[str, str]:  # noqa: ARG002
        return ("peaks" if plural else "peak"), ""


@dataclass(frozen=True)
class SensorGain(OfSensors):
    """Of one sensor against the others."""

    quantity: ClassVar[str] = "sensor"

    sensor: Sensor = field(kw_only=True)

    @property
    def channel(self) -> str:
        return self.sensor[0]

    @classmethod
    def along_curves(cls, plan: Plan) -> Sequence[Direction]:
        """None of a single sensor: its gain is a matter of force and mass too."""
        sensors = dict.fromkeys(s for c in plan.conditions for s in c.sensors)
        return [cls(sensor=s) for s in sensors] if len(sensors) > 1 else []

    def prior(self, plan: Plan) -> float:  # noqa: ARG002
        """A gain is hardly wrong by more than a tenth."""
        return 0.1

    def is_in(self, test: int, sensors: Sequence[Sensor]) -> bool:
        return super().is_in(test, sensors) and self.sensor in sensors

    def taken(self, m: Matched, sensors: Sequence[Sensor], parameters: Sequence[str]) -> Floats:  # noqa: ARG002
        return m.by_observation[:, :, 1 + 2 * sensors.index(self.sensor)]

    @classmethod
    def stated(
        cls,
        rows: Mapping[Direction, Floats],
        damping_share: Sequence[float],  # noqa: ARG003
        misfit: Callable[[Direction, Floats], Misfit],
    ) -> Iterator[Misfit]:
        """Their mean, and each against the others."""
        own = [d for d in rows if isinstance(d, cls)]

        def mean(some: Sequence[Direction]) -> Floats:
            return np.mean([rows[d] for d in some], axis=0)

        if own:
            yield misfit(Amplitude(), mean(own))
            yield from farthest_first(own, lambda one, others: misfit(one, rows[one] - mean(others)))

    def said(self, relative: float) -> str:
        return f"{self.channel}: the model reads {in_percent(relative)}, against the other sensors, in all runs"

    @classmethod
    def at_tops(cls, test: int, sensors: Sequence[Sensor]) -> Sequence[tuple[Direction, Floats]]:
        """Of two sensors the first is held against the second, the other way round it is the same."""
        n, found = len(sensors), []
        for i in range({1: 0, 2: 1}.get(n, n)):
            against_others = np.where(np.arange(n) == i, 1.0, -1 / (n - 1))
            found.append((cls(test, sensor=sensors[i]), np.append(np.zeros(n), against_others)))
        return found

    def unit(self, half_width: float, sensors: int) -> float:  # noqa: ARG002
        """Its own part of what it is off the others by."""
        return sensors / max(sensors - 1, 1)

    def subject(self, plan: Plan, names: Mapping[str, str], plural: bool) -> tuple[str, str]:  # noqa: ARG002
        of_test = () if self.test == ALL else plan.conditions[self.test].sensors
        others = [p for p, _ in of_test if p != self.channel]
        other = names.get(others[0], others[0]) if len(others) == 1 else "the other sensors"
        name = names.get(self.channel, self.channel)
        return f"{name} over {other}", name


KINDS: tuple[type[Direction], ...] = (Frequency, Damping, Amplitude, SensorGain)
# Those that are read off resonances.
OF_MODES: tuple[type[OfMode], ...] = tuple(kind for kind in KINDS if issubclass(kind, OfMode))
