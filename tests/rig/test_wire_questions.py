"""Wires softer than eq. (1) of Pesaresi et al. 2017 asks for are asked about."""

import math
from pathlib import Path

import pytest

from updamp.model.rig_files import load_rig
from updamp.rig.damper_mass import damper_mass
from updamp.rig.questions import questions

RIG = Path(__file__).parents[2] / "rigs" / "pesaresi2017.toml"


def test_wires_below_the_mass_times_the_square_of_the_highest_frequency_are_asked_about() -> None:
    rig = load_rig(RIG, {"wire.axial_stiffness": "1000 N/m"})
    (question,) = questions(rig)
    least = damper_mass(rig) * (2 * math.pi * 451.0) ** 2
    assert question.startswith(f"wire.axial_stiffness = 1000 N/m: not above m w^2 = {least:.3g} N/m, eq. (1)")
    assert "w at 451 Hz, the upper end of study.modes.OOP.window" in question
    assert "stiffer wires" in question


@pytest.mark.parametrize(("share", "asked"), [(0.99, 1), (1.01, 0)])
def test_the_limit_is_that_of_the_highest_window(share: float, asked: int) -> None:
    limit = damper_mass(load_rig(RIG)) * (2 * math.pi * 451.0) ** 2
    assert len(questions(load_rig(RIG, {"wire.axial_stiffness": f"{share * limit} N/m"}))) == asked
