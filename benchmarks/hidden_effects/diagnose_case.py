"""The one call by which the benchmark reaches the diagnosis. It is told nothing but what an engineer has."""

from pathlib import Path

from rich.console import Console

from updamp.diagnosis.verdict import Verdict

# Fitted model -> meshes whose difference from it counts as numerical error.
FINER = {"diagnosis": ("diagnosis_fine", "diagnosis_contacts"), "diagnosis_146": ("diagnosis_146_fine",)}


def diagnose_case(rig: Path, preset: str, measurement: Path, out: Path) -> Verdict:
    """rig: file; preset: mesh of the fitted model; out: folder for whatever it writes, with the model's stages in it

    Where the diagnosis tells what it would have said without a part of the method, it does so in out/ablations.json or
    in the verdict's provenance: see `scored_case.ablations_of`.
    """
    from updamp.diagnosis.compare_run import CompareFiles
    from updamp.diagnosis.search.diagnose import DiagnoseOptions, diagnose
    from updamp.hbm.compilation_cache import keep_compiled

    keep_compiled()
    options = DiagnoseOptions(finer=FINER[preset], report=False)
    return diagnose(CompareFiles(rig, measurement, out), preset, options, Console(quiet=True))
