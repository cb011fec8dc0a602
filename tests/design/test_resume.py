"""A study that is killed half-way goes on without losing a finished design."""

import json
import os
import signal
import subprocess
import sys
import time
from pathlib import Path

import pytest
from support.modal_study import RIG, SLOW, write_study
from support.study_runs import run

from updamp.design.run_study import StudyResult

METHOD = 'kind = "latin_hypercube"\nsamples = 10'
SEARCH = 'kind = "tpe"\ndesigns = 14\n'  # the first ten are drawn at random
MINIMISE = '[[objectives]]\nresponse = "free"\ngoal = "minimise"\n'


def slow_study(folder: Path, method: str = METHOD, more: str = "") -> Path:
    """A design takes a third of a second."""
    (folder / "slow.py").write_text(SLOW)
    text = f'{RIG}\n[[effects]]\nname = "slow"\nfile = "slow.py"\nvalues = {{ delay = "0.3 s" }}\n'
    (folder / "beam.toml").write_text(text)
    return write_study(folder, method, more)


def records(folder: Path) -> dict[str, str]:
    return {path.name: path.read_text() for path in sorted((folder / "out" / "designs").glob("*.json"))}


def wait_for(folder: Path, number: int, process: subprocess.Popen[bytes]) -> None:
    until = time.monotonic() + 120
    while len(records(folder)) < number:
        assert time.monotonic() < until, "no designs come"
        assert process.poll() is None, "it has ended"
        time.sleep(0.02)


def started(path: Path, jobs: int) -> subprocess.Popen[bytes]:
    environment = {**os.environ, "PYTHONPATH": os.pathsep.join(sys.path)}
    command = [sys.executable, "-m", "updamp.pipeline", "design", str(path), "--jobs", str(jobs)]
    # What a shell starts in the background ignores Ctrl-C, and so would this process's children.
    before = signal.signal(signal.SIGINT, signal.default_int_handler)
    try:
        return subprocess.Popen(command, env=environment, stdout=subprocess.DEVNULL, stderr=subprocess.PIPE)
    finally:
        signal.signal(signal.SIGINT, before)


@pytest.mark.parametrize("jobs", [pytest.param(1, marks=pytest.mark.long), 2])
def test_nothing_that_was_finished_is_lost_or_solved_again_after_a_kill(folder, jobs):
    path = slow_study(folder)
    process = started(path, jobs)
    wait_for(folder, 3, process)
    process.kill()
    process.communicate()
    before = records(folder)
    assert 3 <= len(before) < 10
    result = run(path)
    after = records(folder)
    assert len(result.records) == len(after) == 10
    assert {name: after[name] for name in before} == before
    whole = run(path, out=folder / "at_once")
    assert [one.values for one in whole.records] == [one.values for one in result.records], (
        "numbers are those of one go"
    )


@pytest.mark.long
@pytest.mark.parametrize("finished", [3, 9])
def test_a_search_that_was_killed_comes_to_the_designs_of_one_that_was_not(folder, finished):
    pytest.importorskip("optuna")
    path = slow_study(folder, SEARCH, MINIMISE)
    process = started(path, 2)
    wait_for(folder, finished, process)
    process.kill()
    process.communicate()
    before = records(folder)
    assert finished <= len(before) < 14
    result = run(path)
    assert {name: text for name, text in records(folder).items() if name in before} == before
    whole = run(path, out=folder / "in_one_go")
    assert table(whole) == table(result)


def table(result: StudyResult) -> list[tuple[object, ...]]:
    return [(one.number, one.values, one.responses) for one in result.records]


def test_an_interruption_keeps_what_is_finished_and_says_how_to_go_on(folder):
    process = started(slow_study(folder), 1)
    wait_for(folder, 2, process)
    process.send_signal(signal.SIGINT)
    _, error = process.communicate(timeout=60)
    assert process.returncode == 130
    assert b"to go on" in error
    found = json.loads((folder / "out" / "study.json").read_text())
    assert found["ended"] is False
    assert 2 <= found["designs"] < 10


def test_a_record_that_was_cut_off_is_solved_again(folder):
    path = write_study(folder, 'kind = "grid"\npoints = 2')
    first = run(path)
    (folder / "out" / "designs" / "000002.json").write_text('{"number": 2, "key"')
    second = run(path)
    assert [one.responses for one in second.records] == [one.responses for one in first.records]
