"""A measured resonator: what is drawn, and the files that a test would leave of it.

Everything is drawn from one seed: the resonator, what it meets besides, the levels, directions, points and repeats of
the test, noise, and faults of the measurement. The rig file states mass, frequency and loss as they would be known
beforehand.
"""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from updamp.benchmarks.measured_resonators.laws import LAWS, Complex, Floats, Scale
from updamp.benchmarks.measured_resonators.resonator import Resonator

# Name -> what the catalogue calls it.
FAULTS = {"phase": "phase_lag", "background": "feed_through", "trend": "amplifier_drift"}
# Deviations of what the rig file states, as shares.
_MASS, _LOSS = 0.03, 0.08
# Of the drift of a resonance from run to run, as a share of its width.
_DRIFT = 0.004


@dataclass(frozen=True)
class Fault:
    """What is read of a receptance. lag [rad]; background [m/N]; trend: of the reading's logarithm over a sweep"""

    lag: float = 0.0
    background: complex = 0.0
    trend: float = 0.0

    def read(self, receptance: Complex) -> Complex:
        passed = np.linspace(0.0, 1.0, len(receptance))
        return np.asarray((receptance * np.exp(-1j * self.lag) + self.background) * np.exp(self.trend * passed))


@dataclass(frozen=True)
class TestPlan:
    """levels: forces [N], rising; noise: of readings, relative, of real and imaginary part; stated: repeatability;
    drift: of a resonance from run to run, relative"""

    levels: tuple[float, ...]
    directions: tuple[str, ...]
    repeats: int
    points: int
    noise: float
    stated: float
    drift: float


@dataclass(frozen=True)
class Run:
    name: str
    repeat: int
    direction: str
    force: float
    frequency: Floats
    receptance: Complex


def measure(seed: int, hidden: Sequence[str], folder: Path) -> None:
    """Rig file, data and measurement.toml of a resonator with what is hidden in it; hidden: names of LAWS and FAULTS"""
    rng = np.random.default_rng(seed)
    linear = Resonator(_log(rng, 0.01, 20.0), _log(rng, 40.0, 2000.0), _log(rng, 0.002, 0.02), ())
    amplitude, width = _log(rng, 1e-5, 2e-4), linear.stiffness * linear.loss
    plan = _plan(rng, amplitude * width, linear.loss)
    scale = Scale(width, 2 * np.pi * linear.frequency, amplitude, plan.levels[0])
    laws = [LAWS[name].draw(rng, scale) for name in hidden if name in LAWS]
    resonator = Resonator(linear.mass, linear.frequency, linear.loss, laws)
    runs = list(_runs(rng, resonator, plan, _fault(rng, hidden, 1 / width)))
    folder.mkdir(parents=True, exist_ok=True)
    (folder / "rig.toml").write_text(_rig_file(rng, linear, plan.drift), encoding="utf-8")
    (folder / "data.csv").write_text(_csv(runs), encoding="utf-8")
    (folder / "measurement.toml").write_text(_measurement(plan, runs), encoding="utf-8")


def _log(rng: np.random.Generator, low: float, high: float) -> float:
    return float(np.exp(rng.uniform(np.log(low), np.log(high))))


def _plan(rng: np.random.Generator, highest: float, loss: float) -> TestPlan:
    ratio, levels = _log(rng, 2.5, 5.0), int(rng.integers(2, 5))
    noise = _log(rng, 0.004, 0.015)
    directions = [("up",), ("down",), ("up", "down")][int(rng.integers(3))]
    return TestPlan(
        tuple(highest * ratio**-i for i in reversed(range(levels))),
        directions,
        int(rng.choice([1, 1, 2])),
        int(rng.integers(25, 60)),
        noise,
        max(float(rng.choice([0.01, 0.02, 0.03])), noise),
        _DRIFT * loss,
    )


def _fault(rng: np.random.Generator, hidden: Sequence[str], peak: float) -> Fault:
    """peak: receptance of the linear resonator [m/N]"""
    lag, background, trend = rng.uniform(0.05, 0.25), rng.uniform(0.04, 0.15) * peak, rng.uniform(0.04, 0.15)
    turned, sign = np.exp(2j * np.pi * rng.uniform()), rng.choice([-1.0, 1.0])
    return Fault(
        float(sign * lag) if "phase" in hidden else 0.0,
        complex(background * turned) if "background" in hidden else 0.0,
        float(sign * trend) if "trend" in hidden else 0.0,
    )


def _runs(rng: np.random.Generator, resonator: Resonator, plan: TestPlan, fault: Fault) -> Iterator[Run]:
    """From some widths below the resonances of small and of this motion to some above them."""
    beyond, width = rng.uniform(2.5, 4.0, 2), resonator.loss * resonator.frequency
    for repeat in range(1, plan.repeats + 1):
        for i, force in enumerate(plan.levels):
            peaks = resonator.frequency, resonator.peak(force)
            passed = np.linspace(min(peaks) - beyond[0] * width, max(peaks) + beyond[1] * width, plan.points)
            for direction in plan.directions:
                frequency = passed if direction == "up" else passed[::-1]
                shift = np.exp(plan.drift * rng.standard_normal())
                there = Resonator(resonator.mass, resonator.frequency * shift, resonator.loss, resonator.laws)
                read = fault.read(there.sweep(frequency, force))
                off = rng.standard_normal(len(read)) + 1j * rng.standard_normal(len(read))
                yield Run(
                    f"{'abcd'[i]} {direction}", repeat, direction, force, frequency, read * (1 + plan.noise * off)
                )


def _rig_file(rng: np.random.Generator, linear: Resonator, drift: float) -> str:
    off = rng.standard_normal(3)
    return f"""kind = "modal"
name = "resonator"
excitation = "beam.end.x"

[modes.first]
frequency = "{linear.frequency * np.exp(drift * off[0]):.9g} Hz"
loss_factor = {linear.loss * np.exp(_LOSS * off[1]):.5g}
modal_mass = "{linear.mass * np.exp(_MASS * off[2]):.6g} kg"
shape = {{ "beam.end.x" = 1.0 }}
"""


def _csv(runs: Sequence[Run]) -> str:
    lines = ["run,repeat,sweep,frequency_Hz,channel,harmonic,real,imag"]
    for run in runs:
        for frequency, h in zip(run.frequency, run.receptance, strict=True):
            x, beginning = h * run.force, f"{run.name},{run.repeat},{run.direction},{frequency:.9g}"
            lines.append(f"{beginning},force,1,{run.force:.9g},0")
            lines.append(f"{beginning},response,1,{x.real:.9g},{x.imag:.9g}")
    return "\n".join(lines) + "\n"


def _measurement(plan: TestPlan, runs: Sequence[Run]) -> str:
    """What repeats tell is not stated."""
    alone = f"repeatability = {plan.stated}\nfrequency_drift = {plan.drift:.3g}\n" if plan.repeats == 1 else ""
    channel = 'point = "beam.end"\ndirection = "x"\namplitude = "peak"\n'
    head = f"""title = "Resonator"
rig = "resonator"
damper_load = "0 N"
excitation = "beam.end.x"
time_convention = "exp(+iwt)"
{alone}
[channels.force]
quantity = "force"
unit = "N"
{channel}
[channels.response]
quantity = "displacement"
unit = "m"
{channel}
[run_defaults]
mode = "first"
file = "data.csv"
held = "force"
"""
    return head + "".join(
        f"""
[[runs]]
name = "{run.name}{f" {run.repeat}" if plan.repeats > 1 else ""}"
run = "{run.name}"
repeat = {run.repeat}
sweep = "{run.direction}"
level = "{run.force:.6g} N"
"""
        for run in runs
    )
