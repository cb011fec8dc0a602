"""What a response is, and the register of the kinds that a study file can name."""

from collections.abc import Callable
from typing import Annotated, ClassVar, Literal, TypeVar

from pydantic import Field

from updamp.design.rig_numbers import AnyRig
from updamp.design.solved_design import SolvedDesign
from updamp.design.solved_peak import PeakRequest, SolvedPeak
from updamp.rig.fields import InputTable
from updamp.rig.modal_rig import ModalRig
from updamp.rig.rig import Force, Name


class Response(InputTable):
    """One [[responses]] of a study file, `kind` aside; what a kind needs besides the name are fields of its class.

    unit: of its values, "" for a plain number; of_geometry: whether a rig given by modes has none
    """

    name: Name
    unit: ClassVar[str] = ""
    of_geometry: ClassVar[bool] = False

    def value(self, design: SolvedDesign) -> float:
        """In `unit`. raises: UnknownResponseError with the reason where the design has none; what the stages raise"""
        raise NotImplementedError

    def peaks(self) -> tuple[PeakRequest, ...]:
        """Resonances that it will ask for."""
        return ()

    def modes(self) -> tuple[str, ...]:
        """Modes of the study that it names."""
        return ()

    def problem(self, rig: AnyRig) -> str:
        """Why the rig cannot have it, "" where it can."""
        if self.of_geometry and isinstance(rig, ModalRig):
            return "kind: a rig given by modes has no geometry and no contacts; take it out"
        known = tuple(rig.windows)
        wrong = next((mode for mode in self.modes() if mode not in known), None)
        return f'mode = "{wrong}": the rig has no such mode; it has {", ".join(known)}' if wrong is not None else ""


class AtPeak(Response):
    """At one mode's resonance under one force.

    point: where it is observed, by default the tip of the excited blade
    by: "resonance" follows the resonance and falls back to the curve where that stops, which may take minutes;
        "resonance_only" does not; "curve" traces the curve
    """

    mode: Annotated[str, Field(examples=["OOP"])]
    force: Force
    point: str = ""
    by: Literal["resonance", "resonance_only", "curve"] = "resonance"

    @property
    def request(self) -> PeakRequest:
        return PeakRequest(self.mode, self.force, self.point, self.by)

    def peak(self, design: SolvedDesign) -> SolvedPeak:
        return design.peak(self.request)

    def peaks(self) -> tuple[PeakRequest, ...]:
        return (self.request,)

    def modes(self) -> tuple[str, ...]:
        return (self.mode,)


RESPONSES: dict[str, type[Response]] = {}
"""kind -> class; filled by the files of this folder, which `design/study_file.py` imports."""

Kind = TypeVar("Kind", bound=type[Response])


def response(kind: str) -> Callable[[Kind], Kind]:
    """Register a class under the name that a study file uses for it."""

    def add(cls: Kind) -> Kind:
        RESPONSES[kind] = cls
        return cls

    return add
