"""How high a resonance is and where it lies."""

from typing import ClassVar

from updamp.design.responses.response import AtPeak, response
from updamp.design.solved_design import SolvedDesign
from updamp.design.solved_peak import PeakRequest
from updamp.rig.rig import Force


@response("peak_receptance")
class PeakReceptance(AtPeak):
    """First harmonic over force at the resonance."""

    unit: ClassVar[str] = "mm/N"

    def value(self, design: SolvedDesign) -> float:
        return 1e3 * self.peak(design).receptance


@response("resonance_frequency")
class ResonanceFrequency(AtPeak):
    """Where the resonance lies."""

    unit: ClassVar[str] = "Hz"

    def value(self, design: SolvedDesign) -> float:
        return self.peak(design).frequency


@response("frequency_shift")
class FrequencyShift(AtPeak):
    """Of the resonance against that under a low force, by default a thousandth of the force; negative: it falls."""

    unit: ClassVar[str] = "Hz"
    low_force: Force | None = None

    @property
    def low(self) -> PeakRequest:
        force = self.force / 1000 if self.low_force is None else self.low_force
        return PeakRequest(self.mode, force, self.point, self.by)

    def peaks(self) -> tuple[PeakRequest, ...]:
        return self.low, self.request

    def value(self, design: SolvedDesign) -> float:
        return self.peak(design).frequency - design.peak(self.low).frequency
