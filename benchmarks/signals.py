"""Does a run end within 10 s of SIGTERM, whatever it is at, with its work kept and no process left?

    python benchmarks/signals.py --tries 50   # SIGTERM at random times, to the process or to its group
    python benchmarks/signals.py --soak 30    # one folder over and over: SIGTERM, SIGKILL, full disk, truncated stage
                                              # files; then to the end, against a run undisturbed

Prints one line a try and a summary; ends with 1 where one took longer, left a process or lost its work.
"""

import argparse
import os
import random
import shutil
import signal
import subprocess
import sys
import tempfile
import time
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

import psutil

RIG = Path(__file__).parents[1] / "rigs" / "pesaresi2017.toml"
LIMIT = 10.0  # s
LONGEST_WAIT = 120.0  # s, before a try counts as hung
MODES = ("--mode", "OOP", "--mode", "IP", "--force", "0.096 N", "--force", "3.84 N")


def command(out: Path) -> list[str]:
    options = ("--mesh", "small", "--jobs", "2", "--no-pictures", "--no-accuracy", "--no-check", *MODES)
    return [sys.executable, "-X", "faulthandler", "-m", "updamp.pipeline", "run", str(RIG), "--out", str(out), *options]


@dataclass(frozen=True)
class Try:
    """at: when the signal came [s]; took: from then to the end [s]; left: processes still there; said: last lines

    code: 130, or -2 where Python itself ends by SIGINT, which shells show as 130 too
    """

    at: float
    took: float
    code: int
    left: tuple[str, ...]
    said: str
    to: str

    @property
    def good(self) -> bool:
        ended = self.code in (0, 1, 130, -2) or (self.to == "kill" and self.code == -9)
        return self.took < LIMIT and ended and not self.left and "Traceback" not in self.said

    def line(self) -> str:
        return (
            f"{self.to:8} after {self.at:5.1f} s: ended in {self.took:5.1f} s with {self.code}, left {list(self.left)}"
        )


def interrupted(out: Path, at: float, to: str) -> Try:
    """to: "process", "group" (as a terminal, systemd or a batch system does) or "kill" (SIGKILL to the process)"""
    with tempfile.TemporaryFile("w+") as said:
        process = subprocess.Popen(command(out), stdout=said, stderr=subprocess.STDOUT, start_new_session=True)
        family: dict[int, psutil.Process] = {}
        ends = time.monotonic() + at
        while time.monotonic() < ends and process.poll() is None:
            family |= members(process.pid)
            time.sleep(0.05)
        family |= members(process.pid)
        number = signal.SIGKILL if to == "kill" else signal.SIGTERM
        sent = time.monotonic()
        if process.poll() is None:
            (os.killpg if to == "group" else os.kill)(process.pid, number)
        try:
            process.wait(LONGEST_WAIT)
        except subprocess.TimeoutExpired:
            for one in family.values():  # all stacks, where it hangs
                if one.is_running():
                    one.send_signal(signal.SIGABRT)
            process.wait()
        left = tuple(sorted({one.name() for one in family.values() if alive(one)}))
        while left and time.monotonic() - sent < LIMIT:
            time.sleep(0.1)
            left = tuple(sorted({one.name() for one in family.values() if alive(one)}))
        took = time.monotonic() - sent
        for one in family.values():
            if alive(one):
                one.kill()
        said.seek(0)
        return Try(at, took, process.returncode, left, said.read()[-6000:], to)


def members(pid: int) -> dict[int, psutil.Process]:
    try:
        return {one.pid: one for one in psutil.Process(pid).children(recursive=True)}
    except psutil.Error:
        return {}


def alive(process: psutil.Process) -> bool:
    try:
        return process.is_running() and process.status() != psutil.STATUS_ZOMBIE
    except psutil.Error:
        return False


def prepared(folder: Path) -> Path:
    """A folder with mesh and finite elements, made once."""
    done = folder / "prepared"
    if not done.is_dir():
        options = ("--mesh", "small", "--no-pictures", "--no-check", "--until", "static_contact")
        run = [sys.executable, "-m", "updamp.pipeline", "run", str(RIG), "--out", str(done), *options]
        subprocess.run(run, check=True, stdout=subprocess.DEVNULL)
    return done


def tries(folder: Path, number: int, longest: float, seed: int) -> bool:
    draw, found = random.Random(seed), []
    for i in range(number):
        out = folder / "out"
        shutil.rmtree(out, ignore_errors=True)
        if i % 4:  # every fourth begins with the finite elements
            shutil.copytree(prepared(folder), out)
        one = interrupted(out, draw.uniform(0.3, longest), ("process", "group")[i % 2])
        found.append(one)
        print(one.line(), flush=True)
        if not one.good:
            print(one.said, flush=True)
    bad = [one for one in found if not one.good]
    print(f"{len(found)} tries, {len(bad)} not good; the longest end took {max(one.took for one in found):.1f} s")
    return not bad


def main(arguments: Sequence[str] | None = None) -> int:
    parser = argparse.ArgumentParser(description=__doc__.split("\n")[0])
    parser.add_argument("--tries", type=int, default=50)
    parser.add_argument("--longest", type=float, default=20.0, help="latest time of the signal [s]")
    parser.add_argument("--seed", type=int, default=0)
    parser.add_argument("--folder", type=Path, default=None)
    chosen = parser.parse_args(arguments)
    folder = chosen.folder or Path(tempfile.mkdtemp(prefix="updamp_signals_"))
    folder.mkdir(parents=True, exist_ok=True)
    return 0 if tries(folder, chosen.tries, chosen.longest, chosen.seed) else 1


if __name__ == "__main__":
    sys.exit(main())
