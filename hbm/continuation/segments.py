"""Segments of a branch as they are begun: from an end of the window, from a start inside."""

from collections.abc import Iterator, Sequence
from dataclasses import replace

import numpy as np

from updamp.hbm.continuation.branch import BranchPoint
from updamp.hbm.continuation.continuation import continue_branch
from updamp.hbm.continuation.curve_records import CurveRequest, Records
from updamp.hbm.continuation.pieces import BranchSegment
from updamp.hbm.continuation.predictor_corrector import CONNECTED
from updamp.hbm.problem.system import NonlinearSystem


def from_end(system: NonlinearSystem, request: CurveRequest, upwards: bool, started: float) -> BranchSegment:
    """From the lower end of the window (upwards) or the upper one."""
    points = _followed(system, request, upwards, ())
    return BranchSegment(Records(system, request, started), 1.0 if upwards else -1.0, points)


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
    system: NonlinearSystem, request: CurveRequest, upwards: bool, from_points: Sequence[BranchPoint]
) -> Iterator[BranchPoint]:
    """Without jumps: where the branch cannot be followed, other segments lead on."""
    options = replace(request.options, recoveries=CONNECTED)
    return continue_branch(system, request.excitation, request.window, options, upwards, from_points)
