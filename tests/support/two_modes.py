"""A beam of two identified modes that is driven at one point and whose tip each mode moves otherwise."""

from dataclasses import replace

import numpy as np

from updamp.effects.rig_model import RigModel
from updamp.measurement.measurement import Channel, MeasuredRun, Measurement
from updamp.model.build import modal_before_effects
from updamp.rig.modal_rig import ModalRig

DRIVE, TIP = "arm.drive.x", "arm.tip.x"
# Angular frequencies [rad/s], damping ratio, mass-normalised shapes at drive and tip [kg^-1/2].
MODES = {"first": (40.0, 0.004, 0.4, 1.5), "second": (97.0, 0.005, 0.9, -1.1)}


def two_modes(tip: dict[str, float] | None = None) -> RigModel:
    """tip: other shapes there, by mode"""
    modes = {
        name: {
            "frequency": f"{frequency} Hz",
            "damping_ratio": damping,
            "shape": {DRIVE: f"{drive} kg^-0.5", TIP: f"{(tip or {}).get(name, at_tip)} kg^-0.5"},
        }
        for name, (frequency, damping, drive, at_tip) in MODES.items()
    }
    rig = ModalRig.model_validate({"kind": "modal", "name": "arm", "excitation": DRIVE, "modes": modes})
    return modal_before_effects(rig)


def swept_arm(
    tip: complex = 1.0, conjugated: bool = False, excitation: str = DRIVE, modes: tuple[str, ...] = ("first",)
) -> Measurement:
    """Linear sweeps through modes at 1 N, by the residues; tip: factor of what the sensor there reads."""
    runs = [_sweep(mode, tip, conjugated) for mode in modes]
    channels = (Channel("drive", DRIVE), Channel("tip", TIP))
    return Measurement("arm", 0.0, excitation, channels, tuple(runs), repeatability=0.01)


def _sweep(mode: str, tip: complex, conjugated: bool) -> MeasuredRun:
    f = MODES[mode][0] * np.linspace(0.975, 1.025, 40)
    w, found = 2 * np.pi * f, {}
    for point, place in ((DRIVE, 2), (TIP, 3)):
        found[point] = sum(
            m[2] * m[place] / ((2 * np.pi * m[0]) ** 2 - w**2 + 2j * m[1] * 2 * np.pi * m[0] * w)
            for m in MODES.values()
        )
    x = np.stack([found[DRIVE], tip * found[TIP]])[:, None]
    x, force = x.conj() if conjugated else x, np.ones(40, complex)
    return MeasuredRun(f"{mode} 1 N", mode, True, "force", 1.0, 1, ("drive", "tip"), (1,), f, force, x)


def swept_levels(*factors: tuple[complex, complex], repeats: int = 1, odd: int = 1) -> Measurement:
    """Three levels of the first mode with 0.3 % of noise. factors: of what the sensors at the drive and at the tip
    read, a pair for each level, in the repeat that is odd"""
    rng, sound, runs = np.random.default_rng(8), swept_arm(), []
    (given,) = sound.runs
    for repeat in range(1, repeats + 1):
        for level, pair in zip((1.0, 2.0, 4.0), factors, strict=True):
            noise, factor = rng.standard_normal((2, *given.response.shape)), np.array(pair if repeat == odd else (1, 1))
            response = level * factor[:, None, None] * given.response * np.exp(0.003 * (noise[0] + 1j * noise[1]))
            of_level = replace(given, name=f"first {level:g} N", level=level, repeat=repeat)
            runs.append(replace(of_level, force=level * given.force, response=response))
    return replace(sound, runs=tuple(runs), repeatability=0.0 if repeats > 1 else 0.003)
