"""Broken folders, results, options, disks and processes."""

import errno
import os
import signal
import subprocess
import sys
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from io import StringIO
from pathlib import Path
from unittest.mock import patch

import numpy as np
from rich.console import Console
from support.broken.outcome import Broken, CrashError, Told, call, command
from support.broken.rig_files import MODAL, REFERENCE

from updamp.diagnosis.verdict import VERDICT_JSON, Candidate, Confounding, ErrorReached, FittedParameter, Verdict
from updamp.model.rig_files import load_rig
from updamp.workflow.job_pool import JobEnd, run_all
from updamp.workflow.progress import Display
from updamp.workflow.run import Run
from updamp.workflow.run_options import RunOptions

RUN = "run RIG --mesh PRESET --out DIR"


def _rig(folder: Path, text: str = REFERENCE) -> Path:
    path = folder / "mine.toml"
    path.write_text(text, encoding="utf-8")
    return path


# --- what a run left, broken ---


def summary(name: str, content: bytes, *words: str) -> Broken:
    def made(folder: Path) -> Told:
        (folder / "summary.json").write_bytes(content)
        return command("show", folder)

    return Broken(f"show: summary.json {name}", ("summary.json", "updamp run", *words), made)


SUMMARIES = [
    summary("empty", b""),
    summary("cut off", b'{"rig": "pesaresi2017", "cur'),
    summary("a list", b"[1, 2]"),
    summary("a number", b"3"),
    summary("binary", bytes(range(256))),
    summary("curves without entries", b'{"rig": "a", "curves": [{}]}'),
    summary("curves no list", b'{"rig": "a", "curves": 3}'),
    Broken("show: no summary", ("summary.json", "no such file", "updamp run"), lambda folder: command("show", folder)),
]

# --- diagnoses and histories ---


def _verdict(rig: str, path: str) -> Verdict:
    mass = FittedParameter("mass", "kg", 0.1, 0.09, 0.11, 0.0, 0.0, 1.0)
    nan = float("nan")
    return Verdict(
        verdict="identified", sentence="", effects=("shaker_attachment",), group=(),
        candidates=(Candidate("shaker_attachment", "", 9.0, 0.5, 80.0, nan, nan, 0.5, (mass,), True, ""),),
        error=ErrorReached(5.0, 1.1, 4.0, 1.3, 1.0), next_measurement=(), signatures=(),
        confounding=Confounding((), np.zeros((0, 0)), 0.9, ()), missing_forces=(), history=(),
        provenance={"measurement": "m.toml", "date": "2026-11-20", "rig": rig, "rig file": path},
    )  # fmt: skip


def diagnosis(name: str, write: Callable[[Path], object], *words: str, arguments: tuple[object, ...] = ()) -> Broken:
    def made(folder: Path) -> Told:
        write(folder / "diagnosis.json")
        return command("add", _rig(folder), *arguments, "--from", folder, "--out", folder / "new.toml")

    return Broken(f"add: {name}", words, made)


def _of(rig: str) -> Callable[[Path], object]:
    return lambda path: VERDICT_JSON.write(path, _verdict(rig, "other.toml"))


def _history(folder: Path) -> Told:
    (folder / "mine.history.json").write_text('{"schema": ', encoding="utf-8")
    return command("history", _rig(folder))


DIAGNOSES = [
    diagnosis("no diagnosis", lambda _: None, "diagnosis.json", "no such file", "updamp diagnose"),
    diagnosis("empty", lambda path: path.write_text(""), "diagnosis.json", "updamp diagnose"),
    diagnosis("cut off", lambda path: path.write_text('{"schema": "updamp'), "diagnosis.json", "updamp diagnose"),
    diagnosis("a list", lambda path: path.write_text("[]"), "diagnosis.json", "updamp diagnose"),
    diagnosis("of another rig", _of("another"), "diagnosis.json", "another", "pesaresi2017"),
    diagnosis("unknown effect", _of("pesaresi2017"), "no such effect", "did you mean", arguments=("shaker_atachment",)),
    Broken("history: cut off", ("mine.history.json", "updamp add"), _history),
    Broken("add: no --from", ("--from", "missing"), lambda f: command("add", _rig(f))),
    Broken("remove: not there", ("edge_gap", "no effects"), lambda f: command("remove", _rig(f), "edge_gap")),
]

# --- output folders ---


def output(name: str, prepare: Callable[[Path], object], *words: str, text: str = REFERENCE) -> Broken:
    """Before the work begins."""

    def made(folder: Path) -> Told:
        out = folder / "out"
        prepare(out)

        def work() -> str:
            said = StringIO()
            Run(load_rig(_rig(folder, text)), RunOptions("small", out), Display(Console(file=said, width=10_000)))
            return said.getvalue()

        return call(work)

    return Broken(f"out: {name}", words, made)


def _another(out: Path) -> None:
    out.mkdir()
    (out / "summary.json").write_text('{"rig": "another", "curves": []}', encoding="utf-8")


@contextmanager
def forbidden(path: Path) -> Iterator[None]:
    """As if it were not ours to read or write: tests may run as root, whom no mode keeps out."""
    real_open, real_mkdir, real_access, real_text = Path.open, Path.mkdir, os.access, Path.read_text
    real_bytes = Path.read_bytes

    def refuse(of: Path) -> None:
        if Path(of) == path or path in Path(of).parents:
            raise PermissionError(errno.EACCES, "Permission denied", str(of))

    def opens(self: Path, *a: object, **k: object) -> object:
        refuse(self)
        return real_open(self, *a, **k)  # type: ignore[call-overload]

    def reads(self: Path, *a: object, **k: object) -> str:
        refuse(self)
        return real_text(self, *a, **k)  # type: ignore[arg-type]

    def reads_bytes(self: Path) -> bytes:
        refuse(self)
        return real_bytes(self)

    def makes(self: Path, *a: object, **k: object) -> None:
        refuse(self)
        real_mkdir(self, *a, **k)  # type: ignore[arg-type]

    def may(of: object, mode: int) -> bool:
        return Path(str(of)) != path and path not in Path(str(of)).parents and real_access(str(of), mode)

    with (
        patch.object(Path, "open", opens),
        patch.object(Path, "read_text", reads),
        patch.object(Path, "read_bytes", reads_bytes),
        patch.object(Path, "mkdir", makes),
        patch("os.access", may),
    ):
        yield


def _unreadable_rig(folder: Path) -> Told:
    rig = _rig(folder)
    with forbidden(rig):
        return command("check", rig)


def _unwritable_out(folder: Path) -> Told:
    (folder / "out").mkdir()
    with forbidden(folder / "out"):
        return output("", lambda _: None).give(folder)


def _unreadable_results(folder: Path) -> Told:
    (folder / "summary.json").write_text("{}", encoding="utf-8")
    with forbidden(folder / "summary.json"):
        return command("show", folder)


OUTPUTS = [
    output("a file", lambda out: out.write_text("x"), "out", "is a file", "--out"),
    output("in a file", lambda out: out.parent.joinpath("out").write_text(""), "out", "is a file", "--out"),
    output("of another rig", _another, "out", "another", "pesaresi2017", "--out"),
    Broken("out: not ours to write", ("out", "permission", "--out"), _unwritable_out),
    Broken("rig: not ours to read", ("mine.toml", "is not readable"), _unreadable_rig),
    Broken("show: not ours to read", ("summary.json", "cannot be read", "permission"), _unreadable_results),
]

# --- options ---


def options(*arguments: str, words: tuple[str, ...], text: str = REFERENCE) -> Broken:
    def made(folder: Path) -> Told:
        rig = _rig(folder, text)
        return command(*(str(rig) if a == "RIG" else a.replace("OUT", str(folder / "out")) for a in arguments))

    return Broken(f"options: {' '.join(arguments)}", words, made)


GO = ("run", "RIG", "--mesh", "small", "--out", "OUT")
OPTIONS = [
    options("run", "RIG", "--mesh", "tiny", "--out", "OUT", words=("--mesh tiny", "small, medium, full")),
    options(*GO, "--mode", "XY", words=("--mode XY", "OOP, IP")),
    options(*GO, "--force", "3.84", words=("--force 3.84", "state its unit")),
    options(*GO, "--force", "-1 N", words=("--force -1 N", "out of range")),
    options(*GO, "--force", "17 MN", "--until", "lunch", words=("--until lunch", "stages are")),
    options(*GO, "--jobs", "0", words=("--jobs", "1")),
    options(*GO, "--jobs", "-3", words=("--jobs", "1")),
    options(*GO, "--jobs", "100000", "--until", "mesh", words=("--jobs 100000", "memory", "at most")),
    options(*GO[:-1], "", words=("--out", "nothing is named", "folder you are in")),
    options("compare", "RIG", "m.toml", "--out", "", words=("--out", "nothing is named")),
    options("study", "RIG", "--out", " ", words=("--out", "nothing is named")),
    options("add", "RIG", "edge_gap", "--from", "x", "--out", "", words=("--out", "nothing is named")),
    options("init", "", words=("FOLDER", "nothing is named")),
    options(*GO, text=MODAL, words=("mine.toml", "modes", "updamp compare")),
    options(
        "compare", "RIG", "nowhere.toml", "--mesh", "small", "--out", "OUT", words=("nowhere.toml", "no such file")
    ),
    options(*GO[:-1], "/proc/updamp/out", words=("/proc", "--out")),
    options("study", "RIG", words=("mine.toml", "rig file", "updamp run")),
    options("design", "RIG", words=("mine.toml", "rig file", "updamp run")),
    options("explain", "RIG", "--against", "nowhere.toml", words=("nowhere.toml", "no such file")),
    options("add", "RIG", "edge_gap", "--from", "nowhere", words=("nowhere/diagnosis.json", "updamp diagnose")),
]


def _modal_check(folder: Path) -> Told:
    return command("check", _rig(folder, MODAL))


OPTIONS.append(Broken("check: a rig given by modes", ("80.38", "first_bending"), _modal_check, welcome=True))

# --- disks and processes ---

# A file may not grow beyond 20 kB: writing fails as on a full disk, at whatever layer it is.
FULL_DISK = """
import resource, signal, sys
from pathlib import Path
import numpy as np
{imports}
signal.signal(signal.SIGXFSZ, signal.SIG_IGN)
resource.setrlimit(resource.RLIMIT_FSIZE, (20_000, 20_000))
path = Path(sys.argv[1])
try:
    {write}
except (ValueError, RuntimeError, OSError) as error:
    print(error)
    sys.exit(2)
"""
STORE = (
    "from updamp.workflow import store\nfrom updamp.workflow.adaptive_curves import ChosenHarmonics",
    "store.write(path, ChosenHarmonics('OOP', 1.0, tuple(range(100_000)), (1,), ''), store.Stamp('k'))",
)
SWEEPS = (
    "from updamp.measurement.readers.hdf5 import write_hdf5\n"
    "from updamp.measurement.recorded import RecordedChannel, RecordedSweep",
    "write_hdf5(path, [RecordedSweep('r', 1, 'up', np.arange(9e4), {'c': RecordedChannel(np.ones((1, 90_000)))})])",
)


def full_disk(name: str, imports: str, write: str) -> Broken:
    def made(folder: Path) -> Told:
        code = FULL_DISK.format(imports=imports, write=write)
        done = subprocess.run([sys.executable, "-c", code, str(folder / "x.h5")], capture_output=True, text=True)
        if done.returncode not in (0, 2):
            raise CrashError(f"ended with {done.returncode}: {done.stderr[-300:]}")
        left = [path.name for path in folder.iterdir()]
        return Told(done.returncode == 2 and not left, f"{done.stdout} {done.stderr} {left if left else ''}")

    return Broken(f"disk full: {name}", ("x.h5", "disk"), made)


@dataclass(frozen=True)
class KilledJob:
    output: Path
    name: str = "OOP 17 N"
    key: str = ""
    ease: tuple[float, ...] = (0.0,)

    def run(self, report: object, should_stop: object, memory_of: object) -> JobEnd:  # noqa: ARG002
        os.kill(os.getpid(), signal.SIGKILL)
        return JobEnd.FINISHED

    def conclusion(self) -> tuple[bool, str]:
        return True, ""


def _killed(folder: Path) -> Told:
    (outcome,) = run_all([KilledJob(folder / "x.h5")], 1, lambda *_: None, lambda _: None)
    return Told(outcome.end is JobEnd.FAILED, outcome.message)


MACHINE = [
    full_disk("a stage's product", *STORE),
    full_disk("recorded sweeps", *SWEEPS),
    Broken("a worker is killed", ("memory", "--jobs", "again"), _killed),
]

FOLDERS = [*SUMMARIES, *DIAGNOSES, *OUTPUTS, *OPTIONS, *MACHINE]
