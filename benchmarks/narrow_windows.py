"""Runs of few points, from half to four half-widths to either side of the resonance, on a rig that jumps: whether a
true model is left alone, and whether calibration finds its parameters.

.venv/bin/python benchmarks/narrow_windows.py [--draws 20] [--first-seed N] [--out FOLDER]

The runs are those of a model with a finer mesh, more harmonics and time samples than the one that is calibrated, with
parameters that are half a prior deviation off, sensors' noise of 0.2 to 1 %, gains that are 1 % off. Nothing is hidden.
Everything is drawn from the seed: modes, levels, directions, windows, points.
"""

from updamp.parallel.resources import one_thread

one_thread()  # before numpy is loaded: threads make small products many times slower

import time
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Annotated

import numpy as np
import typer
from numpy.typing import NDArray
from rich.console import Console

from updamp.comparison.compare import calibrate, comparison_of
from updamp.comparison.fit.numerical_patterns import with_unwrapped_phases
from updamp.comparison.prediction.parameters import Parametrisation
from updamp.comparison.prediction.predicted_branch import PredictedBranch
from updamp.comparison.prediction.run_condition import RunCondition
from updamp.comparison.prediction.traced_branch import trace_branch
from updamp.effects.rig_model import RigModel
from updamp.hbm.compilation_cache import keep_compiled
from updamp.hbm.harmonics import Harmonics
from updamp.measurement.measurement import Channel, MeasuredRun, Measurement
from updamp.model.calibration import nuisances
from updamp.model.rig_files import load_rig
from updamp.workflow.built_rig import built_rig
from updamp.workflow.progress import Display

Floats = NDArray[np.float64]

RIG = Path(__file__).parents[1] / "rigs" / "virtual_rig_jumping.toml"
FITTED, FINER = "diagnosis", "diagnosis_fine"
ORDERS, SAMPLES = (1, 2, 3, 4, 5), 256  # of the rig measured
LEVELS = {"IP": (2.0, 4.0, 8.0, 17.0), "OOP": (4.0, 8.0, 17.0, 34.0)}  # [N]
CHANNELS = (Channel("left", "blade_left.tip.x"), Channel("right", "blade_right.tip.x"))
OFF = 0.5  # prior deviations of the parameters
GAIN = 0.01
_DENSELY = 6000  # places on a branch
_JUMP = 0.1  # of the logarithm of the amplitude from one of these to the next


@dataclass(frozen=True, eq=False)
class Rigs:
    """measured, fitted: models before calibration; windows: mode -> where its resonances are looked for [Hz]"""

    measured: RigModel
    fitted: RigModel
    finer: RigModel
    windows: dict[str, tuple[float, float]]

    @classmethod
    def built(cls, out: Path) -> "Rigs":
        rig = load_rig(RIG)
        with Display() as display:
            fitted, finer = (built_rig(rig, preset, out / preset, 1, display).model for preset in (FITTED, FINER))
        return cls(replace(finer, harmonics=Harmonics(ORDERS), time_samples=SAMPLES), fitted, finer, rig.windows)


def measured(rigs: Rigs, seed: int) -> tuple[Measurement, Floats]:
    """And the logarithms of the true parameters' factors."""
    rng = np.random.default_rng(seed)
    p = Parametrisation(rigs.measured, nuisances(rigs.measured))
    deviation = np.array([n.deviation for n in p.nuisances])
    true = np.clip(OFF * deviation * rng.standard_normal(len(deviation)), p.lower, p.upper)
    noise, gains = 10 ** rng.uniform(-2.7, -2.0), 1 + GAIN * rng.standard_normal(len(CHANNELS))
    runs = []
    for mode, levels in LEVELS.items():
        for force in sorted(rng.choice(levels, size=rng.integers(1, 4), replace=False)):
            upwards, points = bool(rng.integers(2)), int(rng.integers(10, 41))
            name = f"{mode} {force:g} N {'up' if upwards else 'down'}"
            sensors = tuple((c.point, 1) for c in CHANNELS)
            window = rigs.windows[mode]
            condition = RunCondition(name, mode, float(force), upwards, window, sensors, noise=(2e-6, *4 * (2e-3,)))
            frequency, response = _swept(trace_branch(p, true, condition), rng.uniform(0.5, 4.0, 2), points)
            z = rng.standard_normal((2, *response.shape))
            response = gains[:, None] * response * (1 + noise * (z[0] + 1j * z[1]))
            runs.append(_run(condition, frequency, response))
    return Measurement(f"seed {seed}", 960.0, rigs.measured.excitation, CHANNELS, tuple(runs)), true


def _run(condition: RunCondition, frequency: Floats, response: NDArray[np.complex128]) -> MeasuredRun:
    names, force = tuple(c.name for c in CHANNELS), np.full(len(frequency), condition.force + 0j)
    c = condition
    return MeasuredRun(
        c.name, c.mode, c.upwards, "force", c.force, 1, names, (1,), frequency, force, response[:, None, :]
    )


def _swept(branch: PredictedBranch, reach: Floats, points: int) -> tuple[Floats, NDArray[np.complex128]]:
    """(n,) [Hz] and (n_sensors, n) [m], in the order of the sweep. reach: to either side of the highest point, in
    half-widths; no point lies between both sides of a jump."""
    f, value = _visited(branch)
    log_size = value[:, 1]
    top = int(np.argmax(log_size))
    half_width = np.ptp(f[log_size > log_size[top] - np.log(2) / 2]) / 2
    wanted = np.linspace(*np.clip(f[top] + half_width * reach * (-1, 1), f[0], f[-1]), points)
    rise = np.abs(np.diff(log_size))
    for jump in np.flatnonzero(rise > _JUMP):
        wanted = wanted[(wanted <= f[jump]) | (wanted >= f[jump + 1])]
    parts = [np.interp(wanted, f, column) for column in with_unwrapped_phases(value).T[1:]]
    response = np.array([np.exp(parts[i] + 1j * parts[i + 1]) for i in range(0, len(parts), 2)])
    order = slice(None) if branch.condition.upwards else slice(None, None, -1)
    return wanted[order], response[:, order]


def _visited(branch: PredictedBranch) -> tuple[Floats, Floats]:
    """What the sweep sees inside its window, by rising frequency."""
    value = branch.at(branch.seen_places(_DENSELY)).value
    value = value[np.argsort(value[:, 0])]
    low, high = branch.condition.window
    f = np.exp(value[:, 0])
    return f[(f >= low) & (f <= high)], value[(f >= low) & (f <= high)]


@dataclass(frozen=True, eq=False)
class Result:
    """off: of the parameters from the truth, in their stated deviations"""

    seed: int
    misfit: float
    sentences: tuple[str, ...]
    off: Floats
    seconds: float

    @property
    def line(self) -> str:
        off = " ".join(f"{z:+.1f}" for z in self.off)
        said = "; ".join(self.sentences) or "no misfit"
        return f"| {self.seed} | {self.misfit:.2f} | {off} | {said} | {self.seconds:.0f} |"


def compared(rigs: Rigs, seed: int) -> Result:
    measurement, true = measured(rigs, seed)
    started = time.perf_counter()
    found = calibrate(rigs.fitted, measurement, finer={FINER: rigs.finer})
    sentences = tuple(finding.text for finding in comparison_of(found, measurement).findings)
    off = (found.fit.u[: len(true)] - true) / found.fit.uncertainty[: len(true)]
    return Result(seed, found.fit.compared.mean_squared_misfit, sentences, off, time.perf_counter() - started)


def lines(names: Sequence[str], results: Sequence[Result]) -> Iterator[str]:
    """Tables in Markdown."""
    yield f"| seed | mean squared misfit | {', '.join(names)}: deviations off | said | s |"
    yield "|---|---|---|---|---|"
    yield from (one.line for one in results)
    off = np.abs([one.off for one in results])
    inside = ", ".join(f"{name} {np.sum(z < 1.96)}" for name, z in zip(names, off.T, strict=True))
    quiet, seconds = sum(not one.sentences for one in results), np.median([one.seconds for one in results])
    yield f"\nOf {len(results)}: {quiet} without a misfit; 95 % intervals hold {inside}"
    yield f"({100 * np.mean(off < 1.96):.0f} % of all, {100 * np.mean(off < 3):.0f} % within 3 deviations)"
    yield f"Median {seconds:.0f} s"


def main(
    draws: Annotated[int, typer.Option(min=1)] = 20,
    first_seed: Annotated[int, typer.Option(help="one that nobody has looked at yet")] = 1,
    out: Annotated[Path, typer.Option(help="folder for the models")] = Path("results/narrow_windows"),
) -> None:
    keep_compiled()
    rigs, results = Rigs.built(out), []
    for seed in range(first_seed, first_seed + draws):
        results.append(compared(rigs, seed))
        Console(stderr=True).print(results[-1].line, highlight=False)
    typer.echo("\n".join(lines([n.name for n in nuisances(rigs.fitted)], results)))


if __name__ == "__main__":
    typer.run(main)
