"""An oscillator of one degree of freedom as a laboratory would record it."""

import numpy as np
from numpy.typing import NDArray

from updamp.measurement.recorded import RecordedChannel, RecordedSweep

STANDARD_GRAVITY = 9.80665
RESONANCE, LOSS_FACTOR, MASS = 430.0, 0.004, 0.8
FREQUENCY = 428.0 + 0.1 * np.arange(41) + 0.01 * np.sin(np.arange(41))

TOML = """
title = "Oscillator"
rig = "oscillator"
damper_load = "960 N"
excitation = "mass.drive.x"
time_convention = "exp(+iwt)"

[channels.force]
quantity = "force"
point = "mass.drive"
direction = "x"
unit = "N"
amplitude = "peak"

[channels.laser]
quantity = "velocity"
point = "mass.tip"
direction = "-x"
unit = "mm/s"
amplitude = "rms"

[channels.accelerometer]
quantity = "acceleration"
point = "mass.drive"
direction = "x"
unit = "g_0"
amplitude = "peak"

[[runs]]
name = "B 17 N"
mode = "B"
file = "data.csv"
sweep = "up"
held = "force"
level = "17 N"
"""


def force(repeat: int = 1) -> NDArray[np.complex128]:
    """Near 17 N, dropping at resonance. [N]"""
    return (17 - 1.5 / (1 + ((FREQUENCY - RESONANCE) / 0.8) ** 2)) * np.exp(1j * (0.3 + 0.1 * repeat))


def displacement(repeat: int = 1) -> NDArray[np.complex128]:
    """(2, n) harmonics 1 and 3 [m]"""
    w, w0 = 2 * np.pi * FREQUENCY, 2 * np.pi * (RESONANCE + 0.02 * repeat)
    first = force(repeat) / (MASS * (w0**2 * (1 + 1j * LOSS_FACTOR) - w**2))
    return np.array([first, 0.01 * first * np.exp(0.4j)])


def recorded(repeat: int | None = 1, run: str = "B 17 N", sweep: str = "up") -> RecordedSweep:
    """In the units and signs of TOML."""
    x, f = displacement(repeat or 1), force(repeat or 1)
    w = 2 * np.pi * FREQUENCY * np.array([[1], [3]])
    channels = {
        "force": RecordedChannel(f[None], (1,), unit="N", quantity="force"),
        "laser": RecordedChannel(-1j * w * x * 1e3 / np.sqrt(2), (1, 3), unit="mm/s", quantity="velocity"),
        "accelerometer": RecordedChannel(
            -(w**2) * x / STANDARD_GRAVITY, (1, 3), unit="g", quantity="acceleration", direction="+X"
        ),
    }
    return RecordedSweep(run, repeat, sweep, FREQUENCY, channels)
