"""How long `updamp compare` takes with ten curves of the reference rig, and how much memory all its processes take.

.venv/bin/python benchmarks/ten_curves.py [--mesh small] [--out FOLDER] [--jobs 2]

The measurement is made of the model's own branches, with other parameters, three assemblies and noise: what it says is
of no interest, what it takes is. Every curve is swept downwards, from above the resonance with all contacts stuck
through whatever hysteresis follows, as far as its highest amplitude is to be seen.
"""

from updamp.parallel.resources import one_thread, thread_limits

one_thread()  # before numpy is loaded: threads make small products many times slower

import csv
import os
import subprocess
import sys
import time
from collections.abc import Iterator
from pathlib import Path
from typing import Annotated

import numpy as np
import psutil
import tomlkit
import typer

from updamp.comparison.prediction.parameters import Parametrisation
from updamp.comparison.prediction.predicted_branch import PredictedBranch
from updamp.comparison.prediction.run_condition import RunCondition
from updamp.comparison.prediction.traced_branch import trace_branch
from updamp.hbm.compilation_cache import keep_compiled
from updamp.model.build import rig_before_effects
from updamp.model.calibration import nuisances
from updamp.model.rig_files import load_rig
from updamp.rig.rig import Rig
from updamp.workflow import stages
from updamp.workflow.progress import Display
from updamp.workflow.run import Run
from updamp.workflow.run_options import RunOptions

HERE = Path(__file__).parents[1]
RIG = HERE / "rigs" / "pesaresi2017.toml"
SENSORS = {"tip_left": "blade_left.tip.x", "tip_right": "blade_right.tip.x"}
# Logarithms of factors on E, loss factor, mu, kt, kn, preload: of the rig measured, and how much assemblies scatter.
TRUTH = np.array([1e-3, 0.05, -0.05, 0.1, -0.03, 0.01])
SCATTER = np.array([1e-4, 0.01, 0.01, 0.02, 0.02, 0.01])
NOISE, GAIN, DRIFT = 0.003, 0.005, 2e-5
POINTS, ASSEMBLIES = 40, 3
# Amplitudes shown, as a share of the highest; and how far above the stuck resonance a sweep begins.
_LOWEST, _ABOVE = 1 / 5, 1.006


def parametrisation(rig: Rig, mesh: str, out: Path) -> Parametrisation:
    with Display() as display:
        done = Run(rig, RunOptions(mesh, out, 1, check=False, until=stages.STATIC_CONTACT), display).products()
    assert done.finite_elements is not None, "the run goes as far as static contact"
    assert done.static_contact is not None, "the run goes as far as static contact"
    model = rig_before_effects(done.finite_elements.product.reduced, done.static_contact.product, rig)
    return Parametrisation(model, nuisances(model))


def make(rig: Rig, mesh: str, out: Path) -> Path:
    """measurement.toml and sweeps.csv"""
    p, rng = parametrisation(rig, mesh, out), np.random.default_rng(7)
    scattered = SCATTER * rng.standard_normal((ASSEMBLIES, len(SCATTER)))
    gains = GAIN * rng.standard_normal((ASSEMBLIES, len(SENSORS)))
    rows: list[tuple[object, ...]] = []
    runs = []
    for mode, study in rig.study.modes.items():
        stuck = None
        for force in rig.study.force_levels:
            name = f"{mode} {force:g} N"
            sensors = tuple((point, 1) for point in SENSORS.values())
            branch = trace_branch(p, TRUTH, RunCondition(name, mode, force, False, study.window, sensors))
            stuck = stuck or float(branch.frequency[np.argmax(np.abs(branch.amplitude[:, 1]))])
            place = _places(branch, stuck)
            runs.append({"name": name, "mode": mode, "file": "sweeps.csv", "held": "force", "level": f"{force!r} N",
                         "sweep": "down"})  # fmt: skip
            print(name, f"{len(branch.points)} points, {branch.visited.sum()} of them seen", branch.stopped, flush=True)
            for repeat, (b, gain) in enumerate(zip(scattered, gains, strict=True), 1):
                rows += _run(name, repeat, force, branch, place, b, gain, rng)
    with (out / "sweeps.csv").open("w", encoding="utf-8", newline="") as file:
        writer = csv.writer(file, lineterminator="\n")
        writer.writerow(("run", "repeat", "sweep", "frequency_Hz", "channel", "harmonic", "real", "imag"))
        writer.writerows(rows)
    channels = {"force": _channel("force", f"blade_{rig.excitation.blade}.excitation.x", "N")}
    channels |= {name: _channel("displacement", point, "m") for name, point in SENSORS.items()}
    table = {
        "title": "Ten curves", "rig": rig.name, "damper_load": f"{rig.load.pull:g} N",
        "excitation": f"blade_{rig.excitation.blade}.excitation.x", "time_convention": "exp(+iwt)",
        "channels": channels, "runs": runs,
    }  # fmt: skip
    path = out / "measurement.toml"
    path.write_text(tomlkit.dumps(table), encoding="utf-8")
    return path


def _places(branch: PredictedBranch, stuck: float) -> np.ndarray:
    """(POINTS,) along the branch, in the order of the sweep: evenly along what is seen of it, from a little above the
    stuck resonance or where the amplitude is large enough, whichever is higher, to where it is large enough last."""
    place = np.linspace(branch.place[0], branch.place[-1], 40 * len(branch.place))
    near = np.clip(np.searchsorted(branch.place, place, side="right") - 1, 0, len(branch.place) - 2)
    place = place[branch.visited[near] & branch.visited[near + 1]]
    observed = branch.at(place).value
    frequency, amplitude = np.exp(observed[:, 0]), np.exp(observed[:, 3])
    high = frequency[amplitude > _LOWEST * amplitude.max()]
    folded = not branch.visited.all()
    top = max(high.max(), _ABOVE * stuck) if folded else high.max()
    place = place[(frequency <= top) & (frequency >= high.min())]
    return np.interp(np.linspace(0, 1, POINTS), np.linspace(0, 1, len(place)), place)


def _run(
    name: str, repeat: int, force: float, branch: PredictedBranch, place: np.ndarray, b: np.ndarray, gain: np.ndarray,
    rng: np.random.Generator,
) -> Iterator[tuple[object, ...]]:  # fmt: skip
    """Rows of the file, of one assembly: to first order off the branch."""
    there = branch.at(place)
    observed = there.value + np.einsum("npm,p->nm", there.slopes[:, :-1], b)
    frequency = np.exp(observed[:, 0] + DRIFT * rng.standard_normal())
    noise = NOISE / np.sqrt(2) * (rng.standard_normal((2, POINTS, len(gain))) * [[[1]], [[1]]])
    amplitude = np.exp(observed[:, 1::2] + gain + 1j * observed[:, 2::2]) * (1 + noise[0] + 1j * noise[1])
    # to first order points next to a fold may come to lie beyond it
    onwards = frequency < np.minimum.accumulate(np.append(np.inf, frequency[:-1]))
    for f, values in zip(frequency[onwards].tolist(), amplitude[onwards], strict=True):
        yield name, repeat, "down", repr(f), "force", 1, force, 0.0
        for channel, value in zip(SENSORS, values.tolist(), strict=True):
            yield name, repeat, "down", repr(f), channel, 1, repr(value.real), repr(value.imag)


def _channel(quantity: str, point: str, unit: str) -> dict[str, str]:
    place, _, axis = point.rpartition(".")
    return {"quantity": quantity, "point": place, "direction": axis, "unit": unit, "amplitude": "peak"}


def measured(command: list[str]) -> str:
    """Run it; wall time, processor time of each process, and the largest sum of their memory: resident, and with what
    they share counted once."""
    started, seconds, resident, shared_once = time.perf_counter(), dict[int, float](), 0.0, 0.0
    environment = {k: v for k, v in os.environ.items() if k not in thread_limits(1)}
    with subprocess.Popen(command, env=environment) as process:
        root = psutil.Process(process.pid)
        while process.poll() is None:
            sums = [0.0, 0.0]
            for one in (root, *root.children(recursive=True)):
                try:
                    times, memory = one.cpu_times(), one.memory_full_info()
                except psutil.Error:  # it ended meanwhile
                    continue
                seconds[one.pid] = times.user + times.system
                sums[0] += memory.rss
                sums[1] += memory.pss if hasattr(memory, "pss") else memory.uss
            resident, shared_once = max(resident, sums[0]), max(shared_once, sums[1])
            time.sleep(0.5)
    wall, each = time.perf_counter() - started, ", ".join(f"{s:.0f}" for s in seconds.values() if s > 1)
    return (
        f"{wall:.0f} s on the clock, {sum(seconds.values()):.0f} s of processor time ({each}), memory "
        f"{resident / 1e9:.2f} GB resident, {shared_once / 1e9:.2f} GB with what is shared counted once, "
        f"load of the machine {os.getloadavg()[0]:.1f}, exit code {process.returncode}"
    )


def main(
    mesh: Annotated[str, typer.Option(help="preset of the rig file")] = "small",
    out: Annotated[Path, typer.Option(help="folder; that of a run, to use its model")] = HERE / "results/ten_curves",
    jobs: Annotated[int, typer.Option(min=1)] = 2,
) -> None:
    """Make the measurement where it is not there yet, then compare and measure that."""
    keep_compiled()
    out.mkdir(parents=True, exist_ok=True)
    path = out / "measurement.toml"
    if not path.is_file():
        make(load_rig(RIG), mesh, out)
    command = [sys.executable, "-m", "updamp.pipeline", "compare", str(RIG), str(path), "--mesh", mesh]
    print(measured([*command, "--out", str(out), "--jobs", str(jobs)]))


if __name__ == "__main__":
    typer.run(main)
