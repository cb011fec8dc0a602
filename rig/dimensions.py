"""Dimensions of the rig that may be other than its file says, and the rig with one of them changed."""

import math
from collections.abc import Mapping
from dataclasses import dataclass
from types import MappingProxyType

from updamp.rig.rig import Rig

_UNITS = {"mm": 1e-3, "deg": math.radians(1)}


@dataclass(frozen=True)
class Dimension:
    """name: of the effect that says it is wrong; key: dotted path in the rig file; unit: that people state it in"""

    name: str
    key: str
    unit: str = "mm"

    def stated(self, rig: Rig) -> float:
        """[m] or [rad]"""
        table, entry = self.key.split(".")
        return float(getattr(getattr(rig, table), entry))

    def text(self, rig: Rig, change: float = 0.0) -> str:
        """As a line of the rig file, with the relative change."""
        return f'{self.key} = "{self.stated(rig) * (1 + change) / _UNITS[self.unit]:.5g} {self.unit}"'

    def changed(self, rig: Rig, change: float) -> Rig:
        """The rig with it times 1 + change; whether that can be built is another question (`checks.py`)."""
        table, entry = self.key.split(".")
        there = getattr(rig, table).model_copy(update={entry: self.stated(rig) * (1 + change)})
        return rig.model_copy(update={table: there})


DIMENSIONS: Mapping[str, Dimension] = MappingProxyType(
    {
        d.name: d
        for d in (
            Dimension("face_length", "damper.face_length"),
            Dimension("platform_height", "platform.top"),
            Dimension("blade_thickness", "blade.thickness"),
            Dimension("face_angle", "platform.underside_angle", "deg"),
        )
    }
)
