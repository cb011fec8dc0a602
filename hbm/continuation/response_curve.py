"""What the harmonic balance stage hands on: one branch of periodic responses."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.interpolate import CubicSpline
from scipy.optimize import minimize_scalar

from updamp.hbm.harmonics import Harmonics

Floats = NDArray[np.float64]
Integers = NDArray[np.int64]
Complex = NDArray[np.complex128]


@dataclass(frozen=True, eq=False)
class Extreme:
    """Of a quantity along a branch. near: the points about it; length: of these along the branch; at: the length at
    which the extreme is expected, and its value there"""

    near: slice
    length: Floats
    at: float
    value: float

    @property
    def after(self) -> int:
        """Number among the points about it of the first one beyond it."""
        return int(np.searchsorted(self.length, self.at))


@dataclass(frozen=True, eq=False)
class ResponseCurve:
    """A branch at constant force, its points in the order in which continuation met them.

    mode: name of the study's mode, such as "OOP"; force: amplitude [N]
    orders: harmonics; coefficients ordered as in hbm/harmonics.py
    points: names of the observed points, such as "blade_right.tip.x"
    frequency: (n,) [Hz]
    displacement: (n, n_relative, n_coefficients) relative displacement at the contacts [m]
    response: (n, n_points, n_coefficients) displacement of the observed points [m]
    work_in, friction_loss, material_loss: (n,) energy a cycle [J]
    iterations: (n,) of Newton; error: (n,) residual over displacement; active: (n,) rows that slip or separate
    after_gap: (n,) whether the branch was not followed from the point before
    complete: whether it is the whole branch through its window (hbm/continuation/completeness.py)
    stopped: why not, if it is not ("" otherwise)
    seconds: processor wall time spent
    detached: branches at the same force that are no part of it, as far as they were met: `complete` where they close
    """

    mode: str
    force: float
    orders: tuple[int, ...]
    points: tuple[str, ...]
    frequency: Floats
    displacement: Floats
    response: Floats
    work_in: Floats
    friction_loss: Floats
    material_loss: Floats
    iterations: Integers
    error: Floats
    active: Integers
    after_gap: NDArray[np.bool_]
    complete: bool
    stopped: str
    seconds: float
    detached: tuple["ResponseCurve", ...] = ()

    def __len__(self) -> int:
        return len(self.frequency)

    @property
    def harmonics(self) -> Harmonics:
        return Harmonics(self.orders)

    def gaps(self) -> Floats:
        """(n_gaps, 2) frequencies [Hz] at both sides of each place where the branch was not followed."""
        after = np.flatnonzero(self.after_gap)
        return np.column_stack([self.frequency[after - 1], self.frequency[after]])

    @property
    def unconverged(self) -> int:
        """Points that were wanted and not reached: a stopped branch counts as one."""
        return int(bool(self.stopped))

    def amplitude(self, point: str, k: int = 1) -> Complex:
        """(n,) complex amplitude of harmonic k at a named point [m].

        raises: ValueError naming the points there are
        """
        if point not in self.points:
            raise ValueError(f"no point '{point}' on this curve; there are {', '.join(self.points)}")
        return self.harmonics.amplitude(self.response[:, self.points.index(point)], k)

    def amplitudes(self) -> Complex:
        """(n, n_points) first harmonics of all observed points [m]"""
        return np.stack([self.amplitude(point) for point in self.points], axis=1)

    def receptance(self, point: str) -> Complex:
        """(n,) first harmonic over force [m/N]"""
        return self.amplitude(point) / self.force

    def stands_still(self, point: str, share: float) -> bool:
        """Whether its first harmonic is nowhere more than this share of the largest response of all."""
        return bool(np.abs(self.amplitude(point)).max() <= share * np.abs(self.response).max())

    def peak(self, point: str) -> tuple[float, float]:
        """Frequency [Hz] and receptance [m/N] at the largest first harmonic: the top of a cubic spline through the
        points around it, over the length of the branch, so that overhanging peaks are met as well.

        raises: ValueError where the curve has no points, saying why it stopped
        """
        if not len(self):
            raise ValueError(f"{self.mode} {self.force:g} N: the curve has no points, so no peak; {self.stopped}")
        size = np.abs(self.receptance(point))
        i = int(np.argmax(size))
        top = self.extreme(size, i, point)
        if top is None or top.value < size[i]:
            return float(self.frequency[i]), float(size[i])
        return float(CubicSpline(top.length, self.frequency[top.near])(top.at)), top.value

    def extreme(self, values: Floats, place: int, point: str) -> Extreme | None:
        """Where a cubic spline through the points about one of them is highest, over the length of the branch as seen
        at a named point: within the points beside it, none of them across a gap. None for fewer than four points,
        where two are the same, and where the named point stands still.

        values: (n,) of which the largest is sought, such as the frequency at a fold
        """
        about = self._spline_about(values, place, point)
        if about is None:
            return None
        near, length, spline = about
        ends = (length[max(place - near.start - 1, 0)], length[min(place - near.start + 1, len(length) - 1)])
        at = float(minimize_scalar(lambda t: -float(spline(t)), bounds=ends).x)
        return Extreme(near, length, at, float(spline(at)))

    def hidden_extreme(self, values: Floats, place: int, point: str) -> Extreme | None:
        """Where such a spline has its first maximum between a point and the next one, of values that rise from the one
        to the other; None where it has none."""
        about = self._spline_about(values, place, point)
        if about is None or place + 1 >= about[0].stop:
            return None
        near, length, spline = about
        low, high = length[place - near.start], length[place - near.start + 1]
        turns = [at for at in spline.derivative().roots(extrapolate=False) if low < at < high]
        highest = [float(at) for at in turns if spline(at, 2) < 0]
        return Extreme(near, length, highest[0], float(spline(highest[0]))) if highest else None

    def _spline_about(self, values: Floats, place: int, point: str) -> tuple[slice, Floats, CubicSpline] | None:
        near = self._without_gap(place, 3)
        f, z = self.frequency[near], self.receptance(point)[near]
        size = np.abs(z[place - near.start])
        if len(f) < 4 or size == 0:
            return None
        width = max(float(np.ptp(f)), np.finfo(float).tiny)
        length = np.concatenate([[0.0], np.cumsum(np.hypot(np.abs(np.diff(z)) / size, np.diff(f) / width))])
        if (np.diff(length) <= 0).any():  # a point met twice
            return None
        return near, length, CubicSpline(length, values[near])

    def _without_gap(self, place: int, reach: int) -> slice:
        """The points up to so many places beside one, of its piece of the curve alone."""
        gaps = np.flatnonzero(self.after_gap)
        first = max([int(g) for g in gaps if g <= place], default=0)
        end = min([int(g) for g in gaps if g > place], default=len(self.frequency))
        return slice(max(place - reach, first), min(place + reach + 1, end))
