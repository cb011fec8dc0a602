"""What one assembly, and each of its runs, is off by against all others, and the equations that they have with it."""

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from updamp.comparison.fit.matching import Matched
from updamp.comparison.fit.observations import Observations
from updamp.comparison.fit.scatter import DRIFT, GAIN, LEVEL, SHAPE, Assembly, Scatter
from updamp.comparison.prediction.run_condition import RunCondition

Floats = NDArray[np.float64]
Sensor = tuple[str, int]
ShapeEntry = tuple[str, str, int]  # mode and sensor


@dataclass(frozen=True, eq=False)
class Offsets:
    """One assembly's: parameters (p_nuisance,), drift and level of each run, gain of each sensor and entries of modes'
    shapes, of the largest of each, by name."""

    parameters: Floats
    drift: Mapping[str, float]
    level: Mapping[str, float]
    gain: Mapping[Sensor, float]
    shape: Mapping[ShapeEntry, float]

    def in_deviations(self, scatter: Scatter) -> Iterator[tuple[str, float]]:
        """Each but for the parameters, by what it is of, over its standard deviation"""
        yield from ((f"the resonance of run '{run}'", b / scatter.drift) for run, b in self.drift.items())
        yield from ((f"the level of run '{run}'", b / scatter.level) for run, b in self.level.items())
        shapes = ((f"the shape of {mode} at {point}", b) for (mode, point, _), b in self.shape.items())
        yield from ((name, b / scatter.shape) for name, b in shapes)
        yield from ((f"the gain of the sensor at {point}", b / scatter.gain) for (point, _), b in self.gain.items())

    def correction(self, run: Observations, condition: RunCondition) -> Floats:
        """(n, m) of the observations of one run"""
        correction = np.zeros_like(run.observed)
        correction[:, 0] = self.drift.get(run.run, 0.0)
        for j, sensor in enumerate(condition.sensors):
            correction[:, 1 + 2 * j] = self.level.get(run.run, 0.0) + self.gain.get(sensor, 0.0)
        for j, shape in enumerate(run.shapes):
            error = self.shape.get((condition.mode, *condition.sensors[j]), 0.0)
            correction[:, 1 + 2 * j : 3 + 2 * j] += shape.moves(error)
        return correction


@dataclass(frozen=True, eq=False)
class _Names:
    """Of the offsets of one assembly, in the order of their vector: parameters, drift and level of each run, gain of
    each sensor, entries of shapes."""

    runs: Sequence[str]
    gains: Sequence[Sensor]
    shapes: Sequence[ShapeEntry]

    @staticmethod
    def of(runs: Sequence[Observations], conditions: Sequence[RunCondition]) -> "_Names":
        gains = dict.fromkeys(sensor for condition in conditions for sensor in condition.sensors)
        known = [c for o, c in zip(runs, conditions, strict=True) if o.shapes]
        shapes = dict.fromkeys((c.mode, *sensor) for c in known for sensor in c.sensors)
        return _Names([o.run for o in runs], list(gains), list(shapes))

    @property
    def kinds(self) -> tuple[str, ...]:
        counts = (DRIFT, self.runs), (LEVEL, self.runs), (GAIN, self.gains), (SHAPE, self.shapes)
        return tuple(kind for kind, names in counts for _ in names)

    def columns(self, m: Matched, condition: RunCondition, offsets: Offsets) -> Floats:
        """(values of the run, offsets but for the parameters)"""
        amplitudes = m.by_observation[:, :, 1::2].reshape(m.residual.size, -1)
        place, runs = self.runs.index(m.observations.run), len(self.runs)
        block = np.zeros((m.residual.size, len(self.kinds)))
        block[:, place] = m.by_observation[:, :, 0].ravel()
        block[:, runs + place] = amplitudes.sum(axis=1)
        for sensor, column in zip(condition.sensors, amplitudes.T, strict=True):
            block[:, 2 * runs + self.gains.index(sensor)] = column
        first = 2 * runs + len(self.gains)
        for j, shape in enumerate(m.observations.shapes):
            entry = condition.mode, *condition.sensors[j]
            slopes = shape.slopes(offsets.shape.get(entry, 0.0))
            moved = np.einsum("nrm,nm->nr", m.by_observation[:, :, 1 + 2 * j : 3 + 2 * j], slopes)
            block[:, first + self.shapes.index(entry)] = moved.ravel()
        return block

    def vector(self, offsets: Offsets) -> Floats:
        of_runs = [of.get(run, 0.0) for of in (offsets.drift, offsets.level) for run in self.runs]
        gains = [offsets.gain.get(sensor, 0.0) for sensor in self.gains]
        return np.concatenate([offsets.parameters, of_runs, gains, [offsets.shape.get(e, 0.0) for e in self.shapes]])

    def split(self, b: Floats) -> Offsets:
        counts = [len(each) for each in (self.runs, self.runs, self.gains, self.shapes)]
        parameters, *parts = np.split(b, len(b) - sum(counts) + np.cumsum([0, *counts[:-1]]))
        drift, level, gain, shape = (part.tolist() for part in parts)
        drifts, levels = (dict(zip(self.runs, values, strict=True)) for values in (drift, level))
        gains, shapes = dict(zip(self.gains, gain, strict=True)), dict(zip(self.shapes, shape, strict=True))
        return Offsets(parameters, drifts, levels, gains, shapes)


def assembly(
    repeat: int,
    matched: Sequence[Matched],
    conditions: Sequence[RunCondition],
    nuisances: Sequence[str],
    offsets: Offsets,
) -> Assembly:
    """The equations of one repeat from its matched runs; conditions: of each run."""
    names, n = _Names.of([m.observations for m in matched], conditions), len(nuisances)
    b, blocks, residual, common = names.vector(offsets), [], [], []
    for m, condition in zip(matched, conditions, strict=True):
        by_parameter = m.by_parameter.reshape(m.residual.size, -1)
        blocks.append(np.concatenate([by_parameter[:, :n], names.columns(m, condition, offsets)], axis=1))
        residual.append(m.residual.ravel() + blocks[-1] @ b)
        common.append(by_parameter)
    kinds = (*nuisances, *names.kinds)
    return Assembly(repeat, np.concatenate(residual), np.concatenate(common), np.concatenate(blocks), kinds, b)


def split(b: Floats, runs: Sequence[Observations], conditions: Sequence[RunCondition]) -> Offsets:
    """The offsets of one assembly from their vector; runs: its own."""
    return _Names.of(runs, conditions).split(b)
