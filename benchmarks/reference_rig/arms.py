"""Rigs with other arms, angles and faces: when contacts slip and open by the linear motion, and what the peaks do.

    .venv/bin/python benchmarks/reference_rig/arms.py [NAME ...] [--without-peaks]

Each rig of the table below has thickness, platform height, edge and shaker's height chosen so that the free and stuck
frequencies and the low-force receptance stay where they are stated, on mesh `small`. Printed: those, the amplitude of
the tip [mm] at which half of the patches slip in OOP and a quarter open in IP, and the peaks [mm/N] with
the film of the rig file, followed in the force. docs/reference_rig.md says what came of it.
"""

import argparse
from collections.abc import Mapping
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np

from updamp.design.solved_design import DesignInput, SolvedDesign
from updamp.design.solved_peak import PeakRequest
from updamp.design.tracked_modes import UnknownResponseError, mode_references
from updamp.hbm.compilation_cache import keep_compiled
from updamp.hbm.resonance.linear_peak import linear_peak
from updamp.hbm.resonance.resonance import ResonanceProblem
from updamp.model.rig_files import load_any

ROOT = Path(__file__).parents[2]
RIG = ROOT / "rigs" / "pesaresi2017.toml"
FORCES = (0.096, 0.96, 3.84, 9.6, 17.0)
MOST_POINTS = 500
UNIFORM = {"contact.pressure": {"model": "uniform"}}

PATHS = (
    "blade.width", "blade.axis_offset", "platform.underside_angle", "platform.gap", "damper.face_start",
    "damper.face_length", "blade.thickness", "platform.top", "platform.edge_thickness", "excitation.height",
)  # fmt: skip
# The values of PATHS [mm, deg], and the loss factor.
RIGS: Mapping[str, tuple[tuple[float, ...], float]] = {
    "arms 30, width 15, 30 deg": ((15, 30, 30, 4, 2, 4.95, 7.062, 43.3, 2, 10.3), 0.0009),
    "the same, faces 9": ((15, 30, 27.02, 4, 2, 9, 7.1186, 42.52, 1.2, 10.779), 0.0009),
    "arms 30, width 25, faces 12": ((25, 30, 23.82, 4, 2, 12, 7.1376, 42.546, 1.2, 15.459), 0.0009),
    "arms 44, width 24, faces 6": ((24, 44, 25, 4, 2, 6, 6.8015, 43.257, 1.6375, 15.525), 0.0009),
    "the same, gap 3": ((24, 44, 25, 3, 0.5, 6, 6.7849, 43.174, 1.6375, 15.755), 0.0009),
    "the same, less loss": ((24, 44, 25, 3, 0.5, 6, 6.7802, 43.168, 1.6127, 10.402), 0.0005),
    "the same, faces 4": ((24, 44, 25, 3, 0.5, 4, 6.77, 43.2, 1.8, 10.4), 0.0005),
    "arms 46, width 24, 20 deg": ((24, 46, 20, 3, 0.5, 3.8, 6.9113, 42.857, 2.7478, 10.083), 0.0005),
    "the same, gap 2": ((24, 46, 20, 2, 0.3, 3.8, 6.9097, 42.782, 2.5315, 10.147), 0.0005),
    "nearly as the rig file": ((25, 46, 20, 2.4, 0.4, 4, 6.955, 43.35, 2.5, 11.2), 0.0006),
}


def changes(name: str) -> dict[str, Any]:
    """By dotted path, as a rig file is read with."""
    lengths, loss = RIGS[name]
    units = ("deg" if path.endswith("angle") else "mm" for path in PATHS)
    stated: dict[str, Any] = {p: f"{v:g} {unit}" for p, v, unit in zip(PATHS, lengths, units, strict=True)}
    return {**stated, "material.loss_factor": loss}


def tip_at_onset(design: SolvedDesign, mode: str) -> float:
    """Amplitude of the tip [mm] at which half of the patches slip (OOP) or a quarter of them open (IP)."""
    system, tracked, rig = design.model.system, design.mode(mode), design.geometry
    row, tip = system.free.row(design.model.excitation), system.free.row(design.observed)
    peak = linear_peak(ResonanceProblem(system, row, tip), tracked.window, 0.0, tracked.frequency)
    motion = np.abs(system.harmonics.amplitude(peak.z, 1).reshape(-1, 3))
    rows = np.array([tip, row])
    receptance = abs(system.stuck.receptance(peak.w, rows[:1], rows[1:])[0, 0])
    contact = rig.contact
    pressure = design.rest.normal_force.sum() / (2 * rig.face_area)
    if mode == "OOP":
        slip = contact.friction_coefficient * pressure / contact.tangential_stiffness
        return float(1e3 * receptance * np.median(slip / np.hypot(motion[:, 0], motion[:, 1])))
    return float(1e3 * receptance * np.quantile(pressure / contact.normal_stiffness / motion[:, 2], 0.25))


def print_peaks(design: SolvedDesign, mode: str) -> None:
    """Peak receptances [mm/N], or why the resonance was not followed so far."""
    for request in design.given.peaks:
        if request.mode != mode:
            continue
        try:
            peak = design.peak(request)
            found = f"{peak.frequency:.2f} Hz {1e3 * peak.receptance:.5f}"
        except (UnknownResponseError, RuntimeError) as error:
            found = f": {error}"
        print(f"    {mode} {request.force:g} N {found}", flush=True)


def main() -> None:
    reader = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    reader.add_argument("names", nargs="*", default=list(RIGS))
    reader.add_argument("--without-peaks", action="store_true")
    reader.add_argument("--out", type=Path, default=ROOT / "results" / "studies" / "arms")
    stated = reader.parse_args()
    keep_compiled()
    given = DesignInput(RIG, {}, "small", stated.out / "stages", most_points=MOST_POINTS)
    rig = load_any(RIG)
    references = mode_references(SolvedDesign(given).model, rig.windows, rig.response_point)
    requests = tuple(PeakRequest(mode, f, "", "resonance_only") for mode in ("OOP", "IP") for f in FORCES)
    given = replace(given, references=references, peaks=requests)
    for name in stated.names:
        uniform = SolvedDesign(replace(given, changes={**changes(name), **UNIFORM}))
        slips, opens = tip_at_onset(uniform, "OOP"), tip_at_onset(uniform, "IP")
        stuck = ", ".join(f"{one.name} {uniform.mode(one.name).frequency:.1f} Hz" for one in references)
        print(f"{name}: {stuck}; slips at {slips:.3f} mm, opens at {opens:.3f} mm: {slips / opens:.2f}", flush=True)
        if not stated.without_peaks:
            for one in references:
                print_peaks(SolvedDesign(replace(given, changes=changes(name))), one.name)


if __name__ == "__main__":
    main()
