"""A test as the model sees it."""

from collections.abc import Sequence
from dataclasses import dataclass, replace

# The branch is followed beyond the measured frequencies by this share of their range.
_BEYOND = 0.15
# SI unit of a response -> how often its displacement has been differentiated.
DERIVATIVES = {"m": 0, "m/s": 1, "m/s^2": 2}


@dataclass(frozen=True)
class HeldResponse:
    """A controller held the first harmonic at one point. level: amplitude of its displacement differentiated
    `derivatives` times with respect to time"""

    point: str
    level: float
    derivatives: int

    def amplitude(self, w: float) -> float:
        """Of the displacement [m] at the angular frequency w [rad/s]"""
        return self.level / w**self.derivatives


@dataclass(frozen=True)
class RunCondition:
    """A test as the model sees it: one run without its repeats.

    force: amplitude [N], of a response-controlled test the median; window: measured frequencies [Hz]
    held: amplitude of the response that was held, in `unit`; None where it was not a response that was held: what the
        test is called by
    sensors: (point of the model, harmonic), in the order of the observations
    control: the response that a controller held; None where the force is what was set
    noise: standard deviations of what is observed, as in `Observations`; a branch is interpolated as well as they ask
        for, or as the steps have it where there are none
    solved: frequencies [Hz] that the model is to be solved at besides, None for those of the window alone
    place: among the runs of an assembly in the order in which they were made, from -1/2 for the first to 1/2 for the
        last, in the mean of those at its level; 0 where the order is not known
    """

    name: str
    mode: str
    force: float
    upwards: bool
    window: tuple[float, float]
    sensors: tuple[tuple[str, int], ...]
    held: float | None = None
    unit: str = "N"
    control: HeldResponse | None = None
    noise: tuple[float, ...] = ()
    place: float = 0.0
    solved: tuple[float, float] | None = None

    def seen_by(self, sensors: Sequence[tuple[str, int]]) -> "RunCondition":
        """The same test with other sensors, whose noise is not known."""
        return replace(self, sensors=tuple(sensors), noise=())

    def less_sure(self, factor: float) -> "RunCondition":
        """The same test with noise so many times larger: as a model that fails is weighed, so it is interpolated."""
        return replace(self, noise=tuple(factor * each for each in self.noise))

    def sweeps_the_same(self, other: "RunCondition") -> bool:
        """Whether the other test sweeps the same branch, in another direction or window. A held response is not shared:
        it is soon traced."""
        same = (self.mode, self.force, self.place, self.sensors, len(self.noise))
        alone = self.control is not None or other.control is not None
        return not alone and same == (other.mode, other.force, other.place, other.sensors, len(other.noise))

    def along_with(self, others: Sequence["RunCondition"]) -> "RunCondition":
        """The same test in a window that has those of the others in it, as sure as the surest of them."""
        low, high = zip(*(c.window for c in (self, *others)), strict=True)
        noise = tuple(min(each) for each in zip(*(c.noise for c in (self, *others)), strict=True))
        return replace(self, window=(min(low), max(high)), noise=noise)

    @property
    def level(self) -> float:
        """What the test is called by: the force, unless a response was held."""
        return self.force if self.held is None else self.held

    @property
    def level_name(self) -> str:
        return f"{self.level:.3g} {self.unit.replace('^2', '²')}"

    @property
    def wider(self) -> tuple[float, float]:
        low, high = self.window
        return low - _BEYOND * (high - low), high + _BEYOND * (high - low)


def same_sweeps(conditions: Sequence[RunCondition]) -> list[list[int]]:
    """Places of the tests, those together that sweep the same branch."""
    groups: list[list[int]] = []
    for i, condition in enumerate(conditions):
        known = next((g for g in groups if conditions[g[0]].sweeps_the_same(condition)), None)
        if known is None:
            groups.append([i])
        else:
            known.append(i)
    return groups
