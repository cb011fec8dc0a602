"""How finely a rig is meshed: a preset of the rig file."""

from typing import Annotated, Self

from pydantic import Field, model_validator

from updamp.rig.fields import InputTable

Divisions = Annotated[int, Field(strict=True, ge=1, examples=[4])]


class MeshDivisions(InputTable):
    """Divisions of the section's edges and of the width; contact_elements counts both faces, contact_strips one.

    contact_strips: along the width, into which a face is divided before these are divided into contact elements; by
        default as many as make the elements nearly equilateral. What opens or slips from an edge inwards does so strip
        by strip, so few elements go farther in more of them.
    """

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
    contact_strips: Divisions | None = None

    @model_validator(mode="after")
    def _elements_in_every_strip(self) -> Self:
        most = self.contact_elements // 4
        if self.contact_strips and self.contact_strips > most:
            raise ValueError(
                f"contact_strips = {self.contact_strips}: {self.contact_elements} contact elements make at most {most} "
                "on either face, of two elements each"
            )
        return self
