"""Branches predicted by several processes: the same numbers, errors that say whose, and nothing left behind."""

import os
import pickle
import signal
import subprocess
import sys
from dataclasses import replace
from pathlib import Path

import numpy as np
import psutil
import pytest
from support.odd_work import Killed

from updamp.comparison.prediction.branch_tasks import BranchTask, InTurn, PredictionError, by_processes, in_turn
from updamp.comparison.prediction.parameters import Parametrisation
from updamp.comparison.prediction.run_condition import RunCondition
from updamp.effects.catalogue import JOINTS
from updamp.hbm.continuation.continuation import BranchStoppedError
from updamp.hbm.newton.newton import Status
from updamp.model.build import modal_model
from updamp.model.calibration import nuisances
from updamp.model.rig_files import load_modal

TESTS = Path(__file__).parents[2]
FORCES = (0.1, 1.2, 0.6)
START = np.array([1e-3, 1e-3, 1e-3, -1.0])


@pytest.fixture(scope="module")
def tasks():
    """One mode with a softening spring, which compiles fast."""
    beam = modal_model(load_modal(TESTS.parent / "rigs" / "brake_reuss.toml"))
    p, sensors = Parametrisation(beam, nuisances(beam), (JOINTS["joint_cubic"],)), (("beam.drive.x", 1),)
    return [BranchTask(p, START, RunCondition(f"{f:g} N", "first", f, False, (76.5, 81.5), sensors)) for f in FORCES]


@pytest.fixture(scope="module")
def told():
    return []


@pytest.fixture(scope="module")
def two_processes(told):
    with by_processes(2, lambda *what: told.append(what)) as branches:
        yield branches


def test_two_processes_give_the_same_numbers_as_one(tasks, two_processes, told):
    told_here = []
    here = InTurn(lambda *what: told_here.append(what))(tasks)
    u = START + np.array([1e-3, 0, 0, 0])
    moved = in_turn([replace(task, u=u, near=branch) for task, branch in zip(tasks, here, strict=True)])
    elsewhere = two_processes(tasks)
    moved_there = two_processes([replace(t, u=u, near=b) for t, b in zip(tasks, elsewhere, strict=True)])
    for a, b in zip((*here, *moved), (*elsewhere, *moved_there), strict=True):
        assert a.condition == b.condition
        for name in ("u", "place", "state", "along", "slopes", "visited", "w_by_parameter"):
            np.testing.assert_array_equal(getattr(a, name), getattr(b, name))
    assert [what[1:] for what in told] == [(1, 3), (2, 3), (3, 3)] * 2
    assert sorted(what[0] for what in told[:3]) == sorted(f"{force:g} N" for force in FORCES)
    assert [what[0] for what in told_here] == [f"{force:g} N" for force in FORCES]


def test_an_error_says_whose_branch_it_was(tasks, two_processes):
    nowhere = replace(tasks[1], condition=replace(tasks[1].condition, sensors=(("nowhere.x", 1),)))
    with pytest.raises(PredictionError, match=r"^1.2 N: .*nowhere"):
        in_turn([nowhere])
    with pytest.raises(PredictionError, match=r"^1.2 N: .*nowhere"):
        two_processes([tasks[0], nowhere])


def test_a_branch_without_a_beginning_says_whose_it_is_and_survives_the_way_between_processes():
    stop = BranchStoppedError(440.0, 1e-3, Status.STALLED).of("IP 5 N")
    again = pickle.loads(pickle.dumps(stop))
    assert str(again) == str(stop)
    assert str(again).startswith("IP 5 N: the branch stops at 440 Hz")


def test_a_worker_that_the_system_ends_is_told():
    with by_processes(2) as branches, pytest.raises(PredictionError, match=r"^IP 5 N: .*fewer --jobs"):
        branches([Killed("IP 5 N")])


@pytest.mark.parametrize("number", [signal.SIGINT, pytest.param(signal.SIGKILL, marks=pytest.mark.long)])
def test_nothing_is_left_behind_by_an_interruption_or_a_sudden_end(number):
    paths = os.pathsep.join(path for path in [str(TESTS), *sys.path] if path)
    with subprocess.Popen(
        [sys.executable, "-m", "support.odd_work"],
        env={**os.environ, "PYTHONPATH": paths},
        stdout=subprocess.PIPE,
        stderr=subprocess.DEVNULL,
        start_new_session=True,
    ) as parent:
        assert parent.stdout is not None
        try:
            assert [parent.stdout.readline() for _ in range(2)] == [b"begun\n"] * 2
            family = psutil.Process(parent.pid).children(recursive=True)
            assert len(family) >= 2
            if number == signal.SIGINT:
                os.killpg(parent.pid, number)  # as the terminal does
            else:
                parent.send_signal(number)
            parent.wait(timeout=20)
        finally:  # or leaving the context would wait for it
            parent.kill()
        _, alive = psutil.wait_procs(family, timeout=20)
        assert alive == []
