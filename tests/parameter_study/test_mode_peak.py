"""Peaks where a window holds two modes."""

from dataclasses import replace

import numpy as np
import pytest
from support.curves import softening_curve

from updamp.design.tracked_modes import ModeReference
from updamp.hbm.harmonics import Harmonics
from updamp.parameter_study.mode_peak import likeness, peak_of_mode

TIP = "blade_right.tip.x"
SHAPES = {"IP": {"blade_left.tip.x": 1.0, TIP: 1.0}, "OOP": {"blade_left.tip.x": -1.0, TIP: 1.0}}


def reference(mode: str) -> ModeReference:
    return ModeReference(mode, (400.0, 450.0), 420.0, SHAPES[mode])


def two_modes():
    """IP at 420 Hz, and OOP at 436 Hz with a peak twice as high, on one curve."""
    harmonics, f = Harmonics((0, 1, 2, 3)), np.linspace(415.0, 440.0, 2001)
    base = softening_curve("IP", n=len(f))
    response = np.zeros_like(base.response)
    ip, oop = (size / (centre - f + 0.5j) for centre, size in ((420.0, 0.5e-5), (436.0, 1e-5)))
    for i, value in ((0, ip - oop), (1, ip + oop)):
        harmonics.set_amplitude(response[:, i], 1, value)
    return replace(base, frequency=f, response=response)


def test_each_mode_has_its_own_peak():
    curve = two_modes()
    ip, oop = (peak_of_mode(curve, TIP, reference(mode)) for mode in ("IP", "OOP"))
    assert ip.frequency == pytest.approx(420.0, abs=0.05)
    assert oop.frequency == pytest.approx(436.0, abs=0.05)
    assert oop.receptance == pytest.approx(curve.peak(TIP)[1])
    assert curve.frequency[ip.place] == pytest.approx(ip.frequency, abs=0.02)


def test_likeness_is_one_for_the_mode_and_zero_for_the_other():
    curve = softening_curve("OOP")
    assert likeness(curve, reference("OOP")) == pytest.approx(1.0)
    assert likeness(curve, reference("IP")) == pytest.approx(0.0)


def test_a_curve_that_nowhere_moves_like_the_mode_has_its_largest_peak():
    curve = softening_curve("OOP")
    assert peak_of_mode(curve, TIP, reference("IP")).receptance == pytest.approx(curve.peak(TIP)[1])
