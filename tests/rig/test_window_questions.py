"""Windows in which nothing can resonate are asked about, and no others."""

import pytest

from updamp.rig.questions import empty_windows, possible_resonances

FREE, STUCK = [269.0, 1600.0], [424.0, 440.0, 1700.0]


def test_a_resonance_lies_between_the_blade_alone_and_the_stuck_structure() -> None:
    assert possible_resonances(FREE, STUCK) == [(269.0, 424.0), (269.0, 440.0), (1600.0, 1700.0)]
    assert possible_resonances([80.0], [80.0]) == [(80.0, 80.0)], "a rig given by modes"
    assert possible_resonances([90.0], [80.0]) == [(80.0, 80.0)], "round-off: never above the stuck frequency"


@pytest.mark.parametrize(
    ("window", "asked"),
    [((433, 451), False), ((250, 434), False), ((300, 310), False), ((1000, 1100), True), ((1, 2), True),
     ((441, 460), True), ((1650, 1660), False), ((5000, 6000), False)],
)  # fmt: skip
def test_what_cannot_hold_a_resonance_is_asked(window: tuple[float, float], asked: bool) -> None:
    found = empty_windows({"OOP": window}, possible_resonances(FREE, STUCK), max(STUCK))
    assert bool(found) == asked, "above the highest frequency that is known, nothing is"
    if asked:
        assert found[0].startswith(f"study.modes.OOP.window = {window[0]:g} to {window[1]:g} Hz")
        assert "269 to 4" in found[0] or "1700" in found[0]
