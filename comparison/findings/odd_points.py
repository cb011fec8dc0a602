"""Single points that are unlike the points next to them: a sample that had not settled, an overload, a typing error.

A parabola through what the calibrated model leaves of the six points next to one predicts what it leaves there. Of a
model that lacks nothing the difference is noise. What a model gets wrong may be as narrow as a resonance, and a point
in the middle of it stands out by as much as the model is off around it. So the difference is held against the larger
one of the sensors' noise and of what the model leaves of the six, and has Student's t distribution: with the degrees of
freedom that the noise is known by, or with these six (N. R. Draper and H. Smith, Applied Regression Analysis, 1998, ch.
8). The worse a model describes a run, the farther off a point has to be; and farther than the model changes by between
the points on both sides, or it may be the model that is a part of a step off in frequency.
"""

from collections.abc import Iterator, Sequence
from functools import cache

import numpy as np
from numpy.typing import NDArray
from scipy.stats import t as student

from updamp.comparison.comparison import OddPoint
from updamp.comparison.findings.findings import RISK, level_of
from updamp.comparison.fit.at_sensors import left_at_sensors, recorded
from updamp.comparison.fit.matching import Matched
from updamp.comparison.fit.numerical_gate import with_unwrapped_phases
from updamp.comparison.fit.observations import Plan

Floats = NDArray[np.float64]
_SIDE = 3  # points on each side, as many as there are, six in all


def odd_points(
    matched: Sequence[Matched], plan: Plan, names: dict[str, str], risk: float = RISK
) -> tuple[OddPoint, ...]:
    """The least likely first, one a point and sensor.

    names: of the channels, by the model's points; risk: that runs without any have one named
    """
    tested = sum(len(m.observations) * len(recorded(m)) for m in matched if _is_long_enough(m))
    found: dict[tuple[str, int, str, float], OddPoint] = {}
    for m in matched:
        for point in _points(m, plan, names, risk / max(tested, 1)) if _is_long_enough(m) else ():
            key = point.run, point.repeat, point.channel, point.frequency
            if key not in found or point.chance < found[key].chance:
                found[key] = point
    return tuple(sorted(found.values(), key=lambda point: point.chance))


def _is_long_enough(m: Matched) -> bool:
    return len(m.observations) > 2 * _SIDE


def _points(m: Matched, plan: Plan, names: dict[str, str], chance: float) -> Iterator[OddPoint]:
    """Those less likely than a chance."""
    o, condition = m.observations, plan.conditions[m.observations.test]
    as_measured = next(one for one in plan.observations if (one.test, one.repeat) == (o.test, o.repeat))
    model = with_unwrapped_phases(o.observed - m.difference)
    for place, left in zip(recorded(m), left_at_sensors(m).T, strict=True):
        sensor, of_phase = divmod(int(place) - 1, 2)
        for i, (off, by_chance) in enumerate(_off(left, plan.noise_freedom)):
            by = off * float(o.noise[i, place])
            if by_chance >= chance or abs(by) < np.ptp(model[max(i - 1, 0) : i + 2, place]):
                continue
            yield OddPoint(
                condition.name, condition.mode, level_of(plan, o.test), o.repeat, names[condition.sensors[sensor][0]],
                float(as_measured.frequency[i]), float("nan") if of_phase else float(np.expm1(by)),
                float(np.degrees(by)) if of_phase else float("nan"), by_chance,
            )  # fmt: skip


def _off(left: Floats, noise_freedom: float) -> Iterator[tuple[float, float]]:
    """How far each point is off what those next to it say, and the probability of as much by chance; in deviations of
    the sensors."""
    n = len(left)
    for i in range(n):
        first = min(max(i - _SIDE, 0), n - 2 * _SIDE - 1)
        near = np.delete(left[first : first + 2 * _SIDE + 1], i - first)
        weights = _by_parabola(i - first)
        around = float(np.sqrt(np.mean(near**2)))
        off, deviation = float(left[i] - weights @ near), max(around, 1.0) * float(np.sqrt(1 + weights @ weights))
        yield off, float(2 * student.sf(abs(off) / deviation, len(near) if around > 1 else noise_freedom))


@cache
def _by_parabola(place: int) -> Floats:
    """(6,) weights of the others in what a parabola through them is at a place among seven."""
    apart = np.delete(np.arange(2 * _SIDE + 1), place) - place
    return np.asarray(np.linalg.pinv(np.vander(apart / _SIDE, 3))[-1])
