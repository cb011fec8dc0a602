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

    def receptance(self, point: str) -> Complex:
        """(n,) first harmonic over force [m/N]"""
        return self.amplitude(point) / self.force

    def peak(self, point: str) -> tuple[float, float]:
        """Frequency [Hz] and receptance [m/N] at the largest first harmonic: the top of a cubic spline through the
        points around it, over the length of the branch, so that overhanging peaks are met as well.
        """
        size = np.abs(self.receptance(point))
        i = int(np.argmax(size))
        top = self.top(point)
        if top is None:
            return float(self.frequency[i]), float(size[i])
        near, length, at = top
        frequency, height = CubicSpline(length, np.column_stack([self.frequency[near], size[near]]))(at)
        return (float(frequency), float(height)) if height >= size[i] else (float(self.frequency[i]), float(size[i]))

    def top(self, point: str) -> tuple[slice, Floats, float] | None:
        """Points about the largest first harmonic, their lengths along the branch, and the length at which a cubic
        spline through them is highest; None for fewer than four points, or where two of them are the same."""
        receptance = self.receptance(point)
        size = np.abs(receptance)
        i = int(np.argmax(size))
        near = slice(max(i - 3, 0), i + 4)
        f, z = self.frequency[near], receptance[near]
        if len(f) < 4:
            return None
        width = max(float(np.ptp(f)), np.finfo(float).tiny)
        length = np.concatenate([[0.0], np.cumsum(np.hypot(np.abs(np.diff(z)) / size[i], np.diff(f) / width))])
        if (np.diff(length) <= 0).any():  # a point met twice
            return None
        spline = CubicSpline(length, size[near])
        ends = (length[max(i - near.start - 1, 0)], length[min(i - near.start + 1, len(f) - 1)])
        return near, length, float(minimize_scalar(lambda t: -float(spline(t)), bounds=ends).x)
