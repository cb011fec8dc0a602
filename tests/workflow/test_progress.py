"""What a run shows: one line for all that is done at the same time, and a log of what stays on the terminal."""

import io
from pathlib import Path

import pytest
from rich.console import Console

from updamp.workflow.progress import Display, time_left


def test_pieces_together_are_told_as_their_mean_and_the_bar_goes_with_them() -> None:
    with Display(Console(file=io.StringIO())) as display:
        all_of_them = display.together("in all", 4)
        all_of_them.update("a", 0.5)
        all_of_them.update("b", 0.1)
        assert all_of_them.share == pytest.approx(0.15)
        all_of_them.done("a")
        assert all_of_them.share == pytest.approx(0.275)
        (bar,) = display._progress.tasks
        assert bar.completed == pytest.approx(0.275)
        assert bar.fields["detail"].startswith("1 of 4 done, about ")
        all_of_them.over()
        assert display._progress.tasks == []


@pytest.mark.parametrize("terminal", [False, True])
def test_work_that_begins_is_said_once_where_no_bar_can_be_seen(terminal: bool) -> None:
    said = io.StringIO()
    with Display(Console(file=said, force_terminal=terminal)) as display:
        all_of_them = display.together("in all", 2)
        for share in (0.0, 0.1, 0.5):
            all_of_them.update("OOP 17 N, more harmonics", share)
        all_of_them.over()
    assert said.getvalue().count("begins    OOP 17 N, more harmonics") == (0 if terminal else 1)


@pytest.mark.parametrize("terminal", [False, True])
def test_steps_are_lines_where_no_bar_can_be_seen(terminal: bool) -> None:
    said = io.StringIO()
    with Display(Console(file=said, force_terminal=terminal)) as display:
        for share, what in ((0.1, "calibration"), (0.3, "edge_gap: leaves 1.20 times the scatter")):
            display.step("search", share, what)
        display.forget("search")
    lines = [line for line in said.getvalue().splitlines() if line.startswith("at ")]
    assert [line.split(maxsplit=2)[2] for line in lines] == (
        [] if terminal else ["calibration", "edge_gap: leaves 1.20 times the scatter"]
    )


def test_time_left_follows_from_the_share_once_it_is_known() -> None:
    assert time_left(10.0, 0.01) == ""
    assert time_left(10.0, 0.25) == ", about 30 s left"
    assert time_left(600.0, 0.5) == ", about 10 min left"
    assert time_left(10.0, 1.0) == ""


def test_lines_are_logged_with_their_time(tmp_path: Path) -> None:
    said = io.StringIO()
    with Display(Console(file=said, width=100), tmp_path / "log.txt") as display:
        display.done("mesh", "0.2 s")
        display.note("question", "is it in Hz?")
        display.failed("OOP 17 N", "stalled")
    lines = (tmp_path / "log.txt").read_text().splitlines()
    assert [line[20:30].strip() for line in lines] == ["done", "note", "stopped"]
    assert [line[30:] for line in lines] == [line[10:] for line in said.getvalue().splitlines() if line.strip()]
    with Display(Console(file=said), tmp_path / "nowhere" / "log.txt") as display:
        display.done("mesh", "0.2 s")  # without a log all goes on
