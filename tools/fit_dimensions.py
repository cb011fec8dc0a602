"""Fit the dimensions that are not published, so that the model meets what the paper's model met.

    .venv/bin/python tools/fit_dimensions.py rigs/pesaresi2017.toml

Three lengths against three frequencies: the free 1F mode and the two stuck 1F modes. The fit runs on a coarse mesh
(--surrogate) towards targets that are corrected by the ratio of fine to coarse (--mesh), so that the fine mesh, which
takes minutes, is solved only --corrections times (space mapping: Bandler et al., 1994).
"""

from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Annotated

import numpy as np
import typer
from numpy.typing import NDArray
from rich.console import Console
from scipy.optimize import least_squares

from updamp.fem.finite_element_model import finite_element_model
from updamp.geometry.build_mesh import build_mesh
from updamp.hbm.problem.linear_model import LinearModel, stuck_on
from updamp.hbm.problem.structural_changes import attach
from updamp.model.build import from_reduced, wire_attachments
from updamp.model.rig_files import load_rig
from updamp.rig.rig import Rig

Floats = NDArray[np.float64]

TARGETS = {"free 1F": 269.0, "stuck OOP": 440.0, "stuck IP": 424.0}  # Hz
TOLERANCES = {"free 1F": 0.005, "stuck OOP": 0.01, "stuck IP": 0.02}
LENGTHS = ("blade.thickness", "damper.face_length", "platform.top")
RECEPTANCES = {"OOP": 0.0125, "IP": 0.01}  # mm/N, published at low force
console = Console()


@dataclass(frozen=True)
class Linear:
    """frequencies: of TARGETS [Hz]; receptance: at the tips at resonance, by mode [mm/N]"""

    frequencies: Floats
    receptance: Mapping[str, float]


def linear_numbers(path: Path, lengths: Floats, preset: str) -> Linear:
    """lengths: of LENGTHS [m]"""
    rig = load_rig(path, {name: f"{value:.9f} m" for name, value in zip(LENGTHS, lengths, strict=True)})
    result = finite_element_model(build_mesh(rig, preset), rig)
    model = attach(from_reduced(result.reduced, rig.loss_factors), wire_attachments(rig))
    area = result.reduced.contacts.area
    per_area = np.array([rig.contact.tangential_stiffness] * 2 + [rig.contact.normal_stiffness])
    stuck = stuck_on(model, np.outer(area, per_area).ravel())
    modes = {_name(stuck, i): i for i in range(2)}
    return Linear(
        np.array([result.blade_frequencies[0], *(stuck.frequencies[modes[m]] for m in ("OOP", "IP"))]),
        {name: _resonant_receptance(stuck, i, rig) for name, i in modes.items()},
    )


def _name(stuck: LinearModel, mode: int) -> str:
    left, right = (stuck.phi[stuck.row(f"blade_{side}.tip.x"), mode] for side in ("left", "right"))
    return "IP" if left * right > 0 else "OOP"


def _resonant_receptance(stuck: LinearModel, mode: int, rig: Rig) -> float:
    tip, shaker = (stuck.phi[stuck.row(f"blade_{rig.excitation.blade}.{p}.x"), mode] for p in ("tip", "excitation"))
    return float(abs(tip * shaker) / stuck.hysteretic[mode, mode] * 1e3)


def fit(path: Path, start: Floats, preset: str, targets: Floats) -> tuple[Floats, Floats]:
    """Lengths [m] at which the surrogate meets the targets, and its sensitivity there [relative per m]."""

    def misfit(lengths: Floats) -> Floats:
        numbers = linear_numbers(path, lengths * 1e-3, preset).frequencies
        console.print(f"  {np.round(lengths, 4)} mm -> {np.round(numbers, 3)} Hz")
        return numbers / targets - 1

    found = least_squares(misfit, start * 1e3, diff_step=[0.01] * len(start), xtol=1e-5, ftol=1e-10, max_nfev=6)
    return found.x * 1e-3, np.asarray(found.jac) * 1e3


def main(
    path: Path,
    surrogate: Annotated[str, typer.Option(help="coarse mesh preset")] = "medium",
    mesh: Annotated[str, typer.Option(help="fine mesh preset, the one that counts")] = "full",
    corrections: Annotated[int, typer.Option(min=1, help="how often the fine mesh is solved to correct")] = 2,
) -> None:
    """Fit blade thickness, damper face length and platform height; print what to write into the rig file."""
    rig, wanted = load_rig(path), np.array(list(TARGETS.values()))
    lengths = np.array([rig.blade.thickness, rig.damper.face_length, rig.platform.top])
    for _ in range(corrections):
        fine, coarse = (linear_numbers(path, lengths, preset).frequencies for preset in (mesh, surrogate))
        console.print(f"{mesh} / {surrogate}: {fine} / {coarse} Hz")
        lengths, sensitivity = fit(path, lengths, surrogate, wanted * coarse / fine)
    final = linear_numbers(path, lengths, mesh)
    for name, value in zip(LENGTHS, lengths, strict=True):
        console.print(f'{name} = "{value * 1e3:.3f} mm"')
    for name, value, target in zip(TARGETS, final.frequencies, wanted, strict=True):
        met = abs(value / target - 1) < TOLERANCES[name]
        console.print(
            f"{name}: {value:.2f} Hz, wanted {target:.1f} within {TOLERANCES[name]:.1%}: {'met' if met else 'NOT MET'}"
        )
    ratio = np.sqrt(np.prod([final.receptance[m] / RECEPTANCES[m] for m in RECEPTANCES]))
    console.print(f"receptance at the tip {final.receptance} mm/N; loss factor that meets the geometric mean of those "
                  f"published: {rig.material.loss_factor * ratio:.2e}")  # fmt: skip
    console.print(f"sensitivity, % per mm (rows {list(TARGETS)}, columns {LENGTHS}):\n{sensitivity * 0.1}")
    console.print(f"its singular values: {np.linalg.svd(sensitivity * 0.1, compute_uv=False)}")


if __name__ == "__main__":
    typer.run(main)
