"""Runs on the bench: a quick sweep finds the resonance, a stepped sine about it is what is recorded."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from types import MappingProxyType

import numpy as np
from numpy.typing import NDArray

from updamp.benchmarks.virtual_rig import hidden_in_contact, hidden_in_dimensions, hidden_in_structure, hidden_outside
from updamp.benchmarks.virtual_rig.assembled import Assembled, assembled
from updamp.benchmarks.virtual_rig.bench import BODIES, Bench, Hidden, HiddenEffect
from updamp.benchmarks.virtual_rig.periodic import NotSolvedError, SolverOptions
from updamp.benchmarks.virtual_rig.plan import NoiseLevels, PlannedRun, TestPlan
from updamp.benchmarks.virtual_rig.sensors import Recorded, recorded
from updamp.benchmarks.virtual_rig.stepped_sine import StepMotor
from updamp.rig.rig import Rig

# All effects that can be hidden, by name.

HIDDEN: Mapping[str, HiddenEffect] = MappingProxyType(
    {
        effect.name: effect
        for module in (hidden_in_dimensions, hidden_in_structure, hidden_in_contact, hidden_outside)
        for effect in module.EFFECTS
    }
)


def hidden(name: str, strength: str) -> Hidden:
    """raises: ValueError naming what there is"""
    if name not in HIDDEN:
        raise ValueError(f"no effect '{name}' can be hidden; there are {', '.join(HIDDEN)}")
    if strength not in HIDDEN[name].strengths:
        raise ValueError(f"strength '{strength}' of '{name}': one of {', '.join(HIDDEN[name].strengths)} is wanted")
    return Hidden(name, HIDDEN[name].strengths[strength], strength)


def with_hidden(bench: Bench, effects: Sequence[Hidden], rig: Rig) -> Bench:
    """In the order of the registry, so that what is scaled and what is set does not depend on the order of naming."""
    for name, effect in HIDDEN.items():
        for one in effects:
            if one.name == name:
                bench = effect.apply(bench, one.values, rig)
    return bench


Floats = NDArray[np.float64]

QUICK = SolverOptions(harmonics=3, n_time=128, tolerance=1e-5)
# Of the quick sweep, from above the stuck resonance down: the window about it, relative, and steps.
ABOVE, BELOW, STEPS = 0.02, 0.08, 120


@dataclass(frozen=True)
class AssemblyDraw:
    """Factors of one assembly."""

    friction: float
    tangential: float
    normal: float
    preload: float
    youngs_modulus: float
    gains: Mapping[str, float]


@dataclass(frozen=True)
class RunRecord:
    """What happened in a run. drift: relative, at its start and end; phase: of the amplifier [rad]; resonance [Hz] and
    half-widths to its left and right [Hz], as the quick sweep showed them; lost: frequencies without a settled motion;
    jumps: frequencies [Hz] after which the response leapt"""

    name: str
    repeat: int
    drift: tuple[float, float]
    phase: float
    resonance: float
    half_widths: tuple[float, float]
    lost: tuple[float, ...]
    jumps: tuple[float, ...]


def draw_assembly(rng: np.random.Generator, noise: NoiseLevels, channels: Mapping[str, str]) -> AssemblyDraw:
    """Lognormal factors."""
    kinds = (noise.friction, noise.tangential, noise.normal, noise.preload, noise.youngs_modulus)
    factors = [float(np.exp(deviation * rng.standard_normal())) for deviation in kinds]
    return AssemblyDraw(*factors, {name: float(np.exp(noise.gain * rng.standard_normal())) for name in channels})


def put_together(bench: Bench, draw: AssemblyDraw, hidden: tuple[Hidden, ...], rig: Rig) -> Bench:
    """The bench of one assembly; what is hidden comes last, so that it sees the forces of this assembly."""
    p = bench.patches
    scattered = bench.with_patches(
        mu=p.mu * draw.friction, kt=p.kt * draw.tangential, kn=p.kn * draw.normal, n0=p.n0 * draw.preload
    )
    stiffer = scattered.tuned(**dict.fromkeys(BODIES, np.sqrt(draw.youngs_modulus)))
    return with_hidden(stiffer, hidden, rig)


def windows(rig: Assembled) -> dict[str, tuple[float, float]]:
    """(lower, upper) of each mode [Hz]: the two lowest stuck modes, in-phase below."""
    ip, oop = rig.stuck_frequencies(2)
    between = (ip + oop) / 2
    return {"IP": (ip * (1 - BELOW), between), "OOP": (max(between, oop * (1 - BELOW)), oop * (1 + ABOVE))}


def quick_sweep(rig: Assembled, run: PlannedRun) -> tuple[float, tuple[float, float]]:
    """Resonance and half-widths to the left and right of it, at 1/sqrt(2) of the peak [Hz]."""
    low, high = windows(rig)[run.mode]
    motor, points = StepMotor(rig, QUICK), []
    frequencies = np.linspace(high, low, STEPS)
    for frequency in frequencies[::-1] if run.upwards else frequencies:
        try:
            tips = motor.step(float(frequency), run.force).tips
        except NotSolvedError:
            continue
        points.append((frequency, sum(tips.values())))
    f, size = np.array(sorted(points)).T
    top = int(size.argmax())
    half = size[top] / np.sqrt(2)
    left, right = f[: top + 1][size[: top + 1] < half], f[top:][size[top:] < half]
    step = (high - low) / STEPS
    widths = (f[top] - left[-1] if len(left) else step, right[0] - f[top] if len(right) else step)
    least = 0.4 * rig.bench.loss_factor * f[top]
    return float(f[top]), (float(max(widths[0], least)), float(max(widths[1], least)))


def grid(resonance: float, half_widths: tuple[float, float], plan: TestPlan, window: tuple[float, float]) -> Floats:
    """(points,) ascending [Hz], denser about the resonance."""
    left, right = half_widths
    low, high = max(resonance - plan.reach * left, window[0]), min(resonance + plan.reach * right, window[1])
    s = np.linspace(-1, 1, plan.points)
    shape = np.sinh(1.5 * s) / np.sinh(1.5)
    return np.where(s < 0, resonance + shape * (resonance - low), resonance + shape * (high - resonance))


def measured(
    bench: Bench,
    run: PlannedRun,
    repeat: int,
    drift: tuple[float, float],
    draw: AssemblyDraw,
    plan: TestPlan,
    noise: NoiseLevels,
    rng: np.random.Generator,
    options: SolverOptions,
) -> tuple[Recorded, RunRecord]:
    """One run on one assembly."""
    rig = assembled(bench.tuned(**dict.fromkeys(BODIES, 1 + drift[0])))
    resonance, half_widths = quick_sweep(rig, run)
    window = windows(rig)[run.mode]
    frequencies = grid(resonance, half_widths, plan, (window[0] * 0.99, window[1] * 1.01))
    frequencies = frequencies if run.upwards else frequencies[::-1]
    # Going on within the run is the same as moving the frequencies the other way.
    moved = frequencies / (1 + (drift[1] - drift[0]) * np.linspace(0, 1, len(frequencies)))
    forces = run.force * (1 + noise.force_control * rng.standard_normal(len(frequencies)))
    motor, kept, lost, response = StepMotor(rig, options), [], [], []
    for i, (frequency, force) in enumerate(zip(moved, forces, strict=True)):
        try:
            motion = motor.step(float(frequency), float(force))
        except NotSolvedError:
            lost.append(float(frequencies[i]))
            continue
        kept.append(i)
        response.append([motion.response(point) for point in plan.channels.values()])
    phase = float(rng.uniform(-np.pi, np.pi))
    exact = np.array(response).transpose(1, 2, 0)
    record = RunRecord(
        run.name, repeat, drift, phase, resonance, half_widths, tuple(lost), jumps(frequencies[kept], exact[0, 0])
    )
    return recorded(
        run, repeat, frequencies[kept], forces[kept], exact, phase, draw.gains, bench, plan, noise, rng
    ), record


def jumps(frequencies: Floats, response: NDArray[np.complex128]) -> tuple[float, ...]:
    """Frequencies after which log(response) changes by more than 0.5 and five times as much as beside it."""
    change = np.abs(np.diff(np.log(np.abs(response))))
    beside = np.minimum(np.append(change[1:], np.inf), np.insert(change[:-1], 0, np.inf))
    return tuple(frequencies[:-1][(change > 0.5) & (change > 5 * beside)].tolist())
