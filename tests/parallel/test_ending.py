"""SIGTERM, to the process or to its group, ends a command within 10 s, with its work kept and no process left, also
where Python does not get to its handlers. benchmarks/signals.py does it 50 times to real runs."""

import os
import signal
import subprocess
import sys
import time
from pathlib import Path

import psutil
import pytest

TESTS = Path(__file__).parents[1]


def started(folder: Path, where: str, begun: int) -> subprocess.Popen[bytes]:
    """Once so many pieces of work have begun."""
    paths = os.pathsep.join(path for path in [str(TESTS), *sys.path] if path)
    process = subprocess.Popen(
        [sys.executable, "-m", "support.ending_work", str(folder), where],
        env={**os.environ, "PYTHONPATH": paths},
        stdout=subprocess.PIPE,
        stderr=subprocess.PIPE,
        start_new_session=True,
    )
    assert process.stdout is not None
    assert [process.stdout.readline() for _ in range(begun)] == [b"begun\n"] * begun
    return process


@pytest.mark.parametrize("to", ["process", pytest.param("group", marks=pytest.mark.long), "killed"])
def test_workers_end_with_what_they_have_stored(tmp_path: Path, to: str) -> None:
    with started(tmp_path, "worker", 2) as process:
        family = psutil.Process(process.pid).children(recursive=True)
        assert len(family) >= 2
        sent = time.monotonic()
        number = signal.SIGKILL if to == "killed" else signal.SIGTERM
        (os.killpg if to == "group" else os.kill)(process.pid, number)
        process.wait(timeout=20)
        _, alive = psutil.wait_procs(family, timeout=20)
        assert alive == []
        assert time.monotonic() - sent < 10
        assert process.returncode == (-9 if to == "killed" else 130)
        assert (tmp_path / "polite").read_text() == "stored"
        assert process.stderr is not None
        said = process.stderr.read().decode()
        assert "Traceback" not in said
        assert ("run again" in said) == (to != "killed")


def test_a_command_in_compiled_code_ends_too(tmp_path: Path) -> None:
    with started(tmp_path, "command", 1) as process:
        time.sleep(0.5)  # until it is there
        sent = time.monotonic()
        for _ in range(3):  # further ones change nothing
            process.terminate()
            time.sleep(0.1)
        assert process.wait(timeout=20) == 130
        assert 5 < time.monotonic() - sent < 10, "it is given time to end by itself"
        assert process.stderr is not None
        assert b"run again" in process.stderr.read()


def test_an_interruption_that_got_lost_comes_again(tmp_path: Path) -> None:
    """As where it is raised while the garbage collector calls a library."""
    with started(tmp_path, "finaliser", 1) as process:
        sent = time.monotonic()
        process.terminate()
        assert process.wait(timeout=20) == 130
        assert time.monotonic() - sent < 5
        assert process.stderr is not None
        said = process.stderr.read().decode()
        assert "run again" in said
        assert "Traceback" not in said
