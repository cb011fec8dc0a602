"""Rig files of both kinds, read with the effects and factors that there are."""

from collections.abc import Mapping
from pathlib import Path
from typing import Any

from updamp.rig.effects import Calibration, Readers, RigEffect
from updamp.rig.errors import RigError
from updamp.rig.modal_rig import ModalRig
from updamp.rig.read import read_rig, read_section
from updamp.rig.rig import Rig
from updamp.rig.toml_file import read_toml


# Both are imported on call: they load JAX, which takes 1.5 s, and most rig files state neither table.
def _effects(tables: object, folder: Path) -> tuple[RigEffect, ...]:
    from updamp.effects.chosen import read_effects

    return read_effects(tables, folder)


def _calibration(table: object) -> Calibration:
    from updamp.model.calibration import read_calibration

    return read_calibration(table)


READERS = Readers(_effects, _calibration)


def load_rig(path: str | Path, overrides: Mapping[str, Any] | None = None) -> Rig:
    """Read and check the file of a rig with geometry.

    path: TOML file; files it names are sought beside it
    overrides: values as in the file that replace the file's own, by dotted path,
        such as {"blade.thickness": "7.4 mm"}
    raises: RigError with every problem found, one a line
    """
    return read_rig(Path(path), READERS, overrides)


def load_modal(path: str | Path, overrides: Mapping[str, Any] | None = None) -> ModalRig:
    """Read and check a modal rig file (TOML); overrides as for `load_rig`.

    raises: RigError with every problem found, one a line
    """
    return read_section(Path(path), ModalRig, READERS, "a modal rig file, such as rigs/brake_reuss.toml", overrides)


def load_any(path: str | Path, overrides: Mapping[str, Any] | None = None) -> Rig | ModalRig:
    """Of either kind; overrides as for `load_rig`; raises: RigError"""
    return load_modal(path, overrides) if is_modal(path) else load_rig(path, overrides)


def load_with_dimensions(path: str | Path) -> Rig:
    """raises: RigError; ValueError where the rig is given by its modes"""
    if is_modal(path):
        load_modal(path)  # what is wrong with it comes first
        raise ValueError(
            f"{path}: gives modes, not dimensions, so there is nothing to mesh; use it with: updamp compare "
            f"{path} MEASUREMENT --out DIR (or diagnose), or from Python with updamp.api.response_curve"
        )
    return load_rig(path)


def is_modal(path: str | Path) -> bool:
    """Whether a rig file gives modes; False for one that cannot be read, which its loader explains better."""
    try:
        return "kind" in read_toml(Path(path), "a rig file")
    except RigError:
        return False
