"""Does a run end within 10 s of SIGTERM, whatever it is at, with its work kept and no process left?

    python benchmarks/signals.py --tries 50   # SIGTERM at random times, to the process or to its group
    python benchmarks/signals.py --soak 30    # one folder over and over: SIGTERM, SIGKILL, full disk, truncated stage
                                              # files; each time it is whole, and at last, against a run undisturbed

Prints one line a try and a summary; ends with 1 where one took longer, left a process or lost its work.
"""

import argparse
import os
import random
import resource
import shutil
import signal
import subprocess
import sys
import tempfile
import time
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

import h5py
import numpy as np
import psutil

RIG = Path(__file__).parents[1] / "commands" / "example" / "rig.toml"  # that of `updamp init`: 16 contact elements
TIMES = ("seconds",)  # datasets that two runs need not share
LIMIT = 10.0  # s
LATEST = 20.0  # s, when a signal of --tries comes: in the midst of the curves
LONGEST_WAIT = 120.0  # s, before a try counts as hung
FULL = "UPDAMP_FILES_UP_TO"  # bytes that a file of the next run may grow to: beyond, writing fails as on a full disk


def command(out: Path) -> list[str]:
    options = ("--mesh", "small", "--jobs", "2", "--no-pictures", "--no-check")
    return [sys.executable, "-X", "faulthandler", "-m", "updamp.pipeline", "run", str(RIG), "--out", str(out), *options]


@dataclass(frozen=True)
class Try:
    """at: when the signal came [s]; took: from then to the end [s]; left: processes still there; said: last lines

    at_work: whether the process was there when the signal came
    code: 130, or -2 where Python itself ends by SIGINT, which shells show as 130 too
    """

    at: float
    took: float
    code: int
    left: tuple[str, ...]
    said: str
    to: str
    at_work: bool

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
        process = subprocess.Popen(
            command(out), stdout=said, stderr=subprocess.STDOUT, start_new_session=True, preexec_fn=_limited
        )
        family: dict[int, psutil.Process] = {}
        ends = time.monotonic() + at
        while time.monotonic() < ends and process.poll() is None:
            family |= members(process.pid)
            time.sleep(0.05)
        family |= members(process.pid)
        number = signal.SIGKILL if to == "kill" else signal.SIGTERM
        sent = time.monotonic()
        if at_work := process.poll() is None:
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
        return Try(at, took, process.returncode, left, said.read()[-6000:], to, at_work)


def _limited() -> None:
    """In the new process: its disk is as good as full, where that is asked for."""
    if FULL in os.environ:
        signal.signal(signal.SIGXFSZ, signal.SIG_IGN)
        resource.setrlimit(resource.RLIMIT_FSIZE, (int(os.environ[FULL]),) * 2)


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


def whole(out: Path) -> tuple[int, float]:
    """Run to the end, undisturbed; its exit code, and how long it took [s]."""
    began = time.monotonic()
    code = subprocess.run(command(out), stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL).returncode
    return code, time.monotonic() - began


def differing(out: Path, reference: Path) -> list[str]:
    """Files of stages that are not the same to the last digit, or of which one run has none."""
    names = {path.name for folder in (out, reference) for path in (folder / "stages").glob("*.h5")}
    return sorted(name for name in names if contents(out / "stages" / name) != contents(reference / "stages" / name))


def contents(path: Path) -> dict[str, bytes]:
    """Of all datasets but times, bit by bit; none where the file is not there."""
    found: dict[str, bytes] = {}

    def take(name: str, entry: h5py.Group | h5py.Dataset) -> None:
        if isinstance(entry, h5py.Dataset) and not set(name.split("/")) & set(TIMES):
            values = np.asarray(entry[()])  # texts come as objects, whose own bytes are addresses
            found[name] = repr(values.tolist()).encode() if values.dtype.hasobject else values.tobytes()

    if path.is_file():
        with h5py.File(path, "r") as file:
            file.visititems(take)
    return found


def begun_anew(folder: Path, name: str) -> Path:
    out = folder / name
    shutil.rmtree(out, ignore_errors=True)
    shutil.copytree(prepared(folder), out)
    return out


def soak(folder: Path, number: int, longest: float | None, seed: int) -> bool:
    """One folder disturbed over and over, each time until it is whole, and then begun anew: are its results those of a
    run undisturbed? The signal comes within the first half of the time that the run undisturbed took (laws compiled by
    then), or within `longest` [s]: a run that goes on from kept work takes less."""
    draw, good, finished = random.Random(seed), True, 0
    reference, out = begun_anew(folder, "undisturbed"), begun_anew(folder, "soaked")
    whole(reference)
    code, seconds = whole(begun_anew(folder, "undisturbed"))
    longest = seconds / 2 if longest is None else longest
    print(f"undisturbed: {seconds:.1f} s, {code}; signals up to {longest:.1f} s", flush=True)
    found: list[Try] = []
    for i in range(number):
        kind = ("process", "kill", "full", "truncated")[i % 4]
        one = disturbed(out, kind, draw, longest)
        found.append(one)
        print(f"{kind:10}{one.line()}{'' if one.at_work else ', by itself'}", flush=True)
        if not (one.good or (kind == "full" and one.code == 2)):
            print(one.said, flush=True)
            good = False
        if one.code == 0 and not one.at_work and kind != "full":
            finished += 1
            good &= is_as(reference, out)
            out = begun_anew(folder, "soaked")
    code, _ = whole(out)
    print(
        f"{number} disturbances, {sum(one.at_work for one in found)} while at work; the longest end took "
        f"{max(one.took for one in found):.1f} s; {finished} runs came to their end in between, the last with {code}"
    )
    return is_as(reference, out) and good and code == 0


def disturbed(out: Path, kind: str, draw: random.Random, longest: float) -> Try:
    """kind: SIGTERM to the "process", "kill", disk "full" or a "truncated" stage file, and then SIGTERM"""
    stored = sorted((out / "stages").glob("*.h5"))
    if kind == "truncated" and stored:
        victim = draw.choice(stored)
        os.truncate(victim, draw.randrange(victim.stat().st_size))
    elif kind == "full":
        os.environ[FULL] = str(draw.randrange(1_000, 900_000))
    one = interrupted(out, draw.uniform(0.3, longest), "kill" if kind == "kill" else "process")
    os.environ.pop(FULL, None)
    return one


def is_as(reference: Path, out: Path) -> bool:
    different, files = differing(out, reference), len(list((reference / "stages").glob("*.h5")))
    print(f"{len(different)} of {files} files differ from the undisturbed run's {different}", flush=True)
    return not different


def main(arguments: Sequence[str] | None = None) -> int:
    parser = argparse.ArgumentParser(description=__doc__.split("\n")[0])
    parser.add_argument("--tries", type=int, default=50)
    parser.add_argument("--soak", type=int, default=0, help="disturb one folder so many times, in place of --tries")
    parser.add_argument("--longest", type=float, default=None, help="latest time of the signal [s]")
    parser.add_argument("--seed", type=int, default=0)
    parser.add_argument("--folder", type=Path, default=None)
    chosen = parser.parse_args(arguments)
    folder = chosen.folder or Path(tempfile.mkdtemp(prefix="updamp_signals_"))
    folder.mkdir(parents=True, exist_ok=True)
    if chosen.soak:
        return 0 if soak(folder, chosen.soak, chosen.longest, chosen.seed) else 1
    return 0 if tries(folder, chosen.tries, chosen.longest or LATEST, chosen.seed) else 1


if __name__ == "__main__":
    sys.exit(main())
