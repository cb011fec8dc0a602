"""The numerical error of a curve, read from a finer one whose difference is known."""

from dataclasses import replace

import numpy as np
import pytest
from support.curves import softening_curve

from updamp.hbm.analysis.finer_curve import curve_error, distances
from updamp.hbm.continuation.completeness import half_width
from updamp.hbm.continuation.response_curve import ResponseCurve
from updamp.hbm.continuation.sweeps import swept

TIP = "blade_right.tip.x"
FREQUENCY, LOSS = np.linspace(80.0, 120.0, 801), 0.02


def linear_curve(resonance, loss, scale=1.0):
    """First harmonic of an oscillator of unit force, harmonics 0 and 1"""
    n = len(FREQUENCY)
    response = np.zeros((n, 1, 3))
    amplitude = scale * resonance**2 / (resonance**2 * (1 + 1j * loss) - FREQUENCY**2)
    response[:, 0, 1], response[:, 0, 2] = amplitude.real, -amplitude.imag
    none = np.zeros(n)
    return ResponseCurve(
        "1", 1.0, (0, 1), ("tip",), FREQUENCY, none, response, none, none, none, none, none, none,
        np.zeros(n, dtype=bool), True, "", 0.0,
    )  # fmt: skip


def test_height_frequency_and_width_are_compared():
    error = curve_error(linear_curve(100.0, LOSS), linear_curve(100.5, 1.1 * LOSS), "tip")
    assert error.resonance_hertz == pytest.approx(0.5, abs=0.01)
    assert error.peak_percent == pytest.approx(100 * (1 / 1.1 - 1), abs=0.1)
    assert error.half_width_percent == pytest.approx(10.0, abs=1.0)
    assert error.complete


def test_on_a_shallow_flank_the_distance_is_the_change_at_the_same_frequency():
    error = curve_error(linear_curve(100.0, LOSS), linear_curve(100.0, LOSS, 1.07), "tip")
    assert error.flank_percent == pytest.approx(7.0, abs=0.1)
    assert error.resonance_hertz == pytest.approx(0.0, abs=1e-6)


def test_beside_a_jump_the_distance_is_the_shift_in_half_widths():
    """At a fixed frequency between both folds the response has changed by half or more: one of them has jumped."""
    curve, shift = softening_curve(softening=5.0, n=401), 0.06
    finer = replace(curve, frequency=curve.frequency + shift)
    fold = int(curve.frequency[: len(curve) // 2].argmax())
    jumps = swept(curve, upwards=True).jumps, swept(finer, upwards=True).jumps
    assert jumps[1] - jumps[0] == pytest.approx(shift), "the folds move by as much"
    width = half_width(curve.frequency, np.abs(curve.receptance(TIP)))
    apart = distances(curve, finer, TIP, width, np.arange(len(curve)))
    assert apart[fold] == pytest.approx(shift / width, rel=1e-2), "where the branch is vertical"
    assert (apart <= shift / width * (1 + 1e-9)).all()
    assert curve_error(curve, finer, TIP).flank_percent == pytest.approx(100 * shift / width, rel=0.05)


def test_of_several_sheets_the_nearest_counts():
    curve = linear_curve(100.0, LOSS)
    there_and_back = np.r_[np.arange(len(FREQUENCY)), np.arange(len(FREQUENCY))[::-1]]
    twice = replace(
        curve,
        frequency=FREQUENCY[there_and_back],
        response=np.concatenate([curve.response, 3 * curve.response])[
            np.r_[np.arange(len(FREQUENCY)), len(FREQUENCY) + np.arange(len(FREQUENCY))[::-1]]
        ],
        after_gap=np.zeros(2 * len(FREQUENCY), dtype=bool),
    )
    assert curve_error(curve, twice, "tip").flank_percent == pytest.approx(0.0, abs=1e-9)


def test_a_curve_without_points_has_none():
    curve = linear_curve(100.0, LOSS)
    empty = replace(curve, frequency=np.zeros(0))
    with pytest.raises(ValueError, match="without points"):
        curve_error(curve, empty, "tip")


def test_the_width_does_not_hang_on_where_a_curve_has_its_points():
    """Ten points to a half-width, as a continuation has them at least, and the same moved by half a step."""
    whole = linear_curve(100.0, LOSS)
    traced = [
        replace(
            whole, frequency=whole.frequency[places], response=whole.response[places], after_gap=whole.after_gap[places]
        )
        for places in (slice(0, None, 2), slice(1, None, 2))
    ]
    assert abs(curve_error(*traced, "tip").half_width_percent) < 0.01
