"""Sensors of a model without contacts that fails grossly: how far each reads from the others, by the heights of the
resonances.

Calibration bends frequency, damping and mass until as much as possible of a wrong sensor is made up for, but all that
is common to the sensors of a mode leaves the ratios of their heights alone.
"""

from collections.abc import Iterator, Sequence

import numpy as np
from numpy.typing import NDArray

from updamp.comparison.comparison import Backbone
from updamp.comparison.findings.backbone import places_of
from updamp.comparison.findings.direction import Misfit, Sensor, farthest_first
from updamp.comparison.findings.kinds import SensorGain
from updamp.comparison.fit.observations import Plan

Floats = NDArray[np.float64]


def sensor_misfits(plan: Plan, measured: Sequence[Backbone], model: Sequence[Backbone]) -> tuple[Misfit, ...]:
    """As in `farthest_first`, by the mean of the others. A shape of the model that is wrong in one mode alone differs
    from test to test, and so does not stand out.

    measured: one a mode and sensor, entries in the order of the plan's runs; model: likewise, of its conditions
    """
    tests = [
        dict(of_test) for test in range(len(plan.conditions)) if (of_test := _heights(test, plan, measured, model))
    ]
    sensors = list(dict.fromkeys(sensor for of_test in tests for sensor in of_test))
    return tuple(farthest_first(sensors, lambda one, others: _against(one, others, tests, plan)))


def _heights(
    test: int, plan: Plan, measured: Sequence[Backbone], model: Sequence[Backbone]
) -> list[tuple[Sensor, float]]:
    """Logarithm of the model's height over the measured one at a test's resonance, as mean over its repeats."""
    mode = plan.conditions[test].mode
    pairs = [(m, c) for m, c in zip(measured, model, strict=True) if m.mode == mode]
    runs, (place,) = places_of(plan, test, True), places_of(plan, test, False)
    found = [
        (sensor, float(np.log(c.receptance[place]) - np.mean(np.log(m.receptance[runs]))))
        for sensor, (m, c) in zip(plan.conditions[test].sensors, pairs, strict=True)
    ]
    return [(sensor, value) for sensor, value in found if np.isfinite(value)]


def _against(
    sensor: Sensor, others: Sequence[Sensor], tests: Sequence[dict[Sensor, float]], plan: Plan
) -> Misfit | None:
    """None where it was never measured beside another one."""
    logs = np.array(list(_differences(sensor, others, tests)))
    if not len(logs):
        return None
    noise = [float(np.median(o.noise[:, 1 + 2 * j])) for o in plan.observations for j in range(o.noise.shape[1] // 2)]
    spread = np.std(logs, ddof=1) if len(logs) > 1 else 0.0
    deviation = float(max(spread, np.median(noise)) / np.sqrt(len(logs)))
    log = float(np.mean(logs))
    relative = float(np.expm1(log))
    # as significant as the logarithm is
    return Misfit(SensorGain(sensor=sensor), relative, deviation * (relative / log if log else 1.0))


def _differences(sensor: Sensor, others: Sequence[Sensor], tests: Sequence[dict[Sensor, float]]) -> Iterator[float]:
    for of_test in tests:
        beside = [of_test[one] for one in others if one in of_test]
        if sensor in of_test and beside:
            yield of_test[sensor] - float(np.mean(beside))
