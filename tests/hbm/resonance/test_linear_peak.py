"""Where no mode resonates in a window, the modes that lie in it are named, and why they do not."""

from dataclasses import replace

import pytest
from support.three_masses import three_masses

from updamp.hbm.resonance.conditions import MaximumResonance
from updamp.hbm.resonance.linear_peak import linear_peak
from updamp.hbm.resonance.resonance import ResonanceProblem
from updamp.hbm.resonance.resonance_curve import ResonanceRequest, whole_resonance

ANTISYMMETRIC, BETWEEN = (0.32, 0.35), (0.352, 0.38)  # modes at 0.3277 and 0.3454 Hz; none at all


def followed(system, window, point="drive"):
    return whole_resonance(system, ResonanceRequest("1", "drive", point, window, (0.01,), MaximumResonance()))


@pytest.mark.parametrize("as_a_whole", [False, True], ids=["half", "whole"])
def test_modes_that_the_force_does_not_drive_are_named(as_a_whole):
    """Antisymmetric ones, with the force in the plane of symmetry."""
    with pytest.raises(ValueError, match="no mode that is driven and seen between") as raised:
        followed(replace(three_masses(), as_a_whole=as_a_whole), ANTISYMMETRIC)
    said = str(raised.value)
    assert "at 0.3277, 0.3454 Hz not driven from where the force acts" in said
    assert "choose another point, or another window" in said
    assert "widen" not in said
    assert said.endswith("the lowest that are driven and seen are at 0.3056, 0.3163, 0.3515, 0.3821, 0.4229 Hz")


def test_modes_that_the_point_does_not_show_are_named():
    system = three_masses()
    side = ResonanceProblem(system, system.free.row("side"), system.free.row("drive"))
    with pytest.raises(ValueError, match=r"0\.3454 Hz driven and not seen at the point that is followed"):
        linear_peak(side, ANTISYMMETRIC, 0.0)


def test_where_there_is_none_at_all_the_window_is_to_be_widened():
    with pytest.raises(
        ValueError, match=r"no mode between 0\.352 and 0\.38 Hz at forces so small .*: widen the window"
    ):
        followed(three_masses(), BETWEEN)


def test_a_mode_that_is_not_driven_is_not_taken_for_one_that_is():
    """The nearest to the frequency asked for would be the antisymmetric one."""
    system, drive = three_masses(), three_masses().free.row("drive")
    problem = ResonanceProblem(system, drive, drive)
    taken, driven = (linear_peak(problem, (0.3, 0.35), 0.0, mode_frequency=at).w for at in (0.3277, 0.31625))
    assert taken == driven
