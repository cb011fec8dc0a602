"""Sentences on points that are unlike those next to them (`comparison/fit/odd_readings.py`)."""

from collections.abc import Mapping, Sequence

import numpy as np

from updamp.comparison.comparison import FORCE, OddPoint
from updamp.comparison.findings.words import level_of
from updamp.comparison.fit.observations import Plan
from updamp.comparison.fit.odd_readings import OddReading


def odd_points(readings: Sequence[OddReading], plan: Plan, names: Mapping[str, str]) -> tuple[OddPoint, ...]:
    """One a sensor, or one of the force, which is all that is said of a point then: the model is asked what another
    force does there. names: of the channels, by the model's points"""
    of_force = {one.point: one for one in reversed(readings) if one.of_force}
    told = [one for one in readings if of_force.get(one.point, one) is one]
    return tuple(_named(one, plan, names) for one in told)


def _named(one: OddReading, plan: Plan, names: Mapping[str, str]) -> OddPoint:
    test = next(i for i, condition in enumerate(plan.conditions) if condition.name == one.run)
    relative = float("nan") if one.of_phase else float(np.expm1(one.by))
    degrees = float(np.degrees(one.by)) if one.of_phase else float("nan")
    of = one.run, plan.conditions[test].mode, level_of(plan, test), one.repeat
    if one.of_force:
        return OddPoint(*of, FORCE, one.frequency, float(np.expm1(one.of_force)), degrees, one.chance)
    return OddPoint(*of, names[one.sensor], one.frequency, relative, degrees, one.chance)
