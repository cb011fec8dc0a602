"""Restarts beyond a place where a branch stops from both sides: new first points at fixed frequencies, a little ahead.

That is what a sweep does there: the response leaves one branch and goes on along another. What lies between is marked
as a gap, and a branch found this way may be one of several.
"""

from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np

from updamp.hbm.continuation.branch import BranchPoint, point_at
from updamp.hbm.continuation.continuation import BranchStoppedError, ContinuationOptions, continue_branch
from updamp.hbm.continuation.first_point import first_point
from updamp.hbm.newton.newton import Solution, solve
from updamp.hbm.problem.system import Excitation, NonlinearSystem

# How far ahead a restart is tried, as shares of the window; after these, no more.
AHEAD = (0.0025, 0.005, 0.01, 0.02, 0.04)
# So many restarts a curve at most.
MOST_RESTARTS = 24


@dataclass(frozen=True, eq=False)
class Restart:
    """sign: 1 upwards, -1 downwards; until: where it may end [rad/s]"""

    system: NonlinearSystem
    excitation: Excitation
    window: tuple[float, float]
    options: ContinuationOptions
    sign: float
    until: float

    def points(self, furthest: BranchPoint) -> Iterator[BranchPoint]:
        """Points beyond `furthest`, those after a gap marked, until `until` is passed or no restart is found."""
        reached = furthest
        for _ in range(MOST_RESTARTS):
            start = self._start(reached)
            if start is None:
                return
            reached = start
            for point in self._continued(start):
                yield point
                reached = point if self.sign * (point.w - reached.w) > 0 else reached
                if self.sign * (point.w - self.until) >= 0:
                    return

    def _continued(self, start: BranchPoint) -> Iterator[BranchPoint]:
        """The start and the points that follow it, until the branch falls back behind it."""
        yield start
        try:
            for point in continue_branch(
                self.system, self.excitation, self.window, self.options, self.sign > 0, [start]
            ):
                if self.sign * (point.w - start.w) < 0:
                    return
                yield point
        except BranchStoppedError:
            return

    def _start(self, last: BranchPoint) -> BranchPoint | None:
        """A point ahead of `last` at a fixed frequency; None where none is found."""
        width = 2 * np.pi * (self.window[1] - self.window[0])
        for share in AHEAD:
            w = last.w + self.sign * share * width
            if self.sign * (w - self.until) > 0:
                w = self.until
            solution = self._solved(last, w)
            if solution is not None:
                direction = (0 * solution.x, self.sign)
                return point_at(solution, self.excitation, last.metric.scale_w, direction, 0.0, after_gap=True)
        return None

    def _solved(self, last: BranchPoint, w: float) -> Solution | None:
        near = solve(self.system, self.excitation, last.x, w, self.options.persistent)
        if near.converged:
            return near
        try:
            return first_point(self.system, self.excitation, w, self.options.persistent)
        except BranchStoppedError:
            return None
