"""Which mode has another's resonance is told of resonances that were found, and of nothing else."""

from dataclasses import replace
from pathlib import Path

import numpy as np
from support.curves import softening_curve

from updamp.workflow import store
from updamp.workflow.mode_names import lowest_resonances, misnamed_modes
from updamp.workflow.products import Products, Stored

TIP = "blade_right.tip.x"
AT_SMALL_FORCES = {"OOP": 420.0, "IP": 430.0}


def products(*curves):
    path, stamp = Path("curve.h5"), store.Stamp("key")
    stored = tuple(Stored(path, curve, stamp) for curve in curves)
    return Products(Stored(path, None, stamp), curves=stored, named_modes=AT_SMALL_FORCES)


def unfinished(curve):
    """Its largest response stands at the lower end of its window."""
    top = int(np.abs(curve.receptance(TIP)).argmax())
    return replace(
        curve, frequency=curve.frequency[top:], response=curve.response[top:], after_gap=curve.after_gap[top:],
        complete=False, stopped="the response is largest at an end of the window",
    )  # fmt: skip


def test_a_complete_curve_with_the_resonance_of_another_mode_is_told():
    (sentence,) = misnamed_modes(products(softening_curve("IP", centre=420.0)), TIP)
    assert sentence.startswith("IP: its resonance at the lowest force, 420.00 Hz, is that of OOP")


def test_of_a_curve_that_is_not_complete_no_resonance_is_told():
    """Nor of a complete one at a larger force in its place, where the resonance has moved."""
    curve = unfinished(softening_curve("IP", centre=420.0))
    assert misnamed_modes(products(curve), TIP) == []
    larger = softening_curve("IP", force=10.0, centre=421.0)
    assert lowest_resonances(products(curve, larger), TIP) == {}
    empty = replace(curve, frequency=curve.frequency[:0], stopped="no branch was found")
    assert lowest_resonances(products(empty), TIP) == {}
