"""Laws are told from synthetic least squares whose truth is known."""

import numpy as np
import pytest

from updamp.diagnosis.missing_force.force_laws import DAMPING, LEVELS, POWERS, STIFFNESS, Column, Squares, force_laws
from updamp.diagnosis.missing_force.force_reading import ReferenceMotion, reading

AMPLITUDE = np.geomspace(0.05, 1.0, 60)
PLACE = ReferenceMotion("tip.x", 1e-3, 2 * np.pi * 400)


def squares(stiffness, damping, calibration=None, seed=0):
    """Points at AMPLITUDE with unit noise. calibration: column (120,) that may take anything up"""
    rng = np.random.default_rng(seed)
    residual = np.concatenate([stiffness, damping]) + rng.standard_normal(2 * len(AMPLITUDE))
    none = np.zeros_like(AMPLITUDE)
    columns, names = [], []
    for quantity, powers in POWERS.items():
        for power in powers:
            law = AMPLITUDE**power
            columns.append(np.concatenate([law, none] if quantity == STIFFNESS else [none, law]))
            names.append(Column("A", quantity, power))
    for low, high in ((0, 20), (20, 40), (40, 60)):
        piece = none.copy()
        piece[low:high] = 1.0
        columns += [np.concatenate([piece, none]), np.concatenate([none, piece])]
        names += 2 * [Column("A", LEVELS)]
    free = np.zeros((120, 1)) if calibration is None else calibration[:, None]
    return Squares(residual, free, np.array([np.inf]), np.zeros(1), np.stack(columns, axis=1), names)


@pytest.mark.parametrize(
    ("stiffness", "damping", "names"),
    [
        (0.0, 0.0, ("nothing", "nothing")),
        (30.0, 0.0, ("constant", "nothing")),
        (60.0 * AMPLITUDE**2, 0.0, ("cubic", "nothing")),
        (0.0, 30.0, ("nothing", "viscous")),
        (0.0, 50.0 * AMPLITUDE, ("nothing", "quadratic")),
        (0.0, 5.0 / AMPLITUDE, ("nothing", "Coulomb")),
        (-60.0 * AMPLITUDE**0.5, 60.0 * AMPLITUDE**0.5, ("rising", "rising")),
    ],
)
def test_the_law_is_told(stiffness, damping, names):
    for seed in range(5):
        shape = force_laws(squares(stiffness + 0 * AMPLITUDE, damping + 0 * AMPLITUDE, seed=seed), ("A",))["A"]
        assert (shape.stiffness.law.name, shape.damping.law.name) == names
        assert shape.simple


def test_what_calibration_imitates_is_not_claimed():
    constant = np.concatenate([np.ones(60), np.zeros(60)])
    shape = force_laws(squares(30.0 + 0 * AMPLITUDE, 0 * AMPLITUDE, constant), ("A",))["A"]
    assert shape.stiffness.law.name == "nothing"
    # the square of amplitude is told even where calibration has taken its mean
    shape = force_laws(squares(60.0 * (AMPLITUDE**2 - 0.3), 0 * AMPLITUDE, constant), ("A",))["A"]
    assert shape.stiffness.law.name == "cubic"
    assert shape.stiffness.size == pytest.approx(60.0, abs=4 * shape.stiffness.deviation)


def test_laws_that_the_data_cannot_tell_apart_are_named():
    # seven deviations in all
    weak = force_laws(squares(0 * AMPLITUDE, 0.9 + 0 * AMPLITUDE), ("A",))["A"]
    assert weak.damping.law.name != "nothing"
    assert "viscous" in {weak.damping.law.name, *(law.name for law in weak.damping.alternatives)}
    assert weak.damping.alternatives
    assert "could not tell it from" in reading(weak, PLACE)


def test_no_simple_law():
    steps = np.where((AMPLITUDE[19] < AMPLITUDE) & (AMPLITUDE[40] > AMPLITUDE), 60.0, -60.0)
    shape = force_laws(squares(steps, 0 * AMPLITUDE), ("A",))["A"]
    assert not shape.simple
    assert "departs from it" in reading(shape, PLACE) or "no simple law" in reading(shape, PLACE)


def test_microslip_is_named():
    shape = force_laws(squares(-60.0 * AMPLITUDE**0.5, 60.0 * AMPLITUDE**0.5), ("A",))["A"]
    assert "micro-slip" in reading(shape, PLACE)
    assert DAMPING in reading(shape, PLACE)
