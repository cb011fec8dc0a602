"""The model that is fitted, built once for all cases: its stages are copied to where each diagnosis looks for them."""

import shutil
from collections.abc import Sequence
from pathlib import Path

from updamp import stages
from updamp.progress import Display
from updamp.rig import load_rig
from updamp.run import Run, RunOptions

STAGES = "stages"


def build(rig: Path, preset: str, folder: Path) -> Path:
    """Up to static contact, taken from the folder where nothing has changed. returns: the folder of this preset"""
    own = folder / preset
    with Display() as display:
        Run(load_rig(rig), RunOptions(preset, own, check=False, until=stages.STATIC_CONTACT), display).products()
    return own


def place(model: Path, out: Path, finer: Sequence[str] = ()) -> None:
    """Copies, since a diagnosis may write into its stages. finer: presets, built beside the model"""
    shutil.copytree(model / STAGES, out / STAGES, dirs_exist_ok=True)
    for preset in finer:
        shutil.copytree(model.parent / preset / STAGES, out / preset / STAGES, dirs_exist_ok=True)
