"""Across a place where the response jumps: contacts give way together and the branch turns back and forth in kinks too
sharp and too many to follow, with amplitude and frequency all but standing while the mean position changes.
"""

from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass, replace
from itertools import pairwise

from updamp.hbm.continuation.branch import BranchPoint, point_at
from updamp.hbm.continuation.corrector import Corrector
from updamp.hbm.continuation.retracing import TracedBranch
from updamp.hbm.newton.metric import Move
from updamp.hbm.newton.newton import Arc, NewtonOptions, solve


@dataclass(frozen=True)
class Jump:
    """The points beyond a jump: from where its far side begins to where the jump ended.

    lengths: of the jumps, in units of arc; no_gap: the far side is followed back no nearer than this: two ordinary
        steps of half the largest size
    """

    lengths: tuple[float, ...] = (0.03, 0.1, 0.2, 0.4)
    no_gap: float = 0.1

    def __call__(self, corrector: Corrector, traced: TracedBranch) -> Sequence[BranchPoint]:
        options = corrector.options
        for newton in (options.newton, options.persistent):
            far = point_beyond_gap(corrector, traced, options.no_shorter(self.lengths), newton)
            if far is not None:
                return back_to_gap(_backwards(corrector, far), far, traced.last, self.no_gap)
        return []


def _backwards(corrector: Corrector, start: BranchPoint) -> Iterator[BranchPoint]:
    """From `start` the other way, until the branch cannot be followed any further."""
    traced, step = TracedBranch([start.turned()]), corrector.options.first_step
    while step >= corrector.options.short_step:
        point, _ = corrector.step(traced, step)
        if point is None:
            step = corrector.options.shortened(step)
            continue
        step = corrector.options.following(step, point.step, point.solution.iterations, False)
        traced = traced.extended([point])
        yield point


def point_beyond_gap(
    corrector: Corrector, traced: TracedBranch, lengths: Sequence[float], options: NewtonOptions
) -> BranchPoint | None:
    """A point about one of `lengths` beyond the last one, not on what was traced; one with the branch's orientation
    (hbm/continuation/recovery/switch_branch.py) rather than a nearer one without.
    """
    system, excitation, last, other = corrector.system, corrector.excitation, traced.last, None
    for length in lengths:
        for x, w in _guesses(traced.points, length):
            ahead = (x - last.x, w - last.w)
            size = last.metric.length(ahead)
            plane = Arc(x, w, (ahead[0] / size, ahead[1] / size), last.metric)
            solution = solve(system, excitation, x, w, options, plane)
            if not solution.converged:
                continue
            move, away = last.move_to(solution), last.distance(solution)
            point = point_at(solution, excitation, last.metric.scale_w, move, away, after_gap=True)
            # beyond the last point, and about as far as was asked for: elsewhere it is some other branch
            near = corrector.options.counts(away, length) and last.metric.product(move, ahead) > 0
            if not near or traced.contains(point):
                continue
            if point.orientation == last.orientation:
                return point
            other = other or point
    return other


def back_to_gap(
    backwards: Iterable[BranchPoint], far: BranchPoint, last: BranchPoint, no_gap: float
) -> Sequence[BranchPoint]:
    """The far side of a jump in the order of the branch: `backwards` runs from `far` towards the gap.

    Followed as long as it comes no nearer to `last` than an ordinary step, and for no longer than twice the jump.
    """
    length, jump, found = 0.0, last.distance(far), [far]
    for point in backwards:
        length += point.step
        behind_last = last.metric.product(last.move_to(point), last.tangent) < 0
        if last.distance(point) < no_gap or length > 2 * jump or behind_last:
            break
        found.append(point.turned())
    found.reverse()
    steps = [last.distance(found[0]), *(a.distance(b) for a, b in pairwise(found))]
    return [
        replace(point, step=step, after_gap=i == 0) for i, (point, step) in enumerate(zip(found, steps, strict=True))
    ]


def _guesses(points: Sequence[BranchPoint], ahead: float) -> Iterator[Move]:
    """Places `ahead` of the last point: along the tangent, and by a parabola through points about as far apart."""
    last = points[-1]
    yield last.x + ahead * last.tangent_x, last.w + ahead * last.tangent_w
    apart = [last.distance(p) for p in points]
    near = next((i for i in reversed(range(len(points))) if apart[i] > ahead / 2), None)
    far = next((i for i in reversed(range(len(points))) if near is not None and apart[i] > 1.5 * apart[near]), None)
    if near is not None and far is not None:
        yield _parabola((points[far], points[near], last), (-apart[far], -apart[near]), ahead)


def _parabola(points: tuple[BranchPoint, BranchPoint, BranchPoint], at: tuple[float, float], ahead: float) -> Move:
    """Extrapolate from places at[0], at[1] and 0 along the branch to `ahead`."""
    a, b = at
    weights = (
        ahead * (ahead - b) / (a * (a - b)),
        ahead * (ahead - a) / (b * (b - a)),
        (ahead - a) * (ahead - b) / (a * b),
    )
    first, second, third = points
    c, d, e = weights
    return c * first.x + d * second.x + e * third.x, c * first.w + d * second.w + e * third.w
