"""Small pictures of the cross section, one a design: outlines of both blades and the damper, in mm."""

from collections.abc import Mapping
from typing import Any

import numpy as np
from numpy.typing import NDArray

from updamp.design.run_study import StudyResult
from updamp.design.variables import overrides
from updamp.geometry.outlines import blade_outline, damper_outline
from updamp.model.rig_files import load_any
from updamp.rig.errors import RigError
from updamp.rig.rig import Rig
from updamp.rig.toml_file import read_toml

_OF_GEOMETRY = ("blade", "platform", "damper")


def section_pictures(result: StudyResult) -> dict[str, Any]:
    """number -> outlines; "" -> those of the rig as it stands, for designs that change no geometry. None for a rig
    given by modes; a design that cannot be built has none."""
    if not isinstance(result.rig, Rig):
        return {}
    if not any(one.path.split(".")[0] in _OF_GEOMETRY for one in result.study.variables):
        return {"": _outlines(result.rig)}
    stated, pictures = read_toml(result.folder.rig, "a rig file"), {}
    for record in result.records:
        try:
            rig = load_any(result.folder.rig, overrides(stated, result.study.variables, record.values))
        except RigError:
            continue
        assert isinstance(rig, Rig), "of the same kind as the study's"
        pictures[str(record.number)] = _outlines(rig)
    return pictures


def _outlines(rig: Rig) -> Mapping[str, list[list[float]]]:
    """The blades are cut off a little above the platform: what matters lies below."""
    blade = blade_outline(rig)
    blade[:, 1] = np.minimum(blade[:, 1], 1.4 * rig.platform.top)
    return {"right": _mm(blade), "left": _mm(blade * [-1.0, 1.0]), "damper": _mm(damper_outline(rig))}


def _mm(outline: NDArray[np.float64]) -> list[list[float]]:
    rounded: list[list[float]] = np.round(1e3 * outline, 3).tolist()
    return rounded
