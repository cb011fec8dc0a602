"""Windows in which nothing can resonate are asked about, and no others."""

from pathlib import Path

import pytest

from updamp.model.rig_files import load_rig
from updamp.rig.questions import empty_windows, misnamed, possible_resonances, questions, undivided_windows

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


COUPLED = {"OOP": 294.21, "IP": 291.54}
REFERENCE = Path(__file__).parents[2] / "rigs" / "pesaresi2017.toml"


@pytest.mark.parametrize(
    ("window", "asked"),
    [(["340 Hz", "436 Hz"], 0), (["100 Hz", "600 Hz"], 1), (["433 Hz", "451 Hz"], 1), (["440 Hz", "500 Hz"], 1)],
    ids=["ends overlap", "the other within it", "the same", "the other's middle"],
)
def test_a_window_that_has_the_middle_of_another_is_asked_about(window: list[str], asked: int) -> None:
    """OOP has 433 to 451 Hz."""
    found = questions(load_rig(REFERENCE, {"study.modes.IP.window": window}))
    assert len(found) == asked
    assert all("study.modes.IP.window" in one and "overlaps that of OOP, 433 Hz to 451 Hz" in one for one in found)


def test_a_window_with_both_coupled_resonances_is_asked_about() -> None:
    windows = {"OOP": (293.0, 300.0), "IP": (100.0, 600.0), "third": (100.0, 600.0)}
    (question,) = undivided_windows(windows, COUPLED)
    assert question.startswith("study.modes.IP.window = 100 to 600 Hz has OOP at 294.21 Hz and IP at 291.54 Hz in it")


def test_a_mode_with_the_resonance_of_another_is_said() -> None:
    (sentence,) = misnamed({"OOP": 294.208, "IP": 294.208, "third": 700.0}, COUPLED)
    assert sentence.startswith("IP: its resonance at the lowest force, 294.21 Hz, is that of OOP")
    assert misnamed({"OOP": 294.208, "IP": 291.538}, COUPLED) == []
