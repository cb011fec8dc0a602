"""Solved points at resonances of the structure that its elements hardly feel.

A branch is stepped along by how far the elements move (hbm/newton/metric.py). A resonance at whose mode they rest, such
as one with a node there, is no way at all for them: a step passes over it, though elsewhere it may be the highest of
all. What elements hardly feel they hardly change: such a resonance is that of the structure at small amplitudes. One
that moves them by a step or more has shifted it, and is seen.
"""

from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from updamp.hbm.continuation.branch import point_at
from updamp.hbm.continuation.curve_records import CurveRequest, with_point
from updamp.hbm.continuation.response_curve import ResponseCurve
from updamp.hbm.newton.newton import solve
from updamp.hbm.problem.small_amplitude import SmallAmplitude, element_stiffness, modes_on
from updamp.hbm.problem.system import Excitation, NonlinearSystem

Floats = NDArray[np.float64]


def with_hardly_felt_resonances(system: NonlinearSystem, request: CurveRequest, curve: ResponseCurve) -> ResponseCurve:
    """The curve with points at the resonances of small amplitudes wherever a step has passed over one that is there,
    and on both sides of it, until no step is longer than its distance from the resonance."""
    for resonance in _resonances(system, request, curve):
        without, curve = curve, _with_top(system, request, curve, resonance)
        if curve is without:
            continue
        for distance in resonance.distances:
            for frequency in (resonance.frequency - distance, resonance.frequency + distance):
                for i in _passes(curve, frequency, distance):
                    curve = _with_point_after(system, request, curve, resonance, i, frequency)
    return curve


@dataclass(frozen=True, eq=False)
class _Resonance:
    """Of one of the modes at small amplitudes. share: of the least response on the curve, how large its own is; window:
    width of the window [Hz]"""

    modes: SmallAmplitude
    mode: int
    share: float
    window: float

    @property
    def frequency(self) -> float:
        """[Hz]"""
        return float(self.modes.frequencies[self.mode])

    @property
    def half_width(self) -> float:
        """Half of what lies between the half-power points [Hz]"""
        return self.frequency * self.modes.loss_factor(self.mode) / 2

    @property
    def distances(self) -> Floats:
        """From it [Hz], each twice the one before, until the mode's own response, which falls as the distance grows,
        has become as small as the least one, or the window ends."""
        farthest = min(self.share, self.window / self.half_width)
        return self.half_width * 2.0 ** np.arange(max(np.ceil(np.log2(farthest)), 0.0) + 1)

    def motion(self, system: NonlinearSystem, excitation: Excitation, frequency: float) -> Floats:
        """(n_relative, n_coefficients) of the elements, by the mode alone [m]"""
        found = np.zeros((system.free.n_relative, system.harmonics.n_coefficients))
        by_unit = self.modes.motion(self.mode, excitation.row, 2 * np.pi * frequency)
        system.harmonics.set_amplitude(found, 1, excitation.force * by_unit[: len(found)])
        return found


def _resonances(system: NonlinearSystem, request: CurveRequest, curve: ResponseCurve) -> Iterator[_Resonance]:
    """Of damped modes in the window, that could change the response at a told point by as much as a step may"""
    if not len(curve):
        return
    near = float(np.mean(request.window))
    free = system.free
    modes = modes_on(free, element_stiffness(system.groups, free.n_relative, near), 2 * np.pi * near)
    told = [free.row(point) for point in request.peaks_at]
    least = np.array([np.abs(curve.receptance(point)).min() for point in request.peaks_at])
    low, high = request.window
    for i in np.flatnonzero((low < modes.frequencies) & (modes.frequencies < high)).tolist():
        if not modes.loss_factor(i) > np.finfo(float).eps:
            continue
        own = np.abs(modes.motion(i, request.excitation.row, 2 * np.pi * float(modes.frequencies[i]))[told])
        share = float((own / np.maximum(least, np.finfo(float).tiny)).max())
        if share > request.options.largest_step:
            yield _Resonance(modes, i, share, high - low)


def _passes(curve: ResponseCurve, frequency: float, step: float) -> list[int]:
    """Numbers of the points after which the branch passes the frequency by more than a step [Hz], from the last one on:
    a point put in after one does not change the numbers of those before."""
    before, after = curve.frequency[:-1], curve.frequency[1:]
    passes = ((before - frequency) * (after - frequency) < 0) & (np.abs(after - before) > step)
    return [int(i) for i in np.flatnonzero(passes & ~curve.after_gap[1:])[::-1]]


def _is_there(request: CurveRequest, curve: ResponseCurve, place: int) -> bool:
    """Whether the response at a told point differs from that of both neighbours by more than a step may."""
    r = np.array([curve.receptance(point)[place - 1 : place + 2] for point in request.peaks_at])
    size, change = np.abs(r[:, ::2]).max(axis=1), np.abs(r[:, ::2] - r[:, 1:2]).min(axis=1)
    return bool((change > request.options.largest_step * size).any())


def _with_top(
    system: NonlinearSystem, request: CurveRequest, curve: ResponseCurve, resonance: _Resonance
) -> ResponseCurve:
    """With a point at the resonance wherever the branch has passed over it and it is there: not where what the elements
    do has moved it elsewhere."""
    for i in _passes(curve, resonance.frequency, resonance.half_width):
        found = _with_point_after(system, request, curve, resonance, i, resonance.frequency)
        if found is not curve and _is_there(request, found, i + 1):
            curve = found
    return curve


def _with_point_after(
    system: NonlinearSystem,
    request: CurveRequest,
    curve: ResponseCurve,
    resonance: _Resonance,
    place: int,
    frequency: float,
) -> ResponseCurve:
    """With a point at the frequency, between that of a number and the next one; as it is where none is found within
    their distance of where it is sought: that is another branch. It is sought where the chord between them has it, with
    what the mode does on top."""
    ends, at_ends = curve.frequency[place : place + 2], curve.displacement[place : place + 2]

    def by_mode(f: float) -> Floats:
        return resonance.motion(system, request.excitation, f)

    start, change = at_ends[0] - by_mode(ends[0]), at_ends[1] - by_mode(ends[1]) - (at_ends[0] - by_mode(ends[0]))
    guess = start + (frequency - ends[0]) / (ends[1] - ends[0]) * change + by_mode(frequency)
    solution = solve(system, request.excitation, guess, 2 * np.pi * frequency, request.options.newton)
    if not solution.converged:
        return curve
    chord = at_ends[1] - at_ends[0], 2 * np.pi * float(ends[1] - ends[0])
    point = point_at(solution, request.excitation, request.options.scale_w(request.window), chord, 0.0)
    if point.metric.length((solution.x - guess, 0.0)) > point.metric.length(chord):
        return curve
    return with_point(system, request, curve, point, place + 1)
