"""How far a curve is from a finer setting: some of its points solved again with more harmonics, samples or cycles.

A point is solved again on the plane across the branch there, so that what is compared is the shift of the branch, not
the (much larger) change at a fixed frequency on a steep flank. At the peak five points are, and the top of both sets is
read off in the same way.

The estimate is the change to the next finer setting, not a bound: harmonic by harmonic the solution approaches its
limit from both sides.
"""

from collections.abc import Iterable, Mapping
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray
from scipy.interpolate import PchipInterpolator

from updamp.hbm.analysis.settings import Refinement, setting_of, with_setting
from updamp.hbm.continuation.branch import BranchPoint, branch_point
from updamp.hbm.continuation.curve import CurveRequest
from updamp.hbm.continuation.response_curve import ResponseCurve
from updamp.hbm.newton import observe
from updamp.hbm.newton.metric import Metric
from updamp.hbm.newton.newton import Arc, solve
from updamp.hbm.problem.system import NonlinearSystem

Floats = NDArray[np.float64]
Integers = NDArray[np.int64]

NEIGHBOURS = 2  # on either side of the peak
FLANK = 0.9  # of the peak's height: how far down the neighbours reach, so that it may move between them


@dataclass(frozen=True)
class Deviation:
    """A finer setting less the curve. NaN where the finer problem was not solved.

    peak_percent: height of the peak, in percent of it; peak_hertz: shift of the resonance, at the phase of the peak
    elsewhere_percent: largest change of the amplitude at the other points, percent of the peak
    unsolved: frequencies [Hz] at which the finer problem was not solved
    """

    peak_percent: float
    peak_hertz: float
    elsewhere_percent: float
    unsolved: tuple[float, ...] = ()


@dataclass(frozen=True, eq=False)
class CheckedPoints:
    """The points of a curve that are solved again.

    near: those around the peak; elsewhere: others, by place on the curve
    branch: all of them with their tangents, by place on the curve
    """

    system: NonlinearSystem
    request: CurveRequest
    curve: ResponseCurve
    point: str
    near: Integers
    elsewhere: Integers
    branch: dict[int, BranchPoint]

    @staticmethod
    def at(
        system: NonlinearSystem,
        request: CurveRequest,
        curve: ResponseCurve,
        point: str,
        elsewhere: Integers,
    ) -> "CheckedPoints":
        """The peak, and these places."""
        near = _around_the_peak(np.abs(curve.amplitude(point)))
        places = sorted({int(i) for i in (*near, *elsewhere)})
        branch = {i: _branch_point(system, request, curve, i) for i in places}
        return CheckedPoints(system, request, curve, point, near, elsewhere, branch)

    def deviation(self, refine: Refinement) -> Deviation:
        """What a finer setting changes at the selected points."""
        finer = refine(setting_of(self.system))
        moved = {i: solve_again(self.request, p, with_setting(self.system, finer)) for i, p in self.branch.items()}
        unsolved = tuple(float(self.curve.frequency[i]) for i, p in moved.items() if p is None)
        before, after = (_Peak.of(self, points) for points in (self.branch, moved))
        elsewhere = [self._change(i, moved[i]) / before.height for i in self.elsewhere]
        return Deviation(
            peak_percent=100 * (after.height / before.height - 1),
            peak_hertz=self._peak_shift(before, after, moved),
            elsewhere_percent=100 * _largest(elsewhere),
            unsolved=unsolved,
        )

    def _peak_shift(self, before: "_Peak", after: "_Peak", moved: Mapping[int, BranchPoint | None]) -> float:
        """At the phase of the peak [Hz]; where phase does not tell, of the largest point across the branch."""
        by_phase = after.frequency(before.phase) - before.frequency(before.phase)
        top = int(self.near[before.top])
        return by_phase if np.isfinite(by_phase) else _shift(self.branch[top], moved[top])

    def _change(self, place: int, moved: BranchPoint | None) -> float:
        """Of the receptance's size at one point."""
        if moved is None:
            return np.nan
        before, after = (local_curve(self.curve, self.request, [p], self.point) for p in (self.branch[place], moved))
        return float(np.abs(after.receptance(self.point))[0] - np.abs(before.receptance(self.point))[0])


@dataclass(frozen=True, eq=False)
class _Peak:
    """height: receptance [m/N] at the top of the points around the peak; near: those points as a curve of its own.

    The frequency of a flat top is badly determined (0.1 Hz up and down from one harmonic to the next where its height
    has settled to 0.1 %), while phase runs through a resonance evenly: so its shift is read at a phase.
    """

    height: float
    near: ResponseCurve | None
    point: str

    @staticmethod
    def of(checked: CheckedPoints, points: Mapping[int, BranchPoint | None]) -> "_Peak":
        """Not a number where a point is missing."""
        solved = [p for p in (points[int(i)] for i in checked.near) if p is not None]
        if len(solved) < len(checked.near):
            return _Peak(np.nan, None, checked.point)
        near = local_curve(checked.curve, checked.request, solved, checked.point)
        return _Peak(near.peak(checked.point)[1], near, checked.point)

    @property
    def top(self) -> int:
        """Place of the largest of the points."""
        assert self.near is not None, "the curve itself has all its points"
        return int(np.argmax(np.abs(self.near.receptance(self.point))))

    @property
    def phase(self) -> float:
        """At the largest of the points [rad]"""
        assert self.near is not None, "the curve itself has all its points"
        return float(np.angle(self.near.receptance(self.point)[self.top]))

    def frequency(self, phase: float) -> float:
        """At which the phase is met, along the branch [Hz]; not a number where it is not or does not fall evenly."""
        if self.near is None:
            return np.nan
        lag = -np.unwrap(np.angle(self.near.receptance(self.point) * np.exp(-1j * phase)))
        lag, frequency = (lag, self.near.frequency) if lag[-1] > lag[0] else (lag[::-1], self.near.frequency[::-1])
        if (np.diff(lag) <= 0).any() or not lag[0] <= 0 <= lag[-1]:
            return np.nan
        return float(PchipInterpolator(lag, frequency)(0.0))


def _around_the_peak(size: Floats) -> Integers:
    """Places of the largest of `size` and of neighbours on both sides, spread over the points above the flank."""
    top = int(np.argmax(size))
    below = np.flatnonzero(size < FLANK * size[top])
    low = min(int(below[below < top].max(initial=-1)) + 1, top - NEIGHBOURS)
    high = max(int(below[below > top].min(initial=len(size))) - 1, top + NEIGHBOURS)
    sides = np.concatenate([np.linspace(low, top, NEIGHBOURS + 1), np.linspace(top, high, NEIGHBOURS + 1)])
    return np.unique(np.clip(np.round(sides).astype(np.int64), 0, len(size) - 1))


def local_curve(
    curve: ResponseCurve, request: CurveRequest, points: Iterable[BranchPoint], point: str
) -> ResponseCurve:
    """A few points as a curve of its own, observed at one point."""
    chosen = list(points)
    system = chosen[0].solution.equation.receptance.system
    rows = np.array([system.free.row(point)])
    response = [observe.response(p.solution.equation, request.excitation, rows) for p in chosen]
    return replace(
        curve,
        orders=system.harmonics.orders,
        points=(point,),
        frequency=np.array([p.frequency for p in chosen]),
        response=np.array(response),
        displacement=np.array([p.x for p in chosen]),
    )


def solve_again(request: CurveRequest, start: BranchPoint, finer: NonlinearSystem) -> BranchPoint | None:
    """The point of another setting's branch on the plane across the branch at `start`; None where none is found."""
    known = start.solution.equation.receptance.system.harmonics
    scale_w = request.options.scale_w(request.window)
    x, tangent_x = (known.change_to(finer.harmonics, values) for values in (start.x, start.tangent_x))
    arc = Arc(x, start.w, (tangent_x, start.tangent_w), Metric.at(x, finer.harmonics, scale_w))
    solution = solve(finer, request.excitation, x, start.w, request.options.newton, arc)
    if not solution.converged:
        return None
    direction = (tangent_x, start.tangent_w)
    return branch_point(finer, request.excitation, solution.x, solution.w, scale_w, direction)


def _branch_point(system: NonlinearSystem, request: CurveRequest, curve: ResponseCurve, place: int) -> BranchPoint:
    x, w = curve.displacement, 2 * np.pi * curve.frequency
    before, after = max(place - 1, 0), min(place + 1, len(curve) - 1)
    direction = (x[after] - x[before], float(w[after] - w[before]))
    scale_w = request.options.scale_w(request.window)
    return branch_point(system, request.excitation, x[place], float(w[place]), scale_w, direction)


def _shift(before: BranchPoint, after: BranchPoint | None) -> float:
    return np.nan if after is None else after.frequency - before.frequency


def _largest(values: list[float]) -> float:
    """Of the sizes; 0 for none, NaN where one is missing."""
    return float(np.max(np.abs(values))) if values else 0.0
