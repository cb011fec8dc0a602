"""Branches beside a curve, with what is known of the stability of their peaks."""

import time
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from updamp.hbm.continuation.curve_records import CurveRequest
from updamp.hbm.continuation.detached import Place, detached_through
from updamp.hbm.continuation.response_curve import ResponseCurve
from updamp.hbm.problem.system import NonlinearSystem
from updamp.hbm.stability.branch_stability import point_stability


@dataclass(frozen=True, eq=False)
class DetachedBranches:
    """At one curve's force.

    branches: `complete` where they close; state: (n,) a `State` of the largest response of each; reasons: why it is
    unknown, "" where it is not; seconds: wall time spent
    """

    mode: str
    force: float
    branches: tuple[ResponseCurve, ...]
    state: NDArray[np.int64]
    reasons: tuple[str, ...]
    seconds: float


def detached_branches(
    system: NonlinearSystem, request: CurveRequest, curve: ResponseCurve, point: str, places: Sequence[Place]
) -> DetachedBranches:
    """Those that were met while the curve was traced, and those through `places`, solutions at its force.

    point: where the peak is taken
    """
    began = time.perf_counter()
    branches = (*curve.detached, *detached_through(system, request, curve, places))
    tops = [int(np.abs(branch.receptance(point)).argmax()) for branch in branches]
    judged = [point_stability(system, branch, top, None) for branch, top in zip(branches, tops, strict=True)]
    return DetachedBranches(
        curve.mode, curve.force, branches, np.array([int(one.state) for one in judged], dtype=np.int64),
        tuple(one.reason for one in judged), time.perf_counter() - began,
    )  # fmt: skip
