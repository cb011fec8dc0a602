"""Measured sweeps in the coordinates in which they are compared: logarithm of frequency, of amplitude, and phase."""

from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from updamp.comparison.fit.failing_model import as_many, as_one
from updamp.comparison.fit.roughness import freedom, roughness, shrunk
from updamp.comparison.fit.shape_error import ShapeError
from updamp.comparison.prediction.run_condition import DERIVATIVES, HeldResponse, RunCondition
from updamp.measurement.measurement import DRIFT, GAIN, LEVEL, MeasuredRun, Measurement, MeasurementError

Floats = NDArray[np.float64]


@dataclass(frozen=True, eq=False)
class Observations:
    """One run of one repeat.

    test: place of its condition; repeat: number of the assembly
    observed: (n, 1 + 2 n_sensors) as in PredictedBranch; own: like it, standard deviations of the sensors alone,
        infinite where no phase was recorded
    log_force: (n,) logarithm of the measured force over the condition's; log_level: (n,) of the measured response over
        the one to be held, None where the force was set
    repeatability: relative, that another test of the same is stated to differ by, the sensors' noise included
    shapes: what errors of the mode's shape at each sensor do, where shapes were identified in a test; else none
    """

    run: str
    test: int
    repeat: int
    observed: Floats
    own: Floats
    log_force: Floats
    log_level: Floats | None = None
    repeatability: float = 0.0
    shapes: tuple[ShapeError, ...] = ()

    def __len__(self) -> int:
        return len(self.observed)

    @cached_property
    def noise(self) -> Floats:
        """Standard deviations, like those of the sensors alone: no less than what tests are stated to differ by."""
        noise = self.own.copy()
        noise[:, 1:] = np.maximum(noise[:, 1:], self.repeatability)
        return noise

    def only(self, points: NDArray[np.bool_ | np.int64]) -> "Observations":
        """points: which are kept, or their places"""
        return replace(
            self,
            observed=self.observed[points],
            own=self.own[points],
            log_force=self.log_force[points],
            log_level=None if self.log_level is None else self.log_level[points],
            shapes=tuple(shape.only(points) for shape in self.shapes),
        )

    def has_phase(self, sensor: int) -> bool:
        """Whether a phase was recorded; sensor: its place in the condition"""
        return bool(np.isfinite(self.noise[:, 2 + 2 * sensor]).all())

    @property
    def frequency(self) -> Floats:
        """(n,) [Hz]"""
        return np.exp(self.observed[:, 0])


@dataclass(frozen=True, eq=False)
class Plan:
    """conditions: the tests; observations: all runs and repeats of them
    drift, gain, level: relative standard deviations as stated (`Measurement`), before repeats have been looked at
    repeatability: as stated, 0 where repeats tell; the observations' noise is no less
    lacks_nothing: whether the model that is compared is taken to
    noise_read: whether the sensors' noise was read off how rough the runs are, and is no better known than that
    common: variance over that of the noise by which neighbouring points are off alike although the model lacks nothing,
        as by its mesh (`Fit.numerics_beside_noise`); infinite where that is not known, as without a finer mesh, or
        of a repeatability that is stated, which says nothing of how much of it neighbours share
    """

    conditions: tuple[RunCondition, ...]
    observations: tuple[Observations, ...]
    drift: float = DRIFT
    gain: float = GAIN
    level: float = LEVEL
    repeatability: float = 0.0
    lacks_nothing: bool = False
    noise_read: bool = False
    common: float = float("inf")

    @property
    def repeats(self) -> tuple[int, ...]:
        return tuple(sorted({o.repeat for o in self.observations}))

    @property
    def values(self) -> int:
        """Numbers that a model is compared with: amplitude, and phase where it was recorded, of every sensor at every
        point."""
        return sum(len(o) * int(np.isfinite(o.noise[:, 1:]).all(axis=0).sum()) for o in self.observations)

    @property
    def as_many(self) -> float:
        """Points that count as one for what a model lacks (`failing_model.py`), 0 for one that lacks nothing."""
        if self.lacks_nothing or not self.observations:
            return 0.0
        return as_many(float(np.median([len(o) for o in self.observations])))

    @property
    def independent(self) -> float:
        """Values that count of their own for what a model lacks which may lack nothing."""
        return self.values / self.as_one

    @property
    def as_one(self) -> float:
        """How many times fewer values count of their own than there are."""
        return as_one(self.as_many, self.common)

    @property
    def own_noise(self) -> float:
        """Of the sensors alone, relative, the median of all amplitudes"""
        return float(np.median(np.concatenate([o.own[:, 1::2].ravel() for o in self.observations])))

    @property
    def told_by_noise(self) -> bool:
        """Whether what errors are measured in was read off the runs: nothing is stated, or less than they are rough."""
        return self.noise_read and self.own_noise > self.repeatability

    @property
    def rougher_than_stated(self) -> bool:
        """Whether the runs are by more than chance: the logarithm of a deviation of f degrees of freedom is known to
        1 / sqrt(2 f)."""
        by_chance = np.exp(2 / np.sqrt(2 * self.noise_freedom))
        return self.told_by_noise and self.repeatability > 0 and self.own_noise > by_chance * self.repeatability

    @property
    def noise_freedom(self) -> float:
        """Degrees of freedom that the variance of the noise is known by, infinite where it is stated."""
        if not self.told_by_noise:
            return float("inf")
        recorded = [int(np.isfinite(o.noise[:, 1:]).all(axis=0).sum()) for o in self.observations]
        return freedom([len(o) for o, columns in zip(self.observations, recorded, strict=True) for _ in range(columns)])

    @property
    def has_phases(self) -> bool:
        """Of every sensor in every run."""
        return all(np.isfinite(o.noise).all() for o in self.observations)

    @property
    def largest_amplitude(self) -> float:
        """Of all sensors, first harmonics [m]"""
        return float(np.exp(max(o.observed[:, 1].max() for o in self.observations)))

    def only(self, wanted: Sequence[int]) -> "Plan":
        """With some of the conditions: their places."""
        place = {old: new for new, old in enumerate(wanted)}
        kept = tuple(replace(o, test=place[o.test]) for o in self.observations if o.test in place)
        return replace(self, conditions=tuple(self.conditions[i] for i in wanted), observations=kept)

    def if_repeatable(self, repeatability: float) -> "Plan":
        """The same runs, had another repeatability been stated."""
        runs = tuple(replace(o, repeatability=repeatability) for o in self.observations)
        return replace(self, observations=runs, repeatability=repeatability)


def plan_of(measurement: Measurement) -> Plan:
    """The tests of a measurement: runs of one name are one test. First harmonics are compared, whichever others were
    measured."""
    conditions: list[RunCondition] = []
    places = _places(measurement.runs)
    observations: list[Observations] = []
    for name in dict.fromkeys(run.name for run in measurement.runs):
        runs = [run for run in measurement.runs if run.name == name]
        condition = _condition(measurement, runs)
        condition = replace(condition, place=_mean_at_level(places, runs[0]))
        observations += [_observations(run, len(conditions), condition, measurement) for run in runs]
        conditions.append(condition)
    noise_read = all(run.noise is None for run in measurement.runs)
    if noise_read:
        observations = _pooled(observations, conditions)
    observations = [replace(o, repeatability=measurement.repeatability) for o in observations]
    if len({c.unit for c in conditions}) > 1:  # forces are the one thing that all of them have
        conditions = [replace(c, held=None, unit=measurement.units[1]) for c in conditions]
    conditions = [replace(c, noise=tuple(noise_of(observations, test).tolist())) for test, c in enumerate(conditions)]
    stated = measurement.drift, measurement.gain, measurement.level, measurement.repeatability
    return Plan(tuple(conditions), tuple(observations), *stated, noise_read=noise_read)


def _places(runs: Sequence[MeasuredRun]) -> list[tuple[MeasuredRun, float]]:
    """Where each is in the order in which those of its assembly were made: from -1/2 to 1/2, 0 where that is not known
    or it is the only one."""
    found = []
    for repeat in dict.fromkeys(run.repeat for run in runs):
        own = sorted((run for run in runs if run.repeat == repeat), key=lambda run: run.taken)
        known = len(own) > 1 and all(run.taken for run in own)
        found += [(run, i / (len(own) - 1) - 0.5 if known else 0.0) for i, run in enumerate(own)]
    return found


def _mean_at_level(places: Sequence[tuple[MeasuredRun, float]], run: MeasuredRun) -> float:
    """Of all runs at its level, so that sweeps of one branch are at one place."""
    at_level = [place for other, place in places if other.name == run.name or _at_one_level(other, run)]
    return float(np.mean(at_level))


def noise_of(observations: Sequence[Observations], test: int) -> Floats:
    """(m,) of what is observed in a test, the median of all its points."""
    return np.asarray(np.median(np.concatenate([o.noise for o in observations if o.test == test]), axis=0))


def _condition(measurement: Measurement, runs: Sequence[MeasuredRun]) -> RunCondition:
    first = runs[0]
    common = [c for c in first.channels if all(c in run.channels for run in runs)]
    force = _force_of(runs, [run for run in measurement.runs if _at_one_level(run, first)])
    low, high = min(run.frequency.min() for run in runs), max(run.frequency.max() for run in runs)
    held, unit = (first.level, first.level_unit) if first.held == "response" else (None, measurement.units[1])
    sensors = tuple((measurement.channel(c).point, 1) for c in common)
    window, control = (float(low), float(high)), _control(measurement, first)
    return RunCondition(first.name, first.mode, force, first.upwards, window, sensors, held, unit, control)


def _force_of(runs: Sequence[MeasuredRun], at_level: Sequence[MeasuredRun]) -> float:
    """Median amplitude [N]: of all runs at the level, where each had that force at some time, so that tests which
    differ by their direction alone are at one force; else of these. What points differ from it by is accounted for one
    by one."""
    forces = [np.abs(run.force) for run in at_level]
    common = float(np.median(np.concatenate(forces))) if forces else np.nan
    if forces and all(f.min() <= common <= f.max() for f in forces):
        return common
    return float(np.median(np.concatenate([np.abs(run.force) for run in runs])))


def _at_one_level(one: MeasuredRun, other: MeasuredRun) -> bool:
    return one.held == other.held == "force" and (one.mode, one.level) == (other.mode, other.level)


def _control(measurement: Measurement, run: MeasuredRun) -> HeldResponse | None:
    """The response that was held; None where none was."""
    if run.held != "response" or run.level_unit not in DERIVATIVES:
        return None
    point = measurement.channel(run.held_channel or run.channels[0]).point
    return HeldResponse(point, run.level, DERIVATIVES[run.level_unit])


def _observations(run: MeasuredRun, test: int, condition: RunCondition, measurement: Measurement) -> Observations:
    points = {channel.point: channel.name for channel in measurement.channels}
    turn = run.force / np.abs(run.force)
    columns, noise = [np.log(run.frequency)], [np.full(len(run), measurement.frequency_error)]
    for point, _ in condition.sensors:
        amplitude = _nowhere_zero(run, points[point]) / turn
        deviation = relative_deviation(run, points[point])
        columns += [np.log(np.abs(amplitude)), np.unwrap(np.angle(amplitude))]
        unknown = points[point] in run.without_phase
        noise += [deviation, np.full(len(run), np.inf) if unknown else deviation]
    log_force = np.log(np.abs(run.force) / condition.force)
    level = None
    if condition.control is not None:
        held = run.amplitude(run.held_channel or run.channels[0])
        w = 2 * np.pi * run.frequency
        level = np.log(np.abs(held) * w**condition.control.derivatives / condition.control.level)
    return Observations(run.name, test, run.repeat, np.column_stack(columns), np.column_stack(noise), log_force, level)


def _nowhere_zero(run: MeasuredRun, channel: str) -> NDArray[np.complex128]:
    """Its amplitudes. raises: MeasurementError where one is zero and has no logarithm"""
    amplitude = run.amplitude(channel)
    if (zero := amplitude == 0).any():
        raise MeasurementError(
            f"run '{run.name}' channel '{channel}': response = 0 at {zero.sum()} of {len(run)} frequencies, the first "
            f"{run.frequency[zero][0]:g} Hz; leave these frequencies out"
        )
    return amplitude


def relative_deviation(run: MeasuredRun, channel: str) -> Floats:
    """(n,) relative standard deviation of an amplitude: as stated, or from how rough the run is.

    Its roughness is that of the amplitude over the force: where a controller holds the response, it is the force that
    carries the noise.
    """
    amplitude = run.amplitude(channel)
    if run.noise is not None:
        stated = run.noise[run.channels.index(channel), run.harmonics.index(1)]
        return np.asarray(stated / np.abs(amplitude))
    return np.full(len(run), roughness(np.log(np.abs(amplitude / run.force))))


def _pooled(observations: Sequence[Observations], conditions: Sequence[RunCondition]) -> list[Observations]:
    """With the noise of each sensor drawn towards what all its runs have in common."""
    noise = [o.own.copy() for o in observations]
    places: dict[tuple[str, int], list[tuple[int, int]]] = {}
    for i, o in enumerate(observations):
        for j, sensor in enumerate(conditions[o.test].sensors):
            places.setdefault(sensor, []).append((i, 1 + 2 * j))
    for each in places.values():
        levels = np.array([np.median(np.log(noise[i][:, column])) for i, column in each])
        better = shrunk(levels, [len(observations[i]) for i, _ in each])
        for (i, column), factor in zip(each, np.exp(better - levels), strict=True):
            noise[i][:, column : column + 2] *= factor
    return [replace(o, own=n) for o, n in zip(observations, noise, strict=True)]
