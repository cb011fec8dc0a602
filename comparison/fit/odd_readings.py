"""Single points that are unlike the points next to them: a sample that had not settled, an overload, a typing error.

A parabola through what the calibrated model leaves of the six points next to one, one of its neighbours left out or
not, predicts what it leaves there: two bad points beside each other would hide one another. Of a
model that lacks nothing the difference is noise. What a model gets wrong may be as narrow as a resonance, and a point
in the middle of it stands out by as much as the model is off around it. So the difference is held against the larger
one of the sensors' noise and of what the model leaves of the six, and has Student's t distribution: with the degrees of
freedom that the noise is known by, or with these six (N. R. Draper and H. Smith, Applied Regression Analysis, 1998, ch.
8). The worse a model describes a run, the farther off a point has to be; and farther than the model changes by between
the points on both sides, or it may be the model that is a part of a step off in frequency. Where the sweep jumps from
one part of the branch to another between these, each point is held against the nearer part, and one that lies between
both was recorded while the rig jumped. Where most runs of a mode show a point alike, at one frequency, it is the rig's:
a mode that the model lacks, as narrow as a step, or the flank of one at the end of the runs.

Such a point says nothing of the rig, and one alone, a hundred deviations off, would lead a fit: it is left out of all
that rests on the runs, with all of its sensors, and told.
"""

from collections.abc import Collection, Iterator, Sequence
from dataclasses import dataclass, replace
from functools import cache
from typing import Self

import numpy as np
from numpy.typing import NDArray
from scipy.stats import t as student

from updamp.comparison.fit.at_sensors import left_at_sensors, recorded
from updamp.comparison.fit.compared import Compared
from updamp.comparison.fit.failing_model import RISK
from updamp.comparison.fit.matching import Matched
from updamp.comparison.fit.numerical_patterns import with_unwrapped_phases
from updamp.comparison.fit.observations import Observations, Plan
from updamp.comparison.prediction.predicted_branch import PredictedBranch

Floats = NDArray[np.float64]
_SIDE = 3  # points on each side, as many as there are, six in all
_WITHIN = 2 * _SIDE + 1  # steps to the farthest of them: all on one side, a neighbour left out


@dataclass(frozen=True)
class OddReading:
    """One sensor's, at one point of a run.

    run: name of its test; repeat: of the assembly; sensor: its point of the model; frequency: [Hz]
    by: how far off, logarithm of the amplitude or phase [rad]; chance: probability of as much by chance
    of_force: how far the force is off its neighbours, logarithm, where it is that which is bad; else 0
    """

    run: str
    repeat: int
    sensor: str
    of_phase: bool
    frequency: float
    by: float
    chance: float
    of_force: float = 0.0

    @property
    def point(self) -> tuple[str, int, float]:
        """Run, repeat and frequency: all sensors there"""
        return self.run, self.repeat, self.frequency


@dataclass(frozen=True, eq=False)
class _Column:
    """What one sensor recorded of a run, amplitudes or phases, of n points.

    left: (n,) what the model leaves, in deviations of the sensors; noise: (n,) one deviation; model: (n,) what it says
    log_force: (n,) over the level's
    in_jump: (n,) whether a sweep jumps between the points on both sides
    """

    run: str
    repeat: int
    mode: str
    sensor: str
    of_phase: bool
    frequency: Floats
    left: Floats
    noise: Floats
    model: Floats
    log_force: Floats
    in_jump: NDArray[np.bool_]

    def at(self, frequency: float) -> float:
        """What the model leaves at the nearest point, logarithm of the amplitude or phase [rad]."""
        nearest = int(np.argmin(np.abs(self.frequency - frequency)))
        return float(self.left[nearest] * self.noise[nearest])

    def stands_out(self, i: int, by: float) -> bool:
        """Whether a point is farther off than a model by a part of a step in frequency may be, or between what is said
        on both sides of a jump."""
        around = self.model[max(i - 1, 0) : i + 2]
        if not self.in_jump[i]:
            return bool(abs(by) >= np.ptp(around))
        reading = self.model[i] + self.left[i] * self.noise[i]
        return bool(min(around[0], around[-1]) < reading < max(around[0], around[-1]))

    def of_force(self, i: int, by: float) -> float:
        """Logarithm by which the force at a point leaves those next to it, where that is what the amplitude over it is
        off by, to within half: a bad sample of it. One that did act would be in the response too."""
        others = [j for j in range(max(i - _WITHIN, 0), min(i + _WITHIN + 1, len(self.left))) if j != i]
        near = _nearest(others, i)
        off = float(self.log_force[i] - _by_parabola(tuple(j - i for j in near)) @ self.log_force[list(near)])
        return off if not self.of_phase and abs(off + by) < abs(by) / 2 else 0.0

    def is_of(self, other: Self) -> bool:
        """Whether of the same sensor and mode."""
        return (self.mode, self.sensor, self.of_phase) == (other.mode, other.sensor, other.of_phase)

    def is_near(self, some: Floats | float, frequency: float) -> NDArray[np.bool_]:
        """To within half a step."""
        return np.asarray(np.abs(some - frequency) <= np.median(np.abs(np.diff(self.frequency))) / 2)


def odd_readings(compared: Compared, plan: Plan) -> tuple[OddReading, ...]:
    """Of a plan's runs: the least likely first, one a point and sensor, those left out that most runs of their mode
    show. A measurement without any has one taken for it with a probability of `RISK`."""
    long_enough = [m for m in compared.matched if _is_long_enough(m)]
    tested = sum(len(m.observations) * len(recorded(m)) for m in long_enough)
    columns = [column for m in long_enough for column in _columns(m, compared.branches[m.observations.test], plan)]
    unlikely = [(column, one) for column in columns for one in _readings(column, plan.noise_freedom, RISK)]
    found: dict[tuple[str, int, str, float], tuple[_Column, OddReading]] = {}
    for column, one in unlikely:
        key = one.run, one.repeat, one.sensor, one.frequency
        if one.chance < RISK / max(tested, 1) and (key not in found or one.chance < found[key][1].chance):
            found[key] = column, one
    alone = (one for column, one in found.values() if not _is_of_most_runs(column, one, unlikely, columns))
    return tuple(sorted(alone, key=lambda one: one.chance))


def _is_of_most_runs(
    own: _Column, one: OddReading, unlikely: Collection[tuple[_Column, OddReading]], columns: Sequence[_Column]
) -> bool:
    """Of more than half of those of its mode that have a point there, to within half a step; of two at least. One shows
    it that is unlikely there by itself, or that the model leaves as much of, to half of what this one is off by: beside
    a neighbour that is off too no point is unlikely."""
    alike, there = 0, [c for c in columns if c.is_of(own) and c.is_near(c.frequency, one.frequency).any()]
    for c in there:
        by_itself = any(
            column is c and (other.by > 0) == (one.by > 0) and c.is_near(other.frequency, one.frequency)
            for column, other in unlikely
        )
        alike += by_itself or abs(c.at(one.frequency) - own.at(one.frequency)) < abs(one.by) / 2
    return alike > max(1.0, len(there) / 2)


def without_odd(plan: Plan, odd: Collection[OddReading]) -> Plan:
    """The same runs without these points, whichever sensor they are odd at."""
    left_out = {one.point for one in odd}
    return replace(plan, observations=tuple(_without(o, left_out) for o in plan.observations)) if left_out else plan


def _without(o: Observations, left_out: Collection[tuple[str, int, float]]) -> Observations:
    kept = np.array([(o.run, o.repeat, f) not in left_out for f in o.frequency.tolist()])
    return o if kept.all() else o.only(kept)


def _is_long_enough(m: Matched) -> bool:
    return len(m.observations) > 2 * _SIDE


def _columns(m: Matched, branch: PredictedBranch, plan: Plan) -> Iterator[_Column]:
    o, condition, in_jump = m.observations, branch.condition, _in_jumps(m, branch)
    as_measured = next(one for one in plan.observations if (one.test, one.repeat) == (o.test, o.repeat))
    model = with_unwrapped_phases(o.observed - m.difference)
    model[:, 1::2] -= o.log_force[:, None]  # at one force, or a bad sample of it would be a change of the model's
    for place, left in zip(recorded(m), left_at_sensors(m).T, strict=True):
        sensor, of_phase = divmod(int(place) - 1, 2)
        at = condition.sensors[sensor][0]
        yield _Column(
            as_measured.run, o.repeat, condition.mode, at, bool(of_phase),
            as_measured.frequency, left, o.noise[:, place], model[:, place], o.log_force, in_jump,
        )  # fmt: skip


def _in_jumps(m: Matched, branch: PredictedBranch) -> NDArray[np.bool_]:
    """(n,) whether from the point before to the one after some of the branch is passed that a sweep does not see"""
    found = np.zeros(len(m.place), dtype=bool)
    for i in range(1, len(m.place) - 1):
        found[i] = not branch.seen_from(*np.sort(m.place[[i - 1, i + 1]]))
    return found


def _readings(column: _Column, noise_freedom: float, chance: float) -> Iterator[OddReading]:
    """Those less likely than a chance."""
    for i, (off, by_chance) in enumerate(_off(column.left, noise_freedom)):
        by = off * float(column.noise[i])
        if by_chance < chance and column.stands_out(i, by):
            c, frequency = column, float(column.frequency[i])
            yield OddReading(c.run, c.repeat, c.sensor, c.of_phase, frequency, by, by_chance, c.of_force(i, by))


def _off(left: Floats, noise_freedom: float) -> Iterator[tuple[float, float]]:
    """How far each point is off what those next to it say, and the probability of as much by chance; in deviations of
    the sensors. With and without each of its neighbours, of which one may be bad too: the least likely of these."""
    n = len(left)
    for i in range(n):
        others = [j for j in range(max(i - _WITHIN, 0), min(i + _WITHIN + 1, n)) if j != i]
        told = [_off_others(left, i, _nearest(others, i), noise_freedom)]
        for neighbour in (i - 1, i + 1):
            if 0 <= neighbour < n and n > 2 * _SIDE + 1:
                near = _nearest([j for j in others if j != neighbour], i)
                told.append(_off_others(left, i, near, noise_freedom))
        off, by_chance = min(told, key=lambda one: one[1])
        yield off, min(len(told) * by_chance, 1.0)


def _nearest(others: Sequence[int], i: int) -> tuple[int, ...]:
    """Six of the others, three before and three after it, or as many there as there are."""
    before = sum(j < i for j in others)
    first = min(max(before - _SIDE, 0), len(others) - 2 * _SIDE)
    return tuple(others[first : first + 2 * _SIDE])


def _off_others(left: Floats, i: int, near: tuple[int, ...], noise_freedom: float) -> tuple[float, float]:
    values, weights = left[list(near)], _by_parabola(tuple(j - i for j in near))
    around = float(np.sqrt(np.mean(values**2)))
    off, deviation = float(left[i] - weights @ values), max(around, 1.0) * float(np.sqrt(1 + weights @ weights))
    return off, float(2 * student.sf(abs(off) / deviation, len(near) if around > 1 else noise_freedom))


@cache
def _by_parabola(apart: tuple[int, ...]) -> Floats:
    """(6,) weights of points so many steps away in what a parabola through them is at the point itself."""
    return np.asarray(np.linalg.pinv(np.vander(np.array(apart) / _SIDE, 3))[-1])
