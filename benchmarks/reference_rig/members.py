"""Members of the family of rigs, with the pressures of the paper's study: which findings depend on the dimensions?

    .venv/bin/updamp design rigs/studies/family.toml
    .venv/bin/python benchmarks/reference_rig/members.py [results/studies/family] [--members 3]

The family's draws (posterior.csv) are split by the blades' width into as many parts as there are members, and each part
is stood for by the draw next to its mean. Resonances are followed in the force on the study's mesh; stages are shared
with the study. Prints peaks [mm/N] and, for findings 5, 6, 7 and 12, what the parameter study judges by.
"""

import argparse
import csv
from collections.abc import Mapping
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np

from updamp.design.run_study import StudyFolder, windows_of
from updamp.design.solved_design import DesignInput, SolvedDesign, observed_point
from updamp.design.solved_peak import PeakRequest
from updamp.design.study_file import DesignStudy, read_study
from updamp.design.tracked_modes import UnknownResponseError, mode_references
from updamp.design.variables import Values, overrides
from updamp.hbm.compilation_cache import keep_compiled
from updamp.model.rig_files import load_any
from updamp.rig.toml_file import read_toml

ROOT = Path(__file__).parents[2]
STUDY = ROOT / "rigs" / "studies" / "family.toml"
LOW, MIDDLE, HIGH = 0.096, 3.84, 17.0


def two_areas(share: float, fraction: float = 0.5) -> dict[str, Any]:
    return {"model": "two_area", "central_share": share, "central_fraction": fraction}


UNIFORM = {"model": "uniform"}
PRESSURES: Mapping[str, dict[str, Any]] = {
    "film": {},
    "50/50": {"contact.pressure": UNIFORM},
    "70/30": {"contact.pressure": two_areas(0.7)},
    "80/20": {"contact.pressure": two_areas(0.8)},
    "90/10": {"contact.pressure": two_areas(0.9)},
    "100/0": {"contact.pressure": two_areas(1.0)},
    "asymmetric": {"contact.pressure": {"model": "by_face", "left": UNIFORM, "right": two_areas(0.9)}},
    "95/5": {"contact.pressure": two_areas(0.95)},
    "90/10 over 35 %": {"contact.pressure": two_areas(0.9, 0.35)},
}


def chosen(folder: Path, study: DesignStudy, number: int) -> list[Values]:
    """Draws that stand for parts of the family."""
    with (folder / "posterior.csv").open(encoding="utf-8") as file:
        draws = np.array([[float(value) for value in row] for row in list(csv.reader(file))[1:]])
    names = [one.name for one in study.variables]
    shares = np.array([[v.share(x) for v, x in zip(study.variables, draw, strict=True)] for draw in draws])
    found = []
    for part in np.array_split(np.argsort(shares[:, names.index("width")]), number):
        far = np.linalg.norm(shares[part] - shares[part].mean(axis=0), axis=1)
        found.append(dict(zip(names, draws[part[far.argmin()]].tolist(), strict=True)))
    return found


def peaks(given: DesignInput, mode: str) -> dict[float, float]:
    """Force -> peak receptance [mm/N], nan where the resonance was not followed so far"""
    design = SolvedDesign(given)
    found = {}
    for request in given.peaks:
        if request.mode == mode:
            try:
                peak = design.peak(request)
                found[request.force] = 1e3 * peak.receptance
                print(f"    {mode} {request.force:g} N {peak.frequency:.2f} Hz {found[request.force]:.5f}", flush=True)
            except (UnknownResponseError, RuntimeError) as error:
                found[request.force] = np.nan
                print(f"    {mode} {request.force:g} N: {error}", flush=True)
    return found


def judged(oop: Mapping[str, Mapping[float, float]]) -> list[str]:
    split = ("50/50", "70/30", "80/20", "90/10", "100/0")
    at = {force: {name: oop[name][force] for name in split} for force in (MIDDLE, HIGH)}
    film, one_sided = oop["film"], oop["asymmetric"]
    drop = {force: 1 - film[force] / film[LOW] for force in (MIDDLE, HIGH)}
    low, high = (one_sided[force] / oop["50/50"][force] - 1 for force in (MIDDLE, HIGH))
    return [
        f"5: at 3.84 N lowest {min(at[MIDDLE].values()) / at[MIDDLE]['50/50'] - 1:+.0%} of 50/50 (-65 % is published)",
        f"6: at 17 N lowest at {min(at[HIGH], key=lambda name: at[HIGH][name])} (80/20 is published)",
        f"7: asymmetric {low:+.0%} at 3.84 N, {high:+.0%} at 17 N (most at low force is published)",
        f"12: film down by {drop[HIGH]:.0%} at 17 N, {drop[MIDDLE]:.0%} at 3.84 N (most of 40 to 70 % is published)",
    ]


def main() -> None:
    reader = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    reader.add_argument("folder", nargs="?", type=Path, default=ROOT / "results" / "studies" / "family")
    reader.add_argument("--members", type=int, default=3)
    reader.add_argument("--without-ip", action="store_true")
    stated = reader.parse_args()
    keep_compiled()
    study, folder = read_study(STUDY), StudyFolder(stated.folder.resolve())
    rig = load_any(folder.rig)
    requests = tuple(PeakRequest("OOP", force, "", "resonance_only") for force in (LOW, MIDDLE, HIGH))
    given = DesignInput(folder.rig, {}, study.mesh, folder.stages, (), requests, 600)
    references = mode_references(SolvedDesign(given).model, windows_of(rig), observed_point(rig))
    given = replace(given, references=references)
    for values in chosen(stated.folder, study, stated.members):
        print("member", ", ".join(f"{name} {value:.5g}" for name, value in values.items()), flush=True)
        dimensions = overrides(read_toml(folder.rig, "a rig file"), study.variables, values)
        oop = {}
        for name, pressure in PRESSURES.items():
            print(f"  {name}", flush=True)
            oop[name] = peaks(replace(given, changes={**dimensions, **pressure}), "OOP")
        print("\n".join(judged(oop)), flush=True)
        if not stated.without_ip:
            in_phase = tuple(replace(one, mode="IP") for one in requests)
            peaks(replace(given, changes=dimensions, peaks=in_phase), "IP")


if __name__ == "__main__":
    main()
