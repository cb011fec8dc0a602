"""What the damper weighs."""

from typing import ClassVar

from updamp.design.responses.response import Response, response
from updamp.design.solved_design import SolvedDesign
from updamp.rig.damper_mass import damper_mass


@response("damper_mass")
class DamperMass(Response):
    """Of the damper's section and width; no finite elements are needed."""

    unit: ClassVar[str] = "g"
    of_geometry: ClassVar[bool] = True

    def value(self, design: SolvedDesign) -> float:
        return 1e3 * damper_mass(design.geometry)
