"""Frequencies of the linear structure: without contacts, and with all of them stuck."""

from typing import Annotated, ClassVar

from pydantic import Field

from updamp.design.responses.response import Response, response
from updamp.design.rig_numbers import AnyRig
from updamp.design.solved_design import SolvedDesign
from updamp.design.tracked_modes import UnknownResponseError
from updamp.model.small_amplitude import without_contacts
from updamp.rig.modal_rig import ModalRig

COMPONENTS = ("blade_left", "blade_right", "damper")


@response("free_frequency")
class FreeFrequency(Response):
    """Of one component alone, without contacts. number: 1 for the first; component: of a rig with geometry"""

    unit: ClassVar[str] = "Hz"
    number: Annotated[int, Field(strict=True, ge=1)] = 1
    component: str = "blade_right"

    def problem(self, rig: AnyRig) -> str:
        if not isinstance(rig, ModalRig) and self.component not in COMPONENTS:
            return f'component = "{self.component}": the rig has {", ".join(COMPONENTS)}'
        return super().problem(rig)

    def value(self, design: SolvedDesign) -> float:
        owners = design.model.owner
        component = self.component if self.component in owners else owners[0]  # a rig given by modes has one
        try:
            return without_contacts(design.model, component, self.number - 1)
        except IndexError:
            kept = owners.count(component)
            raise UnknownResponseError(f"number = {self.number}: the model keeps {kept} modes of {component}") from None


@response("stuck_frequency")
class StuckFrequency(Response):
    """Of a mode of the study with all contacts closed and stuck."""

    unit: ClassVar[str] = "Hz"
    mode: Annotated[str, Field(examples=["OOP"])]

    def value(self, design: SolvedDesign) -> float:
        return design.mode(self.mode).frequency

    def modes(self) -> tuple[str, ...]:
        return (self.mode,)
