"""Tops read off measured runs and off the model in the same way: frequency, height, damping where the phase
shows it.

The oscillator through five points is off where a response is none, as beside a kink, and by how much depends on where
the points lie about the top. So the model is read at the frequencies of the run, shifted until its top lies among them
where the run's does: what the reading is off by is then the same in both.
"""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from updamp.comparison.findings.backbone import (
    FIVE,
    five_about,
    half_power_frequency,
    loss_by_phase,
    read_resonance,
    summit,
    summit_deviation,
)
from updamp.comparison.findings.tops import highest
from updamp.comparison.fit.matching import Matched, by_drive
from updamp.comparison.fit.observations import Observations
from updamp.comparison.prediction.predicted_branch import PredictedBranch

Floats = NDArray[np.float64]
Complex = NDArray[np.complex128]

_PLACES = 2000  # looked at along a branch
_STEPS = np.arange(FIVE) - FIVE // 2
_ROUNDS = 8  # of the shift, each of which leaves a fraction of what it was off by


@dataclass(frozen=True, eq=False)
class Tops:
    """One entry a sensor. value: (2 s,) logarithms of the frequencies [Hz], then of the heights; loss_factor: (s,) nan
    where the phase does not tell; phase: (s,) mean over the points about the top [rad], nan where they do not enclose
    it"""

    value: Floats
    loss_factor: Floats
    phase: Floats


def tops_of_run(o: Observations, sensors: Sequence[int]) -> Tops:
    """Heights over the measured force, as a share of the condition's."""
    of_sensor = [(_log_receptance(o, j), place_of_top(o, j)) for j in sensors]
    tops = [_top(o.frequency, log_receptance, i) for log_receptance, i in of_sensor]
    loss = [
        _loss_factor(o.frequency, log_receptance, o.noise[:, 1 + 2 * j])
        for j, (log_receptance, _) in zip(sensors, of_sensor, strict=True)
    ]
    phase = [_phase(log_receptance[five_about(i)]) for log_receptance, i in of_sensor]
    return Tops(np.array(tops).T.ravel(), np.array(loss), np.array(phase))


def place_of_top(o: Observations, sensor: int) -> int:
    """Of a run's highest top that chance does not make; at an end where there is none."""
    return highest(_log_size(o, sensor), o.noise[:, 1 + 2 * sensor])


def reading_noise(o: Observations, sensors: Sequence[int]) -> Floats:
    """(2 s,) deviations of a run's tops by the sensors' stated noise; a place is known to two steps at worst."""
    frequency, height = [], []
    for j in sensors:
        i, step = _top_and_step(o, j)
        of_top, of_place = summit_deviation(o.observed[:, 0], _log_size(o, j), i)
        noise = float(o.noise[i, 1 + 2 * j])
        height.append(of_top * noise)
        frequency.append(min(of_place * noise, 2.0 * step))
    return np.array(frequency + height)


def damping_noise(o: Observations, sensors: Sequence[int]) -> Floats:
    """(s,) deviations of the logarithms of a run's loss factors (`Tops.loss_factor`) by the sensors' stated noise, to
    first order: of a top with points on one side of it alone they are hardly known."""
    return np.array([_noise_of_damping(o, j) for j in sensors])


def _noise_of_damping(o: Observations, sensor: int) -> float:
    log_receptance, noise = _log_receptance(o, sensor), o.noise[:, 1 + 2 * sensor : 3 + 2 * sensor]
    if not np.isfinite(noise).all():
        return float("inf")
    changes, top = [], place_of_top(o, sensor)
    for unit, deviations in zip((1.0, 1.0j), noise.T, strict=True):
        for each in np.diag(unit * deviations):
            ends = [loss_by_phase(o.frequency, np.exp(log_receptance + sign * each), top) for sign in (1, -1)]
            changes.append(np.log(ends[0] / ends[1]) / 2)
    return float(np.linalg.norm(np.nan_to_num(changes, nan=np.inf)))


def _top_and_step(o: Observations, sensor: int) -> tuple[int, float]:
    """Place of the largest point (two off the ends at least), and the spacing of log f there."""
    i = int(np.clip(place_of_top(o, sensor), 2, max(len(o) - 3, 2)))
    around = o.observed[five_about(i), 0]
    return min(i, len(o) - 1), float(np.ptp(around)) / max(len(around) - 1, 1)


def _log_size(o: Observations, sensor: int) -> Floats:
    """Over the measured force, as a share of the condition's."""
    return np.asarray(o.observed[:, 1 + 2 * sensor] - o.log_force)


def _log_receptance(o: Observations, sensor: int) -> Complex:
    return _log_size(o, sensor) + 1j * o.observed[:, 2 + 2 * sensor]


def _top(frequency: Floats, log_receptance: Complex, i: int) -> tuple[float, float]:
    """Logarithms of the frequency and the height of the top at the i-th point."""
    height, at = summit(frequency, log_receptance, i)
    return float(np.log(at)), height


def _loss_factor(frequency: Floats, log_receptance: Complex, deviation: Floats | None = None) -> float:
    if len(frequency) < FIVE:
        return float("nan")
    return read_resonance(frequency, np.exp(log_receptance), np.ones(len(frequency)), deviation).loss_factor


def _phase(log_receptance: Complex) -> float:
    """Mean over the five points about a top."""
    return float(np.mean(np.unwrap(log_receptance.imag))) if len(log_receptance) == FIVE else float("nan")


@dataclass(frozen=True, eq=False)
class SweptBranch:
    """A branch on the parts that the sweep visits, densely. place: (n,); observed: (n, m); slopes: (n, p, m) by the
    parameters; step: spacing of the measured points at the top, of the logarithm of the frequency"""

    branch: PredictedBranch
    place: Floats
    observed: Floats
    slopes: Floats
    step: float

    def tops(self, sensors: Sequence[int]) -> Floats:
        """(2 s,) as `Tops.value`, by points about its own tops"""
        return self._values(sensors, self.observed)

    def is_smooth(self, sensors: Sequence[int]) -> bool:
        """Whether the curve goes on beyond its top on both sides as far as a run's points that are read."""
        tops = [self._highest(j, self.observed) for j in sensors]
        return all(self._points_about(i, self.observed[:, 0]) is not None for i in tops)

    def has_smooth_run(self, m: Matched, sensors: Sequence[int]) -> bool:
        """Whether a run has a top among the points that are read, and all of these on one part of the branch: it does
        not end on the way up, nor jump there."""
        o = m.observations
        for j in sensors:
            log_receptance, i = _log_receptance(o, j), place_of_top(o, j)
            near = m.place[five_about(i)]
            if summit(o.frequency, log_receptance, i)[1] == o.frequency[i]:
                return False
            if not self.branch.seen_from(near.min(), near.max()):
                return False
        return True

    def tops_as_measured(self, o: Observations, sensors: Sequence[int]) -> Tops:
        """At the frequencies of the run, shifted for each sensor until the top lies among them where the run's does; by
        points about its own top where the sweep does not pass those."""
        measured, of_model = tops_of_run(o, sensors).value, self.tops(sensors)
        tops, loss, phase = [], [], []
        for k, j in enumerate(sensors):
            i, part = place_of_top(o, j), self._part(j)
            by_itself = (float(of_model[k]), float(of_model[len(sensors) + k]))
            top = _shifted_top(part, o.frequency[five_about(i)], min(i, FIVE // 2), float(measured[k]), by_itself)
            tops.append(top)
            shift = np.exp(top[0] - measured[k])
            loss.append(_loss_factor(*part.at(o.frequency * shift)))
            phase.append(_phase(part.at(o.frequency[five_about(i)] * shift)[1]))
        return Tops(np.array(tops).T.ravel(), np.array(loss), np.array(phase))

    def _part(self, sensor: int) -> "_Part":
        """The part with the top: what the sweep passes before it jumps, or afterwards."""
        part = self.observed[self._about(self.observed[:, 0], self._highest(sensor, self.observed), np.inf)]
        log_f, log_size, phase = part[np.argsort(part[:, 0])][:, [0, 1 + 2 * sensor, 2 + 2 * sensor]].T
        return _Part(log_f, log_size, np.unwrap(phase))

    def places(self, sensors: Sequence[int]) -> Floats:
        """(s,) of the tops along the branch"""
        return self.place[[self._highest(j, self.observed) for j in sensors]]

    def by_parameter(self, sensors: Sequence[int], steps: Floats) -> Floats:
        """(p, 2 s) derivatives of the tops' values, by central differences."""
        found = []
        for k, step in enumerate(steps):
            ends = [self._values(sensors, self.observed + sign * step * self.slopes[:, k]) for sign in (1, -1)]
            found.append((ends[0] - ends[1]) / (2 * step))
        return np.array(found)

    def by_drive(self, o: Observations, sensors: Sequence[int]) -> Floats:
        """(2 s,) what the force as measured at a run's tops does to the model's."""
        slopes = self.branch.at(self.places(sensors)).slopes
        frequency, height = [], []
        for j, of_place in zip(sensors, slopes, strict=True):
            i = place_of_top(o, j)
            change = by_drive(o, of_place[None])[i]
            frequency.append(change[0])
            height.append(change[1 + 2 * j] - o.log_force[i])
        return np.array(frequency + height)

    def has_top(self, sensor: int) -> bool:
        """Whether there is one in the measured window, or just beyond it; no end of what the sweep sees."""
        i = self._highest(sensor, self.observed)
        return 0 < i < len(self.observed) - 1

    def half_width(self, sensor: int) -> float:
        """Over the frequency, by how narrow the peak is at 1/sqrt(2) of its height; a tenth of the window where that
        is not seen."""
        frequency, size = np.exp(self.observed[:, 0]), np.exp(self.observed[:, 1 + 2 * sensor])
        i = self._highest(sensor, self.observed)
        widths = np.abs(
            np.array([half_power_frequency(frequency, size, i, side) for side in (-1, 1)]) / frequency[i] - 1
        )
        widths = widths[widths > 0]
        low, high = self.branch.condition.window
        return float(np.mean(widths)) if len(widths) else 0.1 * float(np.log(high / low))

    def _values(self, sensors: Sequence[int], observed: Floats) -> Floats:
        """(2 s,)"""
        return np.array([self._top(j, observed) for j in sensors]).T.ravel()

    def _top(self, sensor: int, observed: Floats) -> tuple[float, float]:
        """Logarithms of frequency and height, by a parabola through five points as far apart as the measured ones."""
        i = self._highest(sensor, observed)
        log_f, log_size = observed[:, 0], observed[:, 1 + 2 * sensor]
        near = self._points_about(i, log_f)
        if near is None:
            return float(log_f[i]), float(log_size[i])
        order = np.argsort(log_f[near])
        f = log_f[i] + self.step * _STEPS
        height, at = summit(f, np.interp(f, log_f[near][order], log_size[near][order]), 2)
        return at, height

    def _about(self, log_f: Floats, i: int, reach: float) -> slice:
        """The run of neighbours of a place as far as the frequency goes one way and is within reach, up to where the
        sweep jumps."""
        direction, far = np.sign(np.gradient(log_f)), np.abs(log_f - log_f[i]) >= reach
        one_way = direction == direction[i]
        goes_on = np.diff(self.place) < 1.5 * np.diff(self.place).min()  # evenly spaced; a gap is two steps and more
        low, high, last = i, i, len(log_f) - 1
        while low > 0 and goes_on[low - 1] and one_way[low - 1] and not far[low]:
            low -= 1
        while high < last and goes_on[high] and one_way[high + 1] and not far[high]:
            high += 1
        return slice(low, high + 1)

    def _points_about(self, i: int, log_f: Floats) -> slice | None:
        """The run of places about a top in which five points as far apart as the measured ones lie; None without."""
        near = self._about(log_f, i, 3 * self.step)
        (low, high), (first, last) = (log_f[near].min(), log_f[near].max()), log_f[i] + self.step * _STEPS[[0, -1]]
        return near if low <= first and last <= high else None

    def _highest(self, sensor: int, observed: Floats) -> int:
        """The highest top inside the measured window, at whose edges the curve may climb to another mode's; where it
        has none inside, from its highest place uphill to the nearest."""
        log_size, n = observed[:, 1 + 2 * sensor], len(observed)
        low, high = np.log(self.branch.condition.window)
        inside = np.flatnonzero((observed[:, 0] >= low) & (observed[:, 0] <= high))
        i = int(inside[highest(log_size[inside])]) if len(inside) else int(np.argmax(log_size))
        while True:
            best = max(range(max(i - 1, 0), min(i + 2, n)), key=lambda k: log_size[k])
            if best == i:
                return i
            i = best


def swept_branch(branch: PredictedBranch, runs: Sequence[Observations], sensor: int) -> SweptBranch:
    """runs: of the branch's condition; sensor: whose points tell how densely was measured"""
    place = branch.seen_places(_PLACES)
    observed = branch.at(place)
    step = float(np.median([_top_and_step(o, sensor)[1] for o in runs]))
    return SweptBranch(branch, place, observed.value, observed.slopes[:, :-1], step)


@dataclass(frozen=True, eq=False)
class _Part:
    """Of one sensor, by rising frequency: logarithms of frequency and size, phase [rad]; each (k,)"""

    log_f: Floats
    log_size: Floats
    phase: Floats

    def at(self, frequency: Floats) -> tuple[Floats, Complex]:
        """Those of the frequencies [Hz] that lie on it, and the logarithm of the response there."""
        log_f = np.log(frequency)
        on = (log_f >= self.log_f[0]) & (log_f <= self.log_f[-1])
        size, phase = (np.interp(log_f[on], self.log_f, values) for values in (self.log_size, self.phase))
        return frequency[on], size + 1j * phase


def _shifted_top(
    part: _Part, near: Floats, i: int, measured: float, by_itself: tuple[float, float]
) -> tuple[float, float]:
    """Logarithms of frequency and height, read off the run's points about its top, shifted by as much as the model's
    top is then read off it: of the rounds the one that comes nearest; `by_itself` where they do not lie on the part.

    near: frequencies of these points, of which the i-th is the highest; measured: log f of the run's top
    """
    shift, tried = by_itself[0] - measured, []
    for _ in range(_ROUNDS):
        f, log_receptance = part.at(near * np.exp(shift))
        if len(f) < len(near):
            break
        height, at = summit(f, log_receptance, i)
        tried.append((abs(np.log(at) - measured - shift), (float(np.log(at)), height)))
        shift = float(np.log(at)) - measured
    return min(tried, default=(0.0, by_itself))[1]
