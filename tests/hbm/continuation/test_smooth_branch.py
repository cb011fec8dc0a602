"""Between the points of a curve: near the exact response, through the points, not over gaps."""

from dataclasses import replace

import numpy as np
import pytest
from support.curves import softening_curve

from updamp.hbm.continuation.smooth_branch import BETWEEN, followed, smooth_branch

POINT = "blade_right.tip.x"


def test_a_coarse_branch_with_a_fold_is_drawn_as_the_fine_one() -> None:
    """To a per cent of the peak with 31 points, where straight lines are several times as far off."""
    exact = softening_curve(softening=4.0, n=20_001)
    coarse = softening_curve(softening=4.0, n=31)
    smooth = smooth_branch(coarse, POINT)

    def distance(frequency: np.ndarray, receptance: np.ndarray) -> float:
        """Largest, from any of the places to the exact branch: in Hz, and in hundredths of the peak"""
        plane = np.column_stack([exact.frequency, np.abs(exact.receptance(POINT)) / 1e-7])
        return max(
            float(np.min(np.linalg.norm(plane - place, axis=1)))
            for place in np.column_stack([frequency, np.abs(receptance) / 1e-7])
        )

    straight = np.linspace(0, len(coarse) - 1, len(smooth.frequency))
    places, number = np.arange(len(coarse)), coarse.receptance(POINT)
    line = distance(np.interp(straight, places, coarse.frequency), np.interp(straight, places, np.abs(number)))
    assert distance(smooth.frequency, smooth.receptance) < 0.35
    assert line > 0.55


def test_it_runs_through_the_points_in_their_order() -> None:
    curve = softening_curve(softening=4.0, n=31)
    smooth = smooth_branch(curve, POINT)
    at = np.append(np.arange(len(curve) - 1) * BETWEEN, len(smooth.frequency) - 1)
    np.testing.assert_allclose(smooth.frequency[at], curve.frequency, rtol=1e-12)
    np.testing.assert_allclose(smooth.receptance[at], curve.receptance(POINT), rtol=1e-9)
    assert smooth.interval[0] == 0
    assert smooth.interval[-1] == len(curve) - 2
    assert np.all(np.diff(smooth.interval) >= 0)


def test_a_gap_stays_a_gap_and_a_single_point_is_left_out() -> None:
    curve = softening_curve(n=31)
    gap = np.zeros(len(curve), dtype=bool)
    gap[[10, 11, 20]] = True
    broken = replace(curve, after_gap=gap)
    assert list(followed(broken)) == [(0, 9), (11, 19), (20, 30)]
    pieces = list(smooth_branch(broken, POINT).pieces())
    assert [(p.interval[0], p.interval[-1]) for p in pieces] == [(0, 8), (11, 18), (20, 29)]
    assert pieces[0].frequency[-1] == pytest.approx(curve.frequency[9])


@pytest.mark.parametrize("n", [1, 2])
def test_so_few_points_are_a_straight_line_or_nothing(n: int) -> None:
    curve = softening_curve(n=n)
    assert len(smooth_branch(curve, POINT).frequency) == (n - 1) * BETWEEN + (n > 1)
