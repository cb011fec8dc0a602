"""Solved points at resonances of the structure that its elements hardly feel.

A branch is stepped along by how far the elements move (hbm/newton/metric.py). A resonance at whose mode they rest, such
as one with a node there, is no way at all for them: a step passes over it, though elsewhere it may be the highest of
all. Such a resonance is that of the structure on elements as stiff as they are on top of the branch's motion there.
Where a step has passed over its frequency a point is solved at it; where it moves the elements by more than a step, or
no such point is found near, the branch is traced across it. One that moves them much is not passed over: it keeps ahead
of the branch up to the peak, to which the steps lead.
"""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from updamp.hbm.continuation.branch import BranchPoint, point_at
from updamp.hbm.continuation.continuation import BranchStoppedError, continue_branch
from updamp.hbm.continuation.curve_records import CurveRequest, with_point
from updamp.hbm.continuation.predictor_corrector import CONNECTED
from updamp.hbm.continuation.response_curve import ResponseCurve
from updamp.hbm.continuation.retracing import TracedBranch
from updamp.hbm.newton.metric import Metric
from updamp.hbm.newton.newton import solve
from updamp.hbm.problem.small_amplitude import SmallAmplitude, element_stiffness, modes_on, stiffness_about
from updamp.hbm.problem.system import Excitation, NonlinearSystem

Floats = NDArray[np.float64]

# Half-widths from a resonance to where it is traced across from, at least: there it adds 1/8 of its height. Where it
# has been shifted by more, a branch from there does not lead across, and one from farther out is traced.
_FLANKS = 8.0


def with_hardly_felt_resonances(system: NonlinearSystem, request: CurveRequest, curve: ResponseCurve) -> ResponseCurve:
    """The curve with points at resonances wherever a step has passed over one that is there, and on both sides of it,
    until no step is longer than its distance from the resonance."""
    for at_rest in _resonances(system, request, curve):
        passes = _passes(curve, at_rest.frequency, at_rest.half_width)
        passed = [one for place in passes for one in _passed(system, request, curve, at_rest, place)]
        found = {(place, resonance.mode): resonance for resonance, place in passed}
        for place, mode in sorted(found, reverse=True):  # what is put in after one does not change the numbers before
            curve = _with_resonance(system, request, curve, found[place, mode], place)
    return curve


def _with_resonance(
    system: NonlinearSystem, request: CurveRequest, curve: ResponseCurve, resonance: "_Resonance", place: int
) -> ResponseCurve:
    """place: number of the point after which the branch passes over it"""
    without, curve = curve, _with_top(system, request, curve, resonance, place)
    if curve is without:
        return curve
    for distance in resonance.distances:
        for frequency in (resonance.frequency - distance, resonance.frequency + distance):
            for i in _passes(curve, frequency, distance):
                point = _point_after(system, request, curve, resonance, i, frequency)
                curve = curve if point is None else with_point(system, request, curve, point, i + 1)
    return curve


@dataclass(frozen=True, eq=False)
class _Resonance:
    """Of one of the modes, at small amplitudes or on top of a motion. share: of the least response on the curve, how
    large its own is; window: width of the window [Hz]"""

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
    free = system.free

    def modes_near(f: float) -> SmallAmplitude:
        return modes_on(free, element_stiffness(system.groups, free.n_relative, f), 2 * np.pi * f)

    frequencies = modes_near(float(np.mean(request.window))).frequencies
    low, high = request.window
    for i in np.flatnonzero((low < frequencies) & (frequencies < high)).tolist():
        if (found := _of_mode(system, request, curve, modes_near(float(frequencies[i])), i)) is not None:
            yield found


def _of_mode(
    system: NonlinearSystem, request: CurveRequest, curve: ResponseCurve, modes: SmallAmplitude, mode: int
) -> _Resonance | None:
    """None of a mode without damping, and of one that cannot change what is told by as much as a step may"""
    if not modes.loss_factor(mode) > np.finfo(float).eps:
        return None
    told = [system.free.row(point) for point in request.peaks_at]
    least = np.array([np.abs(curve.receptance(point)).min() for point in request.peaks_at])
    own = np.abs(modes.motion(mode, request.excitation.row, 2 * np.pi * float(modes.frequencies[mode]))[told])
    share = float((own / np.maximum(least, np.finfo(float).tiny)).max())
    return _Resonance(modes, mode, share, np.ptp(request.window)) if share > request.options.largest_step else None


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


def _passed(
    system: NonlinearSystem, request: CurveRequest, curve: ResponseCurve, at_rest: _Resonance, place: int
) -> list[tuple[_Resonance, int]]:
    """Resonances as they are on top of the branch's motion where the branch passes over them, and the number of the
    point after which: that of the mode most like the one at small amplitudes, unless it moves the elements so much that
    it keeps ahead of the branch, sought from where the branch passes over it at small amplitudes, from step to step.
    And of any other mode there that the same step passes over: elements that bear on each other at large amplitudes
    alone make other modes of those at small ones, as of two equal parts the one that leaves them at rest.
    """
    modes = _modes_on_top(system, curve, place)
    others = [(found, place) for found in _within(system, request, curve, place, modes)]
    tried: set[int] = set()
    while True:
        tried.add(place)
        here = _most_alike(at_rest, modes)
        ends = curve.frequency[place : place + 2]
        if ends.min() < here.frequency < ends.max():
            return [*others, *([(here, place)] if np.ptp(ends) > here.half_width else [])]
        ahead = (here.frequency - ends[1]) * (ends[1] - ends[0]) > 0
        place += 1 if ahead else -1
        if place in tried or not 0 <= place < len(curve) - 1 or curve.after_gap[place + 1]:
            return others
        modes = _modes_on_top(system, curve, place)


def _within(
    system: NonlinearSystem, request: CurveRequest, curve: ResponseCurve, place: int, modes: SmallAmplitude
) -> list[_Resonance]:
    """Of the modes on top of the motion in a step, all that it passes over"""
    ends = curve.frequency[place : place + 2]
    inside = np.flatnonzero((ends.min() < modes.frequencies) & (modes.frequencies < ends.max())).tolist()
    found = (_of_mode(system, request, curve, modes, i) for i in inside)
    return [one for one in found if one is not None and np.ptp(ends) > one.half_width]


def _modes_on_top(system: NonlinearSystem, curve: ResponseCurve, place: int) -> SmallAmplitude:
    x = curve.displacement[place : place + 2].mean(axis=0)
    w = 2 * np.pi * float(curve.frequency[place : place + 2].mean())
    return modes_on(system.free, stiffness_about(system, x, w), w)


def _most_alike(at_rest: _Resonance, modes: SmallAmplitude) -> _Resonance:
    """Of the mode most like the one at small amplitudes."""
    alike = np.abs(at_rest.modes.coordinates[:, at_rest.mode] @ modes.coordinates)
    return replace(at_rest, modes=modes, mode=int(np.argmax(alike)))


def _with_top(
    system: NonlinearSystem, request: CurveRequest, curve: ResponseCurve, resonance: _Resonance, place: int
) -> ResponseCurve:
    """With a point at the resonance where it is there. Where it moves the elements by more than a step, or no point at
    it is found near, the branch is traced across."""
    metric = Metric.at(curve.displacement[place], system.harmonics, request.options.scale_w(request.window))
    motion = resonance.motion(system, request.excitation, resonance.frequency)
    felt = metric.length((motion, 0.0)) > request.options.largest_step
    top = None if felt else _point_after(system, request, curve, resonance, place, resonance.frequency)
    if top is None:
        return _with_points_after(system, request, curve, place, _across(system, request, curve, resonance, place))
    found = with_point(system, request, curve, top, place + 1)
    return found if _is_there(request, found, place + 1) else curve


def _with_points_after(
    system: NonlinearSystem, request: CurveRequest, curve: ResponseCurve, place: int, points: Sequence[BranchPoint]
) -> ResponseCurve:
    """Without any there is a gap: what happens in it is not known."""
    for k, point in enumerate(points):
        curve = with_point(system, request, curve, point, place + 1 + k)
    if points:
        return curve
    after_gap = curve.after_gap.copy()
    after_gap[place + 1] = True
    return replace(curve, after_gap=after_gap)


def _across(
    system: NonlinearSystem, request: CurveRequest, curve: ResponseCurve, resonance: _Resonance, place: int
) -> list[BranchPoint]:
    """Points that lead across the resonance, from its one flank to the other, in steps of half its half-width at most;
    none where a branch from the one does not lead to the other. Traced upwards whichever way the curve runs, so that
    the points are the same."""
    low, high = ends = np.sort(curve.frequency[place : place + 2])
    way = slice(None, None, 1 if curve.frequency[place] == low else -1)
    distance, inside = _FLANKS * resonance.half_width, np.array([True, True])
    points: list[BranchPoint] = []
    while not points and inside.any():
        at = np.clip(resonance.frequency + distance * np.array([-1.0, 1.0]), low, high)
        flanks = [_point_after(system, request, curve, resonance, place, float(f)) for f in at]
        points, inside, distance = _between(system, request, resonance, *flanks), at != ends, 2 * distance
    return points[0 if inside[0] else 1 : None if inside[1] else -1][way]


def _between(
    system: NonlinearSystem,
    request: CurveRequest,
    resonance: _Resonance,
    low: BranchPoint | None,
    high: BranchPoint | None,
) -> list[BranchPoint]:
    """Both flanks and what was traced from the lower to the upper one; none where one is missing, or where it does not
    lead there."""
    if low is None or high is None:
        return []
    window = low.frequency, high.frequency
    scale = resonance.half_width / 2 / request.options.largest_step / (window[1] - window[0])
    options = replace(request.options, recoveries=CONNECTED, frequency_scale=scale)
    start, end = (
        point_at(one.solution, request.excitation, options.scale_w(window), (0 * one.x, 1.0), 0.0)
        for one in (low, high)
    )
    points = [start]
    try:
        points += continue_branch(system, request.excitation, window, options, True, [start])
    except BranchStoppedError:
        return []
    if not TracedBranch.through(points).leads_to(end):
        return []
    return [*points[:-1], end]


def _point_after(
    system: NonlinearSystem,
    request: CurveRequest,
    curve: ResponseCurve,
    resonance: _Resonance,
    place: int,
    frequency: float,
) -> BranchPoint | None:
    """A point at the frequency, between that of a number and the next one; None where none is found within their
    distance of where it is sought: that is another branch. It is sought where the chord between them has it, with what
    the mode does on top."""
    ends, at_ends = curve.frequency[place : place + 2], curve.displacement[place : place + 2]

    def by_mode(f: float) -> Floats:
        return resonance.motion(system, request.excitation, f)

    start, change = at_ends[0] - by_mode(ends[0]), at_ends[1] - by_mode(ends[1]) - (at_ends[0] - by_mode(ends[0]))
    guess = start + (frequency - ends[0]) / (ends[1] - ends[0]) * change + by_mode(frequency)
    solution = solve(system, request.excitation, guess, 2 * np.pi * frequency, request.options.newton)
    if not solution.converged:
        return None
    chord = at_ends[1] - at_ends[0], 2 * np.pi * float(ends[1] - ends[0])
    point = point_at(solution, request.excitation, request.options.scale_w(request.window), chord, 0.0)
    near = point.metric.length((solution.x - guess, 0.0)) <= point.metric.length(chord)
    return point if near else None
