"""The one call by which the benchmark reaches the diagnosis. It is told nothing but what an engineer has."""

from pathlib import Path

from updamp.diagnosis.verdict import Verdict


def diagnose_case(rig: Path, preset: str, measurement: Path, out: Path) -> Verdict:
    """rig: file; preset: mesh of the fitted model; out: folder for whatever it writes, with the model's stages in it

    Where the diagnosis tells what it would have said without a part of the method, it does so in out/ablations.json or
    in the verdict's provenance: see `scored_case.ablations_of`.
    """
    from updamp.diagnosis.search import diagnose_files

    return diagnose_files(rig, preset, measurement, out)
