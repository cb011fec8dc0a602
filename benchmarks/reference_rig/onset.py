"""When contacts would begin to slip in OOP and to open in IP, over the dimensions of the family: by the linear motion.

    .venv/bin/updamp design rigs/studies/family.toml
    .venv/bin/python benchmarks/reference_rig/onset.py [results/studies/family]

For every design of the study, at the resonance of the stuck structure and with uniform pressure: the amplitude of the
tip [mm] at which half of the patches reach their slip limit in OOP, and that at which a quarter of them open in IP.
Neither damping nor the shaker's height enters.
"""

import argparse
from dataclasses import replace
from pathlib import Path

import numpy as np

from updamp.design.records import DONE, read_record
from updamp.design.run_study import StudyFolder, windows_of
from updamp.design.solved_design import DesignInput, SolvedDesign, observed_point
from updamp.design.study_file import read_study
from updamp.design.table import problem_of
from updamp.design.tracked_modes import mode_references
from updamp.design.variables import overrides
from updamp.hbm.resonance.conditions import linear_peak
from updamp.hbm.resonance.resonance import ResonanceProblem
from updamp.model.rig_files import load_any
from updamp.rig.toml_file import read_toml

ROOT = Path(__file__).parents[2]
STUDY = ROOT / "rigs" / "studies" / "family.toml"
UNIFORM = {"contact.pressure": {"model": "uniform"}}
NEAR = 2.0  # tolerances within which a design meets its targets


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


def main() -> None:
    reader = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    reader.add_argument("folder", nargs="?", type=Path, default=ROOT / "results" / "studies" / "family")
    study, folder = read_study(STUDY), StudyFolder(reader.parse_args().folder.resolve())
    rig = load_any(folder.rig)
    given = DesignInput(folder.rig, {}, study.mesh, folder.stages)
    references = mode_references(SolvedDesign(given).model, windows_of(rig), observed_point(rig))
    given, found, problem = replace(given, references=references), [], problem_of(study)
    for path in sorted(folder.designs.glob("*.json")):
        record = read_record(folder.designs, int(path.stem))
        losses = problem.losses(record)
        if record.outcome != DONE or losses is None:
            continue
        changes = {**overrides(read_toml(folder.rig, "a rig file"), study.variables, record.values), **UNIFORM}
        design = SolvedDesign(replace(given, changes=changes))
        slips, opens = tip_at_onset(design, "OOP"), tip_at_onset(design, "IP")
        found.append((max(losses), record.values["width"], slips, opens))
        print(f"{record.number:3} {max(losses):5.1f} tolerances off, width {record.values['width']:.1f} mm, slips at "
              f"{slips:.3f} mm, opens at {opens:.3f} mm: {slips / opens:.2f}", flush=True)  # fmt: skip
    table = np.array(found)
    for name, rows in (("all", table), (f"within {NEAR:g} tolerances", table[table[:, 0] < NEAR])):
        ratio = rows[:, 2] / rows[:, 3]
        print(f"{name}: {len(rows)} designs; slips at {rows[:, 2].min():.3f} to {rows[:, 2].max():.3f} mm, opens at "
              f"{rows[:, 3].min():.3f} to {rows[:, 3].max():.3f} mm, ratio {ratio.min():.2f} to {ratio.max():.2f}; "
              f"correlation with the width {np.corrcoef(rows[:, 1], rows[:, 2])[0, 1]:.2f}, "
              f"{np.corrcoef(rows[:, 1], rows[:, 3])[0, 1]:.2f}")  # fmt: skip


if __name__ == "__main__":
    main()
