"""Where a slow sweep would jump: needs the whole response curve."""

from typing import Annotated, ClassVar, Literal

from pydantic import Field

from updamp.design.responses.response import Response, response
from updamp.design.solved_design import SolvedDesign
from updamp.design.solved_peak import require_complete
from updamp.design.tracked_modes import UnknownResponseError
from updamp.hbm.continuation.sweeps import swept
from updamp.rig.rig import Force


class _OfSweep(Response):
    """sweep: "up" or "down" """

    mode: Annotated[str, Field(examples=["IP"])]
    force: Force
    sweep: Literal["up", "down"] = "up"

    def jumps(self, design: SolvedDesign) -> list[float]:
        """[Hz] in the order of the sweep"""
        curve = design.curve(self.mode, self.force)
        require_complete(curve)
        found: list[float] = swept(curve, upwards=self.sweep == "up").jumps.tolist()
        return found

    def modes(self) -> tuple[str, ...]:
        return (self.mode,)


@response("jump_frequency")
class JumpFrequency(_OfSweep):
    """number: 1 for the first jump of the sweep"""

    unit: ClassVar[str] = "Hz"
    number: Annotated[int, Field(strict=True, ge=1)] = 1

    def value(self, design: SolvedDesign) -> float:
        jumps = self.jumps(design)
        if len(jumps) < self.number:
            raise UnknownResponseError(f"a sweep {self.sweep} jumps {len(jumps)} times")
        return jumps[self.number - 1]


@response("jump_count")
class JumpCount(_OfSweep):
    """How often a slow sweep jumps."""

    def value(self, design: SolvedDesign) -> float:
        return float(len(self.jumps(design)))
