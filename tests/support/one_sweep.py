"""One sweep of the linear beam of rigs/brake_reuss.toml, with noise of 0.5 %, as files."""

from collections.abc import Callable
from pathlib import Path

import numpy as np

from updamp.measurement.readers.long_csv import write_long_csv
from updamp.measurement.recorded import RecordedChannel, RecordedSweep

BEAM = """
title = "Beam"
rig = "brake_reuss"
damper_load = "0 N"
excitation = "beam.drive.x"

[channels.force]
point = "beam.drive"
direction = "x"
quantity = "force"
unit = "N"
amplitude = "peak"

[channels.sensor]
point = "beam.drive"
direction = "x"
quantity = "{quantity}"
unit = "{unit}"
amplitude = "peak"

[[runs]]
name = "low"
mode = "first bending"
file = "sweep.csv"
sweep = "up"
held = "force"
level = "1 N"
repeat = 1
"""
RESONANCE, LOSS_FACTOR, MASS = 2 * np.pi * 80.38, 0.0031, 2.0  # of rigs/brake_reuss.toml


def sweep_of_beam(
    folder: Path,
    quantity: str = "velocity",
    unit: str = "m/s",
    factor: complex = 1.0,
    frequency: Callable[[np.ndarray], np.ndarray] = lambda f: f,
    points: int = 41,
) -> Path:
    """A sweep of the beam that the rig file describes, response times the factor, as seen with other frequencies."""
    rng = np.random.default_rng(0)
    f = np.linspace(79.6, 81.2, points)
    w = 2 * np.pi * f
    x = 1 / (MASS * (RESONANCE**2 * (1 + 1j * LOSS_FACTOR) - w**2))
    x = x * (1 + 0.005 / np.sqrt(2) * (rng.standard_normal(points) + 1j * rng.standard_normal(points)))
    sort = {"displacement": 0, "velocity": 1, "acceleration": 2}[quantity]
    channels = {
        "force": RecordedChannel(np.ones((1, points), complex)),
        "sensor": RecordedChannel((x * (1j * w) ** sort * factor)[None]),
    }
    write_long_csv(folder / "sweep.csv", [RecordedSweep("low", 1, "up", frequency(f), channels)])
    (folder / "measurement.toml").write_text(BEAM.format(quantity=quantity, unit=unit), encoding="utf-8")
    return folder / "measurement.toml"
