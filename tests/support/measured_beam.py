"""A beam of two modes with quadratic damping at the drive point that its rig file does not have, as files.

The response is that of the describing function: first harmonic alone, no code of updamp.
"""

from pathlib import Path

import numpy as np
from numpy.typing import NDArray

DAMPING = 15.0  # N s^2/m^2
MODES = {"first": (80.0, 0.004, 1.0), "second": (140.0, 0.004, 0.8)}  # Hz, loss factor, drive point's share
LEVELS = (1.0, 4.0)  # N
MASS = 2.0  # kg

RIG = """
kind = "modal"
name = "beam"
excitation = "beam.drive.x"
""" + "".join(
    f"""
[modes.{name}]
frequency = "{frequency} Hz"
loss_factor = {eta}
modal_mass = "{MASS} kg"
shape = {{ "beam.drive.x" = {share} }}
"""
    for name, (frequency, eta, share) in MODES.items()
)
MEASUREMENT = """
title = "Beam"
rig = "beam"
damper_load = "0 N"
excitation = "beam.drive.x"

[channels]
force = { point = "beam.drive", direction = "x", quantity = "force", unit = "N", amplitude = "peak" }
laser = { point = "beam.drive", direction = "x", quantity = "displacement", unit = "m", amplitude = "peak" }
"""
# The same damping by another name: an effect of one's own that no data tell from the catalogue's.
TWIN = """
from dataclasses import replace

from updamp.effects.catalogue import JOINTS
from updamp.effects.effect import Effect, EffectParameter


def apply(model, values):
    return JOINTS["joint_quadratic"].apply(model, {"coefficient": 2 * values["half"]})


EFFECT = Effect("drag", "the air drags", (EffectParameter("half", 0.0, 0.0, 5e3, 20.0, "", "test"),), apply)
"""


def write(folder: Path, repeats: int = 2, points: int = 24, noise: float = 0.003) -> tuple[Path, Path]:
    """beam.toml, measurement.toml and sweep.csv; returns: the first two"""
    rng, lines, runs = np.random.default_rng(4), ["run,repeat,sweep,frequency_Hz,channel,harmonic,real,imag"], []
    for repeat in range(1, repeats + 1):
        drawn = 1 + np.array([1e-4, 0.02]) * rng.standard_normal(2)
        for mode, (resonance, *_) in MODES.items():
            frequency = resonance * (1 + 0.02 * np.linspace(-1, 1, points))
            for level in LEVELS:
                x = response(frequency, level, *drawn)
                x *= 1 + noise / np.sqrt(2) * (rng.standard_normal(points) + 1j * rng.standard_normal(points))
                name = f"{mode} {level:g} N"
                for f, y in zip(frequency.tolist(), x.tolist(), strict=True):
                    lines.append(f"{name},{repeat},up,{f!r},force,1,{level},0.0")
                    lines.append(f"{name},{repeat},up,{f!r},laser,1,{y.real!r},{y.imag!r}")
                runs.append(
                    f'\n[[runs]]\nname = "{name}"\nmode = "{mode}"\nfile = "sweep.csv"\nsweep = "up"\n'
                    f'held = "force"\nlevel = "{level} N"\nrepeat = {repeat}\n'
                )
    folder.mkdir(parents=True, exist_ok=True)
    (folder / "sweep.csv").write_text("\n".join(lines) + "\n", encoding="utf-8")
    (folder / "measurement.toml").write_text(MEASUREMENT + "".join(runs), encoding="utf-8")
    (folder / "beam.toml").write_text(RIG, encoding="utf-8")
    return folder / "beam.toml", folder / "measurement.toml"


def response(frequency: NDArray[np.float64], level: float, tuned: float, loss: float) -> NDArray[np.complex128]:
    """(n,) displacement [m]; tuned, loss: factors on the frequencies and loss factors of the modes

    The force of c |v| v has the first harmonic 8/(3 pi) c |v|^2 (A. H. Nayfeh and D. T. Mook, Nonlinear Oscillations,
    1979): the amplitude follows from one real equation, solved by bisection.
    """
    w = 2 * np.pi * frequency
    receptance = sum(
        share**2 / (MASS * ((2 * np.pi * f * tuned) ** 2 * (1 + 1j * eta * loss) - w**2))
        for f, eta, share in MODES.values()
    )
    low, high = np.zeros_like(w), level * np.abs(receptance)
    for _ in range(60):
        size = (low + high) / 2
        x = level / (1 / receptance + 1j * 8 / (3 * np.pi) * DAMPING * w**2 * size)
        low, high = np.where(np.abs(x) > size, size, low), np.where(np.abs(x) > size, high, size)
    return np.asarray(x)
