"""Segments of a branch as they are begun: from an end of the window, from a stored curve, from a start inside."""

from collections.abc import Iterator, Sequence
from dataclasses import replace

import numpy as np

from updamp.hbm.continuation.branch import BranchPoint, branch_point
from updamp.hbm.continuation.continuation import continue_branch
from updamp.hbm.continuation.curve_records import CurveRequest, Records
from updamp.hbm.continuation.pieces import BranchSegment
from updamp.hbm.continuation.predictor_corrector import CONNECTED
from updamp.hbm.continuation.response_curve import ResponseCurve
from updamp.hbm.problem.system import NonlinearSystem


def from_end(
    system: NonlinearSystem, request: CurveRequest, upwards: bool, started: float, earlier: ResponseCurve | None = None
) -> BranchSegment:
    """From the lower end of the window (upwards) or the upper one; earlier: what there is of it"""
    resumed = _last_points(system, request, earlier) if earlier is not None else ()
    points = _followed(system, request, upwards, resumed)
    return BranchSegment(Records(system, request, started, earlier), 1.0 if upwards else -1.0, points, resumed)


def segment_from(
    system: NonlinearSystem, request: CurveRequest, start: BranchPoint, upwards: bool, started: float
) -> BranchSegment:
    """From a start that the segment upwards records, and the other one does not."""
    sign = 1.0 if upwards else -1.0
    if np.sign(start.tangent_w) != sign:
        start = start.turned()
    points = _followed(system, request, upwards, [start])
    records = Records(system, request, started)
    if upwards:
        records.add(replace(start, after_gap=False))
    return BranchSegment(records, sign, points, [start])


def _followed(
    system: NonlinearSystem, request: CurveRequest, upwards: bool, resumed: Sequence[BranchPoint]
) -> Iterator[BranchPoint]:
    """Without jumps: where the branch cannot be followed, other segments lead on."""
    options = replace(request.options, recoveries=CONNECTED)
    return continue_branch(system, request.excitation, request.window, options, upwards, resumed)


def _last_points(system: NonlinearSystem, request: CurveRequest, curve: ResponseCurve) -> Sequence[BranchPoint]:
    """The last two points of a stored curve as points of a branch, tangents computed anew."""
    scale_w = request.options.scale_w(request.window)
    places = [(curve.displacement[i], 2 * np.pi * curve.frequency[i]) for i in (-2, -1)]
    direction = (places[1][0] - places[0][0], places[1][1] - places[0][1])
    return [branch_point(system, request.excitation, x, w, scale_w, direction) for x, w in places]
