"""In which units amplitudes are drawn: micrometres and mm/N, or those that the channels have where they are not
calibrated."""

from dataclasses import dataclass

from updamp.comparison.comparison import Comparison


@dataclass(frozen=True)
class DrawnUnits:
    """displacement, receptance: unit, and what numbers in m and m/N are multiplied by; stiffness, damping: units"""

    displacement: tuple[str, float] = ("µm", 1e6)
    receptance: tuple[str, float] = ("mm/N", 1e3)
    stiffness: str = "N/m"
    damping: str = "N s/m"


def drawn_units(comparison: Comparison) -> DrawnUnits:
    response, force = comparison.response_unit, comparison.force_unit
    if (response, force) == ("m", "N"):
        return DrawnUnits()
    return DrawnUnits((response, 1.0), (f"{response}/{force}", 1.0), f"{force}/{response}", f"{force} s/{response}")
