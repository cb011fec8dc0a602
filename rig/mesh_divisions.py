"""How finely a rig is meshed: a preset of the rig file."""

from typing import Annotated

from pydantic import Field

from updamp.rig.fields import InputTable

Divisions = Annotated[int, Field(strict=True, ge=1, examples=[4])]


class MeshDivisions(InputTable):
    """Divisions of the section's edges and of the width; contact_elements counts both faces."""

    width: Annotated[int, Field(strict=True, ge=2, multiple_of=2, examples=[12])]  # a node at mid-width
    face: Divisions
    platform_outer: Divisions
    platform_inner: Divisions
    platform_height: Divisions
    stem_thickness: Divisions
    stem_below_excitation: Divisions
    stem_below_platform: Divisions
    stem_above_platform: Divisions
    stem_top: Divisions
    damper_across: Divisions
    damper_apex: Divisions
    damper_base: Divisions
    contact_elements: Annotated[int, Field(strict=True, ge=4, multiple_of=2, examples=[36])]
