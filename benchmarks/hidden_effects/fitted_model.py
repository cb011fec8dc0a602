"""The one call by which the benchmark reaches the diagnosis. It is told nothing but what an engineer has."""

import shutil
from collections.abc import Sequence
from pathlib import Path

from rich.console import Console

from updamp.diagnosis.verdict import Verdict
from updamp.hbm.compilation_cache import keep_compiled
from updamp.model.rig_files import load_rig
from updamp.workflow import stages
from updamp.workflow.built_rig import FOLDER as DIMENSIONS
from updamp.workflow.built_rig import built_rig, chosen_dimensions
from updamp.workflow.comparison_inputs import CompareFiles
from updamp.workflow.diagnose_run import DiagnoseOptions, diagnose
from updamp.workflow.progress import Display
from updamp.workflow.run import Run
from updamp.workflow.run_options import RunOptions

# Fitted model -> meshes whose difference from it counts as numerical error.
FINER = {"diagnosis": ("diagnosis_fine", "diagnosis_contacts"), "diagnosis_146": ("diagnosis_146_fine",)}


def diagnose_case(rig: Path, preset: str, measurement: Path, out: Path) -> Verdict:
    """rig: file; preset: mesh of the fitted model; out: folder for whatever it writes, with the model's stages in it

    Where the diagnosis tells what it would have said without a part of the method, it does so in out/ablations.json or
    in the verdict's provenance: see `scored_case.ablations_of`.
    """
    keep_compiled()
    options = DiagnoseOptions(finer=FINER[preset], report=False)
    return diagnose(CompareFiles(rig, measurement, out), preset, options, Console(quiet=True))


# The model that is fitted, built once for all cases: its stages are copied to where each diagnosis looks for them.

STAGES = "stages"


def build(rig: Path, preset: str, folder: Path) -> Path:
    """Up to static contact, taken from the folder where nothing has changed. returns: the folder of this preset"""
    own = folder / preset
    with Display() as display:
        Run(load_rig(rig), RunOptions(preset, own, check=False, until=stages.STATIC_CONTACT), display).products()
    return own


def build_dimensions(rig: Path, preset: str, folder: Path) -> None:
    """The rig once more for each dimension that may be other than stated, beside the models of this preset and of the
    finer ones."""
    loaded = load_rig(rig)
    with Display() as display:
        own = built_rig(loaded, preset, folder / preset, 1, display)
        varied = own.varied(chosen_dimensions(None))
        for finer in FINER.get(preset, ()):
            built_rig(loaded, finer, folder / finer, 1, display).varied_as(own, varied)


def place(model: Path, out: Path, finer: Sequence[str] = ()) -> None:
    """Copies, since a diagnosis may write into its stages. finer: presets, built beside the model"""
    for source, target in ((model, out), *((model.parent / preset, out / preset) for preset in finer)):
        for part in (STAGES, DIMENSIONS):
            if part == STAGES or (source / part).is_dir():
                shutil.copytree(source / part, target / part, dirs_exist_ok=True)
