"""`updamp run --quick`: the same curves with less beside them, what is missing is said, and the next run adds it."""

import fcntl
import json
import os
import re
import select
import shutil
import subprocess
import sys
import termios
import time
from dataclasses import fields, replace
from pathlib import Path

import h5py
import numpy as np
import pytest
from support.short_study import run_command, short_study

from updamp.hbm.resonance.resonance_curve import ResonanceCurve
from updamp.workflow import store

LEVELS = ("0.01 N", "3.84 N", "17 N")
WINDOWS = (441, 459), (431, 447)
PICTURES = {"frf_OOP", "resonance_OOP", "mesh"}
ONE_MODE = ("--mesh", "small", "--mode", "OOP", "--jobs", 1)


def contents(path: Path) -> dict[str, bytes]:
    """Of a stage's datasets but times, bit by bit."""
    with h5py.File(path, "r") as file:
        names: list[str] = []
        file.visit(names.append)
        found = {name: np.asarray(file[name]) for name in names if isinstance(file[name], h5py.Dataset)}
    return {
        name: value.tobytes()
        for name, value in found.items()
        if not name.endswith("seconds") and not value.dtype.hasobject
    }


def summary_of(out: Path) -> dict:
    return json.loads((out / "summary.json").read_text())


@pytest.fixture(scope="module")
def quick(tmp_path_factory):
    """Its rig file, its folder, what it printed."""
    folder = tmp_path_factory.mktemp("quick")
    rig = short_study(folder, *WINDOWS, LEVELS)
    result = run_command("run", rig, *ONE_MODE, "--out", folder / "out", "--quick")
    assert result.exit_code == 0, result.output
    return rig, folder / "out", result.output


def test_the_highest_level_has_the_peak_of_the_followed_resonance_and_no_curve(quick):
    _, out, printed = quick
    summary = summary_of(out)
    assert [entry["force_N"] for entry in summary["curves"]] == [0.01, 3.84]
    assert [entry["marching"]["verdict"] for entry in summary["curves"]] == ["stays", "stays"]
    assert {path.stem for path in (out / "pictures").iterdir()} == PICTURES
    peak, frequency = (
        summary["resonances"][0]["at_levels"][key][-1] for key in ("receptance_mm_per_N", "frequency_Hz")
    )
    assert f"OOP 17 N: peak of {peak:.5f} mm/N at {frequency:.2f} Hz" in printed


def test_what_is_not_checked_is_said_in_summary_log_terminal_and_picture(quick):
    _, out, printed = quick
    said = summary_of(out)["not_checked"]
    for words in ("OOP 17 N: no curve", "which points are stable", "the numerical error", "pictures of contacts"):
        assert sum(words in sentence for sentence in said) == 1, words
    assert len(said) == 4
    for text in (printed, (out / "log.txt").read_text(), run_command("show", out).output):
        assert all(" ".join(sentence.split()) in " ".join(text.split()) for sentence in said[:3])
    picture = (out / "pictures" / "frf_OOP.svg").read_text()
    assert "not checked: stability, numerical error" in picture
    assert "peak followed in force, no curve" in picture


def test_why_the_resonance_stopped_is_said_at_the_end_and_of_a_kept_one_too(quick, tmp_path):
    rig, out, _ = quick
    shutil.copytree(out, tmp_path / "out")
    file = tmp_path / "out" / "stages" / "resonance_OOP.h5"
    whole, stamp = store.read(file, ResonanceCurve), store.read_stamp(file)
    n = len(whole)
    cut = {f.name: v[: n // 2] for f in fields(whole) if isinstance(v := getattr(whole, f.name), np.ndarray)}
    store.write(file, replace(whole, **cut, complete=False, stopped="stalled: use more time samples"), stamp)
    again = run_command("run", rig, *ONE_MODE, "--out", tmp_path / "out", "--quick")
    assert again.exit_code == 1
    said = " ".join(again.output.split())
    assert "stopped OOP, resonance kept as it is on file: stalled: use more time samples" in said
    assert (
        "OOP 17 N: there is no curve, and the resonance was not followed so far: stalled: use more time samples" in said
    )


@pytest.mark.long
def test_the_run_without_it_computes_what_is_missing_and_takes_the_rest(quick, tmp_path):
    rig, out, _ = quick
    shutil.copytree(out, tmp_path / "out")
    kept = {path.name: path.read_bytes() for path in (tmp_path / "out" / "stages").glob("*.h5")}
    result = run_command("run", rig, *ONE_MODE, "--out", tmp_path / "out", "--no-pictures")
    assert result.exit_code == 0, result.output
    assert {name: (tmp_path / "out" / "stages" / name).read_bytes() for name in kept} == kept
    summary, before = summary_of(tmp_path / "out"), summary_of(out)
    assert summary["not_checked"] == []
    assert [entry["force_N"] for entry in summary["curves"]] == [0.01, 3.84, 17.0]
    for entry, first in zip(summary["curves"], before["curves"], strict=False):
        assert entry["peak_receptance_mm_per_N"] == first["peak_receptance_mm_per_N"]
        assert first["numerical_error"] is None
        assert entry["numerical_error"]["not_known"] == ""
    peak = before["resonances"][0]["at_levels"]["receptance_mm_per_N"][-1]
    assert summary["curves"][-1]["peak_receptance_mm_per_N"] == pytest.approx(peak, rel=1e-4)
    again = run_command("run", rig, *ONE_MODE, "--out", tmp_path / "out", "--quick")
    assert again.exit_code == 0, again.output
    assert len(summary_of(tmp_path / "out")["curves"]) == 3, "what is on file is taken"
    assert "not checked" not in (tmp_path / "out" / "pictures" / "frf_OOP.svg").read_text(), (
        "and the picture has it all"
    )


def test_a_curve_does_not_depend_on_what_is_left_out(quick, tmp_path):
    """Alone, as a force that is asked for, to the last bit; another run, with another first piece of work."""
    rig, out, _ = quick
    result = run_command(
        "run", rig, *ONE_MODE, "--out", tmp_path / "out", "--force", "3.84 N", "--no-accuracy", "--no-resonance",
        "--no-stability", "--no-marching", "--no-pictures",
    )  # fmt: skip
    assert result.exit_code == 0, result.output
    one, other = (contents(folder / "stages" / "curve_OOP_3.84N.h5") for folder in (out, tmp_path / "out"))
    assert len(one) > 5
    assert one == other
    assert len(summary_of(tmp_path / "out")["not_checked"]) == 4, "what is not asked for is said too"
    part = summary_of(tmp_path / "out")["part"]
    assert part.startswith("asked for with --mode and --force: summary.json")
    assert "have OOP at 3.84 N alone" in part
    assert part in " ".join(result.output.split())


AS_A_SHELL_DOES = (
    "import fcntl, os, sys, termios; fcntl.ioctl(0, termios.TIOCSCTTY, 0); "
    "os.execv(sys.executable, [sys.executable, '-m', 'updamp.pipeline', *sys.argv[1:]])"
)
MARCHING = re.compile(r"marched in.*marched in time")  # the bar's name, and what it is at


@pytest.mark.long
def test_ctrl_c_in_a_terminal_ends_a_march_in_time(quick, tmp_path):
    """A real terminal, whose driver sends SIGINT to the whole group of processes."""
    rig, out, _ = quick
    shutil.copytree(out, tmp_path / "out")
    forces = [option for force in ("3 N", "5 N", "8 N", "12 N") for option in ("--force", force)]
    command = ["run", rig, *ONE_MODE, "--out", tmp_path / "out", *forces, "--no-pictures", "--no-stability"]
    command += ["--no-accuracy", "--no-resonance"]
    assert run_command(*command, "--no-marching").exit_code == 0
    ours, its = os.openpty()
    fcntl.ioctl(its, termios.TIOCSWINSZ, np.array([50, 200, 0, 0], dtype=np.uint16).tobytes())
    started = [sys.executable, "-c", AS_A_SHELL_DOES, *map(str, command)]
    process = subprocess.Popen(started, stdin=its, stdout=its, stderr=its, start_new_session=True)
    os.close(its)
    try:
        shown = read_until(ours, MARCHING)
        os.write(ours, b"\x03")
        sent = time.monotonic()
        shown += read_until(ours, None)
        assert process.wait(timeout=30) == 130, shown
        assert time.monotonic() - sent < 10
    finally:
        process.kill()
        os.close(ours)
    assert "Interrupted. What is finished is kept" in shown
    assert "Traceback" not in shown
    marched = [f"marched_peak_OOP_{force}N.h5" for force in (3, 5, 8, 12)]
    there = [name for name in marched if (tmp_path / "out" / "stages" / name).exists()]
    assert len(there) < len(marched), "it came while a peak was marched"
    after = run_command(*command)
    assert after.exit_code == 0, after.output
    assert [entry["marching"]["verdict"] for entry in summary_of(tmp_path / "out")["curves"]] == 4 * ["stays"]


def read_until(terminal: int, wanted: re.Pattern[str] | None, longest: float = 120.0) -> str:
    """What the terminal shows up to there, or to its end."""
    shown, ends = "", time.monotonic() + longest
    while time.monotonic() < ends and not (wanted is not None and wanted.search(shown)):
        if not select.select([terminal], [], [], 0.1)[0]:
            continue
        try:
            shown += os.read(terminal, 65536).decode(errors="replace")
        except OSError:  # no process has it open any more
            break
    return shown
