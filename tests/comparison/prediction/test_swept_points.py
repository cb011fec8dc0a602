"""Of branches with a wide hysteresis is kept what the sweep sees: the same points as of the whole branch."""

from dataclasses import dataclass, replace
from types import SimpleNamespace

import numpy as np
import pytest
from support.softening_beam import DOWN, UP, at, softening_beam, whole

from updamp.comparison.prediction.model_at import ModelAt
from updamp.comparison.prediction.moved_branch import move_branch
from updamp.comparison.prediction.parameters import Parametrisation
from updamp.comparison.prediction.predicted_branch import PredictedBranch
from updamp.comparison.prediction.swept_points import MARGIN, BranchFromFarEnd, swept_points
from updamp.comparison.prediction.traced_branch import observe_sweeps, trace_branch
from updamp.hbm.continuation.continuation import BranchStoppedError, continue_branch
from updamp.hbm.newton.newton import Status


@pytest.fixture(scope="module")
def softening() -> Parametrisation:
    return softening_beam()


def seen(branch: PredictedBranch) -> tuple[np.ndarray, np.ndarray]:
    """Frequencies and logarithms of the amplitude, densely, of what the sweep sees; ordered by frequency"""
    place = np.linspace(branch.place[0], branch.place[-1], 20 * len(branch.place))
    near = np.clip(np.searchsorted(branch.place, place, side="right") - 1, 0, len(branch.place) - 2)
    value = branch.at(place[branch.visited[near] & branch.visited[near + 1]]).value
    order = np.argsort(value[:, 0])
    return np.exp(value[order, 0]), value[order, 1]


@pytest.mark.parametrize("condition", [DOWN, UP])
def test_what_is_seen_are_the_same_points_as_of_the_whole_branch(softening, condition):
    there = ModelAt(softening, at(softening))
    force = there.model.excited_by(condition.force)
    walk = continue_branch(there.model.system, force, condition.wider, upwards=condition.upwards)
    (short,), full = observe_sweeps(there, (condition,), walk), whole(softening, at(softening), condition)
    left_out = ~np.isin(full.frequency, short.frequency)
    assert left_out.any(), "how many depends on the steps"
    assert not (left_out & runs_with_the_sweep(full)).any()
    assert np.sum(~runs_with_the_sweep(short)) == 2 * MARGIN - 1
    assert sum(point.after_gap for point in short.points) == 1
    for name in ("state", "slopes", "w_by_parameter"):  # others beside them leave other last digits
        alike = getattr(short, name)[short.visited], getattr(full, name)[full.visited]
        np.testing.assert_allclose(*alike, rtol=1e-9, atol=1e-9 * np.abs(alike[1]).max())


def runs_with_the_sweep(branch: PredictedBranch) -> np.ndarray:
    """(n,) of its points, folds among them"""
    ahead = (branch.frequency[1:] > branch.frequency[:-1]) == branch.condition.upwards
    return np.append(ahead, ahead[-1]) | np.insert(ahead, 0, ahead[0])


def assert_the_same(a: PredictedBranch, b: PredictedBranch) -> None:
    """But for the fold and where the sweep lands after its jump, which are known to a step of the branch."""
    (f, amplitude), (g, reference) = seen(a), seen(b)
    jump = g[np.argmax(np.diff(reference))]
    clear = (f > g[0]) & (f < g[-1]) & (np.abs(f / jump - 1) > 0.01)
    assert np.sum(clear) > 100
    np.testing.assert_allclose(amplitude[clear], np.interp(f[clear], g, reference), atol=5e-3)
    folds = [x.frequency[np.argmin(x.visited) - 1] for x in (a, b)]
    assert folds[0] == pytest.approx(folds[1], rel=5e-4)


@pytest.mark.parametrize("condition", [DOWN, UP])
def test_what_the_sweep_jumps_to_is_found_from_the_other_end(softening, condition):
    short, full = trace_branch(softening, at(softening), condition), whole(softening, at(softening), condition)
    assert_the_same(short, full)
    assert np.sum(~runs_with_the_sweep(short)) <= 2 * MARGIN
    assert sum(point.after_gap for point in short.points) == 1
    # the same branch on, in the same direction: tangents and the derivatives along it, behind the jump
    first, last = short.points[0], short.points[-1]
    assert (last.tangent_w > 0) == (first.tangent_w > 0) == condition.upwards
    behind = np.argsort(full.frequency[-10:])
    expected = np.interp(short.frequency[-1], full.frequency[-10:][behind], full.along[-10:, 0][behind])
    np.testing.assert_allclose(short.along[-1, 0], expected, rtol=0.01)


@pytest.mark.parametrize("condition", [DOWN, UP])
def test_both_parts_are_kept_up_to_where_they_turn_back(softening, condition):
    """A sweep may leave one before its fold, and begin on either."""
    short, full = trace_branch(softening, at(softening), condition), whole(softening, at(softening), condition)
    folds = [np.flatnonzero(np.diff(np.sign(np.diff(b.frequency)))) + 1 for b in (short, full)]
    ends = [b.frequency[fold[[0, -1]]] for b, fold in zip((short, full), folds, strict=True)]
    np.testing.assert_allclose(ends[0], ends[1], rtol=5e-4)
    moved = move_branch(softening, at(softening, 2e-3), short)
    assert moved is not None
    again = np.flatnonzero(np.diff(np.sign(np.diff(moved.frequency)))) + 1
    np.testing.assert_allclose(moved.frequency[again[[0, -1]]], (1 + 1e-3) * ends[0], rtol=5e-4)


def test_a_branch_with_a_piece_left_out_is_moved(softening):
    before = trace_branch(softening, at(softening), DOWN)
    moved = move_branch(softening, at(softening, 2e-3), before)
    assert moved is not None
    assert_the_same(moved, whole(softening, at(softening, 2e-3), DOWN))


@dataclass(frozen=True)
class Kept:
    """What is kept of a point in the tests below."""

    point: SimpleNamespace

    def after_gap(self) -> "Kept":
        return Kept(SimpleNamespace(w=self.point.w, after_gap=True))

    def turned(self, step: float, after_gap: bool) -> "Kept":  # noqa: ARG002
        return Kept(SimpleNamespace(w=self.point.w, after_gap=after_gap, step=0.1))


def kept(points):
    return [Kept(point) for point in points]


class Point(SimpleNamespace):
    def distance(self, other: "Point") -> float:
        return abs(self.w - other.w)


def points(*frequencies: float):
    return iter([Point(w=w, after_gap=False, step=0.1) for w in frequencies])


def of(found: list[Kept]) -> list[tuple[float, bool]]:
    return [(k.point.w, k.point.after_gap) for k in found]


BACK = [9 - 0.1 * i for i in range(1, 40)]


def test_a_short_way_back_is_kept_whole():
    found, stopped = swept_points(points(8, 9, *BACK[:7], 10, 11), True, kept)
    assert of(found) == [(w, False) for w in (8, 9, *BACK[:7], 10, 11)]
    assert stopped == ""


def test_of_a_long_way_back_the_ends_are_kept():
    found, _ = swept_points(points(8, 9, *BACK, 9.5, 12), True, kept)
    assert of(found) == [
        (8, False), (9, False), *((w, False) for w in BACK[:4]),
        (BACK[-4], True), *((w, False) for w in BACK[-3:]), (9.5, False), (12, False),
    ]  # fmt: skip


def test_a_branch_that_stops_says_so_and_one_of_three_points_is_none():
    found, stopped = swept_points(stopping(6, 7, 8, 9), True, kept)
    assert len(found) == 4
    assert "stops" in stopped
    with pytest.raises(BranchStoppedError):
        swept_points(stopping(6, 7, 8), True, kept)


def stopping(*frequencies: float):
    yield from points(*frequencies)
    raise BranchStoppedError(9.0, 1e-3, Status.STALLED)


def test_a_way_back_that_stops_ends_at_what_is_found_from_the_other_end():
    other = BranchFromFarEnd(lambda: points(12, 11, 10, 9.5, 8.9, 8.8, 8.7, 8.6, 8.5), 10.0)
    found, stopped = swept_points(stopping(6, 7, 8, 9, *BACK[:6]), True, kept, other)
    assert stopped == ""
    ahead = [(8.5, True), *((w, False) for w in (8.6, 8.7, 8.8, 8.9, 9.5, 10, 11, 12))]
    assert of(found) == [*((w, False) for w in (6, 7, 8, 9, *BACK[:4])), *ahead]


def test_a_way_back_in_long_steps_is_left_for_what_is_found_from_the_other_end():
    """However few points it has: here it leads on, by another resonance, to where no sweep goes."""
    other = BranchFromFarEnd(lambda: points(12, 11, 10, 9.5, 8.9, 8.8, 8.7, 8.6, 8.5), 10.0)
    found, _ = swept_points(points(8, 9, 8.8, 8.6, 8.4, 8.2, 14, 12.5), True, kept, other)
    assert of(found)[:7] == [*((w, False) for w in (8, 9, 8.8, 8.6, 8.4, 8.2)), (8.5, True)]
    assert [w for w, _ in of(found)][-3:] == [10, 11, 12]


def test_an_other_end_that_turns_back_or_stops_leaves_the_way_back():
    turning = BranchFromFarEnd(lambda: points(12, 11, *(11 + 0.05 * i for i in range(1, 30))), 10.0)
    for other in (turning, BranchFromFarEnd(lambda: stopping(12, 11, 10), 10.0)):
        found = swept_points(points(8, 9, *BACK, 9.5, 12), True, kept, other)
        assert of(found[0]) == of(swept_points(points(8, 9, *BACK, 9.5, 12), True, kept)[0])
        assert found[1] == ""


def test_a_branch_that_ends_behind_a_fold_keeps_the_other_end_beside_it():
    turning = BranchFromFarEnd(lambda: points(12, 11, *(11 + 0.05 * i for i in range(1, 30))), 10.0)
    alone = of(swept_points(points(8, 9, *BACK), True, kept)[0])
    found, _ = swept_points(points(8, 9, *BACK), True, kept, turning)
    assert of(found)[: len(alone)] == alone
    ahead = [w for w, _ in of(found)[len(alone) :]]
    assert ahead[-2:] == [11, 12]
    assert of(found)[len(alone)][1]


@pytest.mark.parametrize("begins", [(12.4,), (13.5, 13.1, 12.8)])
def test_an_other_end_on_the_same_branch_is_not_kept_again(begins):
    """Whichever begins farther outside the window."""
    other = BranchFromFarEnd(lambda: points(*begins, 12.2, 11.5, 10.5), 10.0)
    found, _ = swept_points(points(8, 9, 10, 11, 12, 12.5), True, kept, other)
    assert of(found) == [(w, False) for w in (8, 9, 10, 11, 12, 12.5)]


def test_a_second_fold_may_be_reached_though_the_first_was_not():
    """Hysteresis of one mode after the other: from the other end the branch turns back between both folds."""
    back = [9 - 0.1 * i for i in range(1, 20)]
    first_fold = points(8, 9, *back, 9.5, 13, *(13 - 0.2 * i for i in range(1, 40)))
    other = BranchFromFarEnd(
        lambda: points(16, 15, 14, 12.5, 12, 11.5, 11, *(11 + 0.05 * i for i in range(1, 30))), 10.0
    )
    found, _ = swept_points(first_fold, True, kept, other)
    assert [k.point.w for k in found[-7:]] == [11, 11.5, 12, 12.5, 14, 15, 16]
    assert 9.5 in [k.point.w for k in found]  # the first way back was followed


def test_behind_a_fold_the_stretch_that_leads_on_is_kept_whole():
    """The branch comes back from 9 to 5.1, with a turn at 7.1 that leads nowhere, and goes on from there."""
    nowhere = (7.2, 7.3, *BACK[19:])
    on = [5.2 + 0.1 * i for i in range(60)]
    found, _ = swept_points(points(8, 9, *BACK[:19], *nowhere, *on), True, kept)
    assert of(found) == [
        (8, False), (9, False), *((w, False) for w in BACK[:4]),
        (BACK[-4], True), *((w, False) for w in BACK[-3:]), *((w, False) for w in on),
    ]  # fmt: skip


def test_the_part_found_from_the_other_end_is_kept_whole():
    """It turns back at 5.5."""
    there = [12 - 0.25 * i for i in range(27)]
    other = BranchFromFarEnd(lambda: points(*there, *(5.5 + 0.05 * i for i in range(1, 30))), 10.0)
    found, _ = swept_points(points(8, 9, *BACK), True, kept, other)
    beyond = [w for w, _ in of(found)[6:]]
    assert beyond[MARGIN - 1 :] == there[::-1]
    assert beyond[: MARGIN - 1] == pytest.approx([5.65, 5.6, 5.55])
    assert [gap for _, gap in of(found)].count(True) == 1


def test_where_the_window_ends_in_a_hysteresis_both_parts_are_kept(softening):
    """One sweep has begun above it, another inside: that one is on the part that the first never comes to."""
    full = whole(softening, at(softening), DOWN)
    folds = np.flatnonzero(np.diff(np.sign(np.diff(full.frequency)))) + 1
    lower, upper = np.sort(full.frequency[folds[[0, -1]]])
    inside = replace(DOWN, window=(float(lower + 0.4 * (upper - lower)), DOWN.window[1]))
    assert lower < inside.wider[0] < upper
    branch = trace_branch(softening, at(softening), inside)
    (gap,) = [i for i, point in enumerate(branch.points) if point.after_gap]
    assert branch.visited[:gap].all()
    assert not branch.visited[gap:-1].any()
    assert branch.frequency[gap:].max() == pytest.approx(upper, rel=5e-4)
    behind = slice(None, folds[-1], -1)  # what a sweep jumps to, from the far end
    expected = np.interp(branch.frequency[-2], full.frequency[behind], abs(full.amplitude[behind, 0]))
    assert abs(branch.amplitude[-2, 0]) == pytest.approx(expected, rel=0.01)
    moved = move_branch(softening, at(softening, 1e-3), branch)
    assert moved is not None
    assert [point.after_gap for point in moved.points].count(True) == 1
    above = replace(DOWN, window=(1.005 * upper, DOWN.window[1]))
    assert above.wider[0] > upper
    assert not any(point.after_gap for point in trace_branch(softening, at(softening), above).points)


def test_a_thinned_branch_is_the_same_curve_with_its_gap(softening):
    branch = trace_branch(softening, at(softening), DOWN)
    thin = branch.thinned(0.2)
    assert len(thin.points) < len(branch.points)
    (gap,) = [i for i, point in enumerate(thin.points) if point.after_gap]
    apart = np.diff(thin.place)
    assert sum(apart < 0.2) <= 3  # both sides of the gap, and the end
    assert set(np.flatnonzero(apart < 0.2)) <= {gap - 2, gap - 1, len(apart) - 1}
    np.testing.assert_allclose(thin.at(thin.place).value, branch.at(thin.place).value, rtol=1e-12)
    again = move_branch(softening, at(softening), thin)
    assert again is not None
    assert_the_same(again, branch)


@pytest.mark.parametrize("upwards", [False, True])
def test_in_a_window_inside_a_hysteresis_both_parts_are_kept(softening, upwards):
    """What a sweep that begins outside brings in: a run there may have been on either part."""
    inside = replace(DOWN, mode="first_bending", window=(77.4, 78.2), upwards=upwards)
    branch, full = trace_branch(softening, at(softening), inside), whole(softening, at(softening), DOWN)
    (gap,) = [i for i, point in enumerate(branch.points) if point.after_gap]
    turns = np.flatnonzero(np.diff(np.sign(np.diff(full.frequency)))) + 1
    lower, upper = np.sort(full.frequency[turns[[0, -1]]])
    assert lower < inside.wider[0] < inside.wider[1] < upper
    expected = [size_at(full, first, last, 77.8) for first, last in ((0, turns[0]), (turns[-1], -1))]
    found = [size_at(branch, first, last, 77.8) for first, last in ((0, gap - 1), (gap, -1))]
    np.testing.assert_allclose(np.sort(found), np.sort(expected), rtol=1e-3)


def size_at(branch: PredictedBranch, first: int, last: int, frequency: float) -> float:
    """Between two of its points, where the branch passes a frequency [Hz]."""
    value = branch.at(np.linspace(branch.place[first], branch.place[last], 2000)).value
    return float(np.exp(value[np.argmin(abs(value[:, 0] - np.log(frequency))), 1]))
