"""Pieces of work, here and in other processes."""

import os
import subprocess
import sys
from pathlib import Path

import pytest
from support import measured_beam
from support.odd_work import fails, has_read, killed, slow_first

from updamp.parallel.processes import chosen_workers, processes
from updamp.parallel.workers import Elsewhere, LongestFirst, WorkerLostError, here


@pytest.fixture(scope="module")
def pool():
    with processes(2) as executor:
        yield executor


def test_results_come_in_the_order_of_the_items_whichever_is_done_first(pool):
    told = []
    found = Elsewhere(pool)(slow_first, 1.0, range(4), lambda place, result: told.append((place, result[0])))
    assert [item for item, _ in found] == [0, 1, 2, 3]
    assert os.getpid() not in {process for _, process in found}
    assert sorted(told) == [(i, i) for i in range(4)]
    assert told[-1] == (0, 0)


def test_here_it_is_this_process_and_one_after_the_other():
    told = []
    found = here(slow_first, 0.0, range(3), lambda place, _: told.append(place))
    assert found == [(i, os.getpid()) for i in range(3)]
    assert told == [0, 1, 2]


def test_what_takes_longest_is_done_first_and_results_stay_in_order():
    told = []
    found = LongestFirst(here, lambda item: item)(slow_first, 0.0, [2, 9, 4], lambda place, _: told.append(place))
    assert [item for item, _ in found] == [2, 9, 4]
    assert told == [1, 2, 0]


def test_no_items_are_no_work(pool):
    assert Elsewhere(pool)(fails, None, [], lambda *_: None) == []


def test_an_error_is_raised_and_the_processes_go_on(pool):
    for workers in (here, Elsewhere(pool)):
        with pytest.raises(ValueError, match="the second one fails"):
            workers(fails, None, range(3), lambda *_: None)
    assert Elsewhere(pool)(fails, None, [5], lambda *_: None) == [5]


def test_a_user_s_effect_is_read_by_the_others_before_their_work(pool, tmp_path):
    path = tmp_path / "twin.py"
    path.write_text(measured_beam.TWIN, encoding="utf-8")
    (names,) = Elsewhere(pool, own=(path,))(has_read, None, [0], lambda *_: None)
    assert len(names) == 1


def test_a_process_that_the_system_ends_is_told_and_so_is_what_to_do():
    with processes(2) as executor:
        workers = Elsewhere(executor)
        with pytest.raises(WorkerLostError, match="fewer --jobs"):
            workers(killed, None, range(3), lambda *_: None)
        with pytest.raises(WorkerLostError, match="fewer --jobs") as lost:
            LongestFirst(workers, lambda item: item)(fails, None, [1, 2], lambda *_: None)
        assert lost.value.place == 1
        with pytest.raises(WorkerLostError, match="fewer --jobs"):
            workers(fails, None, [0], lambda *_: None)


@pytest.mark.parametrize("number", [0, 100_000])
def test_workers_that_the_memory_does_not_hold_are_refused_before_any_is_begun(number: int) -> None:
    with pytest.raises(ValueError, match=f"--jobs {number}: "), chosen_workers(number):
        raise AssertionError("begun")


CALLED = """
from concurrent.futures import ProcessPoolExecutor
from multiprocessing import get_context
from updamp.parallel.workers import Elsewhere, WorkerLostError

try:
    with ProcessPoolExecutor(1, mp_context=get_context("spawn")) as executor:
        Elsewhere(executor)(divmod, 7, [2], lambda *_: None)
except WorkerLostError as error:
    print(error)
"""


@pytest.mark.parametrize("piped", [True, False])
def test_a_program_that_other_processes_cannot_read_anew_is_told(tmp_path: Path, piped: bool) -> None:
    program = tmp_path / "program.py"
    program.write_text(CALLED, encoding="utf-8")
    command = [sys.executable, "-" if piped else str(program)]
    ended = subprocess.run(command, input=CALLED if piped else None, capture_output=True, text=True, check=False)
    expected = "there is no file <stdin>" if piped else f"other processes read {program} anew, to its end"
    assert expected in ended.stdout.replace(f"{tmp_path}/<stdin>", "<stdin>")
