"""Tests of a beam's first bending with the acceleration held, as of the Brake-Reuss beam, and its linear model."""

from pathlib import Path

import numpy as np

from updamp.comparison.compare import compare
from updamp.comparison.comparison import Comparison
from updamp.measurement.measurement import Channel, MeasuredRun, Measurement
from updamp.model.build import modal_model
from updamp.model.rig_files import load_modal

RIG = Path(__file__).parents[2] / "rigs" / "brake_reuss.toml"
MODE = "first bending"
LEVELS = (5.0, 30.0, 80.0)


def held_beam(frequencies: tuple[float, ...], loss_factors: tuple[float, ...]) -> Measurement:
    """Acceleration held, so that the force drops at resonance; both with noise of 0.1 %. Modal mass 2 kg."""
    rng = np.random.default_rng(3)
    runs = []
    for level, f0, eta in zip(LEVELS, frequencies, loss_factors, strict=True):
        f = np.linspace(79.0, 81.4, 49)
        w, w0 = 2 * np.pi * f, 2 * np.pi * f0
        x = level / w**2 * np.exp(0.4j) * (1 + 1e-4 * rng.standard_normal(len(f)))
        noise = 1e-3 / np.sqrt(2) * (rng.standard_normal((2, len(f))) * [[1], [1j]]).sum(axis=0)
        force = x * 2.0 * (w0**2 * (1 + 1j * eta) - w**2) * (1 + noise)
        runs.append(
            MeasuredRun(
                f"{level:g} m/s2", MODE, True, "response", level, 1, ("a",), (1,), f, force, x[None, None],
                level_unit="m/s^2",
            )
        )  # fmt: skip
    return Measurement("Beam", 0.0, "beam.drive.x", (Channel("a", "beam.drive.x"),), tuple(runs))


def of_beam(measurement: Measurement, rig: Path = RIG) -> Comparison:
    return compare(modal_model(load_modal(rig)), measurement)[0]
