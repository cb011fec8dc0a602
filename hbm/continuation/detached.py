"""Branches that are no part of a curve: closed loops, and others that no followed way joins to it.

Some are found while the curve is traced. Others lie at solutions at its force that come from elsewhere, as from a
resonance followed in the force: what the curve does not have is traced from there in both directions, until it closes,
leaves the window, or comes to the curve after all.
"""

import time
from collections.abc import Iterable, Sequence
from dataclasses import replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from updamp.hbm.continuation.branch import point_at
from updamp.hbm.continuation.curve_records import COLUMNS, CurveRequest, Records, put_together
from updamp.hbm.continuation.half_problem import HalfProblem
from updamp.hbm.continuation.pieces import BranchSegment, Part, Pieces
from updamp.hbm.continuation.response_curve import ResponseCurve
from updamp.hbm.continuation.retracing import BranchLimits, Chord, TracedBranch
from updamp.hbm.continuation.segments import segment_from
from updamp.hbm.newton.metric import Metric, to_lines
from updamp.hbm.newton.newton import solve
from updamp.hbm.problem.system import NonlinearSystem

Floats = NDArray[np.float64]
Place = tuple[Floats, float]  # x (n_relative, n_coefficients) [m], w [rad/s]


def detached_through(
    system: NonlinearSystem, request: CurveRequest, curve: ResponseCurve, places: Sequence[Place]
) -> tuple[ResponseCurve, ...]:
    """Further branches at the curve's force, through solutions that neither it nor what it has beside it contains.

    places: solutions at that force, in the curve's harmonics; one that does not converge is left out
    """
    if (half := HalfProblem.of(system, request)) is not None:
        there = [(half.mirror.halved(x), w) for x, w in places]
        found = _through(half.system, half.request, half.halved(curve), there)
        return tuple(map(half.whole, found))
    return _through(system, request, curve, places)


def missing(curve: ResponseCurve, places: Iterable[Place], scale_w: float) -> list[Place]:
    """Those that lie neither on the curve nor on what it has beside it. scale_w: a unit of arc [rad/s]"""
    return [place for place in places if not any(_has(one, place, scale_w) for one in (curve, *curve.detached))]


def apart(first: Records, chain: Sequence[Part], closed: bool) -> ResponseCurve:
    """A chain of segments as a curve of its own; a closed one ends with the point that it begins with."""
    curve = put_together(first, [(part.segment.records, part.backwards, False) for part in chain])
    if closed:
        columns: dict[str, Any] = {name: getattr(curve, name) for name in COLUMNS}
        closing: dict[str, Any] = {name: np.concatenate([values, values[:1]]) for name, values in columns.items()}
        return replace(curve, **closing, complete=True)
    ends_at = "; ".join(part.segment.end_sentence for part in (chain[0], chain[-1]))
    return replace(curve, stopped=f"not followed round: {ends_at}")


def within(window: tuple[float, float], branches: Iterable[ResponseCurve]) -> tuple[ResponseCurve, ...]:
    """Those that come into the window [Hz]: what lies beyond it wholly is no answer to what was asked."""
    low, high = window
    return tuple(one for one in branches if ((low <= one.frequency) & (one.frequency <= high)).any())


def middle(curve: ResponseCurve) -> Place:
    """The place of a curve halfway along its points."""
    i = len(curve) // 2
    return curve.displacement[i], 2 * np.pi * float(curve.frequency[i])


def _through(
    system: NonlinearSystem, request: CurveRequest, curve: ResponseCurve, places: Sequence[Place]
) -> tuple[ResponseCurve, ...]:
    known, scale_w = curve, request.options.scale_w(request.window)
    for place in places:
        if missing(known, [place], scale_w) and (found := _from(system, request, known, place)):
            known = replace(known, detached=(*known.detached, *found))
    return known.detached[len(curve.detached) :]


def _from(
    system: NonlinearSystem, request: CurveRequest, curve: ResponseCurve, place: Place
) -> tuple[ResponseCurve, ...]:
    """The branch through one solution, in both directions; none where it comes to the curve."""
    started, scale_w = time.perf_counter(), request.options.scale_w(request.window)
    solution = solve(system, request.excitation, *place, request.options.persistent)
    if not solution.converged:
        return ()
    start = point_at(solution, request.excitation, scale_w, (0 * solution.x, 1.0), 0.0)
    nothing = BranchSegment(Records(system, request, started), -1.0, iter(()))
    pieces = Pieces(_whole(system, request, curve), nothing)
    pair = [segment_from(system, request, start, upwards, started) for upwards in (True, False)]
    pieces.add(start, *pair)
    for _ in range(request.assembly.detached):
        for segment in pair:
            if segment.active:
                pieces.advance(segment)
        if not any(segment.active for segment in pair):
            break
    return within(request.window, (apart(pair[0].records, *chain) for chain in pieces.detached()))


def _whole(system: NonlinearSystem, request: CurveRequest, curve: ResponseCurve) -> BranchSegment:
    """What is known of the curve and beside it as one segment that crosses the window: nothing is joined to it."""
    chords = [chord for one in (curve, *curve.detached) for chord in _chords(one)]
    segment = BranchSegment(Records(system, request, 0.0), 1.0, iter(()))
    segment.traced = TracedBranch((), chords)
    segment.left_at = 1
    segment.end("it is known")
    return segment


def _chords(curve: ResponseCurve) -> Iterable[Chord]:
    x, w = curve.displacement, 2 * np.pi * curve.frequency
    return (Chord((x[i - 1], w[i - 1]), (x[i], w[i]), None) for i in range(1, len(w)) if not curve.after_gap[i])


def _has(curve: ResponseCurve, place: Place, scale_w: float) -> bool:
    """Whether a place lies on a chord of a curve, as in hbm/continuation/retracing.py: no further off than a share of
    the chord's length, and about the same mean position."""
    (x, w), limits = place, BranchLimits()
    if len(curve) < 2:
        return False
    weights = Metric.at(x, curve.harmonics, scale_w).weights
    move = ((curve.displacement - x) * weights).reshape(len(curve), -1)
    places = np.column_stack([move, (2 * np.pi * curve.frequency - w) / scale_w])
    off, share = to_lines(places)
    length = np.linalg.norm(np.diff(places, axis=0), axis=1)
    near = np.flatnonzero((off <= limits.off_chord * length) & ~curve.after_gap[1:])
    on_chord = (curve.displacement[i] + share[i] * (curve.displacement[i + 1] - curve.displacement[i]) for i in near)
    return any(np.linalg.norm(one - x) <= limits.same_mean * np.linalg.norm(x) for one in on_chord)
