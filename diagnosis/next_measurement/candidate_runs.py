"""Runs that the rig could make next, from those that it has made.

Hours of testing assumed: ten minutes a run, half an hour more to fit a new sensor, two hours more for another damper
load (the damper is taken out, loaded anew and left to settle).
"""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
from itertools import chain, zip_longest

import numpy as np

from updamp.comparison.fit.observations import Plan
from updamp.comparison.prediction.parameters import Parametrisation
from updamp.comparison.prediction.run_condition import RunCondition

RUN, SENSOR, LOAD = 1 / 6, 1 / 2, 2.0  # hours
_FACTOR = 2.0  # of the force, beyond the levels measured
_LOADS = {1.3: "load the damper 30 % more", 0.7: "load the damper 30 % less"}  # times the present damper load
_HARMONICS = (2, 3, 0)
_WIDER = 0.1  # share of the measured range added to both sides, since other levels resonate elsewhere


@dataclass(frozen=True)
class Recording:
    """What is read off a run. sensors: (point, harmonic); hours: of testing; what: in words, to be done"""

    sensors: tuple[tuple[str, int], ...]
    hours: float
    what: str


@dataclass(frozen=True)
class CandidateRun:
    """condition: with every sensor that any of the recordings has; load: of the damper, over the present one"""

    condition: RunCondition
    load: float
    recordings: tuple[Recording, ...]


def candidate_runs(plan: Plan, parametrisation: Parametrisation, most: int) -> tuple[CandidateRun, ...]:
    """At most so many, of every mode alike."""
    modes = dict.fromkeys(c.mode for c in plan.conditions)
    each = [_of_mode([c for c in plan.conditions if c.mode == mode], parametrisation) for mode in modes]
    in_turn = chain.from_iterable(zip_longest(*each))
    return tuple(run for run in in_turn if run is not None)[:most]


def _of_mode(conditions: Sequence[RunCondition], parametrisation: Parametrisation) -> Iterator[CandidateRun | None]:
    """First what is likely to tell most: a higher level, other harmonics and sensors, another load."""
    lowest, highest = _extreme_levels(conditions)
    mode, way = lowest.mode, {True: "upwards", False: "downwards"}
    above, below = highest.force * _FACTOR, lowest.force / _FACTOR
    yield _run(highest, above, highest.upwards, f"sweep {mode} at {above:.3g} N, twice the highest level so far")
    again = _run(highest, highest.force, highest.upwards, "")
    yield _with_more(again, parametrisation)
    loaded = (
        _run(highest, highest.force, highest.upwards, f"{how} and sweep {mode} at {highest.force:.3g} N", load)
        for load, how in _LOADS.items()
        if parametrisation.base.contacts is not None
    )
    yield next(loaded, None)
    if not any(c.upwards != highest.upwards and np.isclose(c.force, highest.force, rtol=0.05) for c in conditions):
        what = f"sweep {mode} at {highest.force:.3g} N {way[not highest.upwards]} too"
        yield _run(highest, highest.force, not highest.upwards, what)
    yield _run(lowest, below, lowest.upwards, f"sweep {mode} at {below:.3g} N, half the lowest level so far")
    yield from loaded


def _extreme_levels(conditions: Sequence[RunCondition]) -> tuple[RunCondition, RunCondition]:
    """The lowest and the highest of a mode, with all of its sensors."""
    lowest, highest = (pick(conditions, key=lambda c: c.force) for pick in (min, max))
    usual = tuple(dict.fromkeys(sensor for c in conditions for sensor in c.sensors))
    return _at_constant_force(lowest, conditions, usual), _at_constant_force(highest, conditions, usual)


def _at_constant_force(
    like: RunCondition, conditions: Sequence[RunCondition], sensors: tuple[tuple[str, int], ...]
) -> RunCondition:
    return replace(like.seen_by(sensors), window=_window(conditions), held=None, unit="N", control=None)


def _run(like: RunCondition, force: float, upwards: bool, what: str, load: float = 1.0) -> CandidateRun:
    name = f"{like.mode} {force:.4g} N {'up' if upwards else 'down'} load {load:g}"
    condition = replace(like, name=name, force=force, upwards=upwards)
    hours = RUN + (LOAD if load != 1 else 0)
    return CandidateRun(condition, load, (Recording(like.sensors, hours, what),))


def _window(conditions: Sequence[RunCondition]) -> tuple[float, float]:
    low, high = min(c.window[0] for c in conditions), max(c.window[1] for c in conditions)
    return low - _WIDER * (high - low), high + _WIDER * (high - low)


def _with_more(again: CandidateRun, parametrisation: Parametrisation) -> CandidateRun:
    """The same run once more: as it was, with other harmonics, or with a further sensor."""
    usual = again.condition.sensors
    points = dict.fromkeys(point for point, _ in usual)
    where = f"in the sweep of {again.condition.mode} at {again.condition.force:.3g} N"
    recordings = [Recording(usual, RUN, f"sweep {again.condition.mode} at {again.condition.force:.3g} N once more")]
    for k in _HARMONICS:
        if k in parametrisation.base.harmonics.orders:
            what = f"record harmonic {k} {where}" if k else f"record the mean position {where}"
            recordings.append(Recording((*usual, *((point, k) for point in points)), RUN, what))
    for point in parametrisation.base.components.points:
        if point not in points:
            recordings.append(Recording((*usual, (point, 1)), RUN + SENSOR, f"put a sensor at {point} {where}"))
    sensors = tuple(dict.fromkeys(sensor for recording in recordings for sensor in recording.sensors))
    return replace(again, condition=again.condition.seen_by(sensors), recordings=tuple(recordings))
