"""Effects of a joint at another point than the excitation."""

import tomllib
from pathlib import Path

import numpy as np
import pytest
from scipy.optimize import brentq
from support.two_modes import DRIVE, MODES, TIP, two_modes

from updamp.comparison.prediction.parameters import Parametrisation
from updamp.comparison.prediction.run_condition import RunCondition
from updamp.comparison.prediction.traced_branch import trace_branch
from updamp.effects.catalogue import CATALOGUE, JOINTS
from updamp.effects.chosen import ChosenEffect, chosen_effects, code_of, with_effects
from updamp.effects.placed import at_other_places, effect_called, other_places, placed
from updamp.effects.sized import sized
from updamp.rig.errors import RigError

CUBIC = 6e8  # N/m^3
NAME = f"joint_cubic@{TIP}"


def receptance(w, one, other):
    """one, other: places of drive (0) and tip (1)"""
    total = 0.0
    for frequency, damping, *shape in MODES.values():
        w0 = 2 * np.pi * frequency
        total += shape[one] * shape[other] / (w0**2 + 2j * damping * w0 * w - w**2)
    return total


def at_drive(frequency, force):
    """|x| with a cubic spring at the tip, by its first harmonic: (1 + H_tt k(a)) x_t = H_td F with k = 3/4 c a^2."""
    w = 2 * np.pi * frequency
    H = [[receptance(w, i, j) for j in (0, 1)] for i in (0, 1)]
    linear = abs(H[1][0]) * force

    def excess(a):
        return abs(1 + H[1][1] * 0.75 * CUBIC * a**2) * a - linear

    a = brentq(excess, 0, 3 * linear)
    stiffness = 0.75 * CUBIC * a**2
    tip = H[1][0] * force / (1 + H[1][1] * stiffness)
    return abs(H[0][0] * force - H[0][1] * stiffness * tip)


@pytest.mark.parametrize(("mode", "force", "window"), [("first", 0.4, (39.5, 40.8)), ("second", 4.0, (96.0, 98.0))])
def test_a_spring_at_the_tip_is_felt_at_the_drive_as_its_equation_says(mode, force, window):
    model = with_effects(two_modes(), (ChosenEffect(effect_called(NAME), {"coefficient": CUBIC}),))
    condition = RunCondition("level", mode, force, True, window, ((DRIVE, 1), (TIP, 1)))
    branch = trace_branch(Parametrisation(model, ()), np.zeros(0), condition)
    expected = [at_drive(f, force) for f in branch.frequency]
    np.testing.assert_allclose(np.abs(branch.amplitude[:, 0]), expected, rtol=2e-3)
    linear = [abs(receptance(2 * np.pi * f, 0, 0)) * force for f in branch.frequency]
    assert np.max(np.abs(np.log(expected) - np.log(linear))) > 0.02  # the spring is felt


def test_a_second_place_is_one_that_the_modes_move_otherwise():
    assert other_places(two_modes(), MODES) == (TIP,)
    assert other_places(two_modes(), ("first",)) == ()  # any point will do
    assert other_places(two_modes({"first": 0.8, "second": 1.8}), MODES) == ()  # twice as far in both
    assert other_places(two_modes({"first": 0.0, "second": 0.0}), MODES) == ()  # it does not move


def test_joints_alone_are_placed():
    found = at_other_places((JOINTS["joint_cubic"], CATALOGUE["shaker_attachment"]), two_modes(), MODES)
    assert [effect.name for effect in found] == [NAME]
    assert (found[0].kind, found[0].joint) == ("joint_cubic", TIP)


def test_its_size_is_that_of_the_modes_as_the_joint_sees_them():
    """By the softest one there, w^2 / shape^2; a cubic spring's size grows with it."""
    model = two_modes()
    here, there = (sized(effect, model, 1e-4) for effect in (JOINTS["joint_cubic"], placed(JOINTS["joint_cubic"], TIP)))
    stiffness = [min((frequency / shape[i]) ** 2 for frequency, _, *shape in MODES.values()) for i in (0, 1)]
    assert there.parameters[0].typical / here.parameters[0].typical == pytest.approx(stiffness[1] / stiffness[0])


def test_a_rig_file_states_the_place_in_the_name():
    tables = tomllib.loads(f'[[effects]]\nname = "{NAME}"\nvalues = {{ coefficient = "1e9 N/m^3" }}')["effects"]
    (one,) = chosen_effects(tables, Path())
    element = one.apply(two_modes()).elements[-1]
    assert element.points == (TIP,)
    assert code_of(one.effect, None) == ""


@pytest.mark.parametrize("name", [f"edge_gap@{TIP}", "joint_cubic@", f"@{TIP}", "cubic"])
def test_what_is_no_effect_of_a_joint_has_no_place(name):
    assert effect_called(name) is None
    with pytest.raises(RigError, match="no such effect"):
        chosen_effects([{"name": name, "values": {}}], Path())


def test_a_point_that_the_model_does_not_have_is_named():
    one = ChosenEffect(effect_called("joint_cubic@arm.root.x"), {"coefficient": 1e9})
    with pytest.raises(ValueError, match=r"joint_cubic@arm\.root\.x.*the model has no arm\.root\.x"):
        one.apply(two_modes())
