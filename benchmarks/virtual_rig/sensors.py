"""From the exact motion to what the sensors say and the files hold."""

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from updamp.benchmarks.virtual_rig.bench import Bench
from updamp.benchmarks.virtual_rig.plan import NoiseLevels, PlannedRun, TestPlan

Floats = NDArray[np.float64]
Complex = NDArray[np.complex128]

LOOSE, LOOSE_AT = "tip_left", 1e-5  # m, where half of the loss of gain is reached


@dataclass(frozen=True, eq=False)
class Recorded:
    """frequency: (n,) in the order of the sweep [Hz]; force: (n,) [N]; response: channel -> (n_harmonics, n) [m]"""

    run: PlannedRun
    repeat: int
    frequency: Floats
    force: Complex
    response: Mapping[str, Complex]


def recorded(
    run: PlannedRun,
    repeat: int,
    frequency: Floats,
    force: Floats,
    exact: Complex,
    phase: float,
    gains: Mapping[str, float],
    bench: Bench,
    plan: TestPlan,
    noise: NoiseLevels,
    rng: np.random.Generator,
) -> Recorded:
    """exact: (n_channels, n_harmonics of the solver, n) under a force of phase 0; phase: of the amplifier [rad]"""
    turn = np.exp(1j * phase)
    response = {}
    for name, motion in zip(plan.channels, exact, strict=True):
        true = np.array([motion[k - 1] * turn**k for k in plan.harmonics])
        reading = gains[name] * loose(true, bench.loose_gain if name == LOOSE else 0.0)
        response[name] = reading + np.hypot(noise.relative * np.abs(reading), noise.floor) * complex_normal(
            rng, true.shape
        )
    reading = force * turn * (1 + noise.force_reading * complex_normal(rng, force.shape))
    return Recorded(run, repeat, frequency, reading, response)


def loose(motion: Complex, loss: float) -> Complex:
    """A sensor that comes loose: its gain falls by `loss` A / (A + LOOSE_AT), A the first harmonic's amplitude."""
    size = np.abs(motion[0])
    return motion * (1 - loss * size / (size + LOOSE_AT))


def complex_normal(rng: np.random.Generator, shape: tuple[int, ...]) -> Complex:
    """Real and imaginary part of unit standard deviation each."""
    return rng.standard_normal(shape) + 1j * rng.standard_normal(shape)
