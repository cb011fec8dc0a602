"""No peak is read off a line across a place where the branch was not followed."""

from dataclasses import replace

import numpy as np
import pytest
from support.curves import softening_curve

TIP = "blade_right.tip.x"
WHOLE = softening_curve("IP", n=201)
FIELDS = ("frequency", "displacement", "response", "work_in", "friction_loss", "material_loss", "iterations", "error",
          "active")  # fmt: skip


def with_gap(keep):
    """WHOLE without the points that are not kept"""
    kept = np.flatnonzero(keep)
    after = np.append(False, np.diff(kept) > 1)
    return replace(WHOLE, **{name: getattr(WHOLE, name)[kept] for name in FIELDS}, after_gap=after)


@pytest.mark.parametrize("below", [True, False], ids=["gap below", "gap above"])
def test_a_peak_beside_a_gap_is_among_the_points_of_its_piece(below):
    """The gap takes the resonance itself, from a few points to one side of it far down the other flank."""
    place = np.arange(len(WHOLE))
    keep = (place < 40) | (place > 108) if below else (place < 92) | (place > 160)
    curve = with_gap(keep)
    size = np.abs(curve.receptance(TIP))
    frequency, peak = curve.peak(TIP)
    assert peak == pytest.approx(size.max(), rel=1e-6)
    assert np.min(np.abs(curve.frequency - frequency)) < 1e-4


def test_a_gap_further_off_changes_nothing():
    place = np.arange(len(WHOLE))
    assert with_gap((place < 20) | (place > 60)).peak(TIP) == WHOLE.peak(TIP)
