"""What an engineer reads off the shape of a missing force."""

from collections.abc import Callable, Mapping
from dataclasses import dataclass

import numpy as np

from updamp.diagnosis.missing_force.force_shapes import Law, Shape, Term


@dataclass(frozen=True)
class Place:
    """point: of the channel that stiffness and damping are for; amplitude: largest of the mode there [m]
    omega: at which most is seen of the mode [rad/s]"""

    point: str
    amplitude: float
    omega: float


def reading(shape: Shape, place: Place) -> str:
    """Sentences without a full stop at the end, for a grounded element at the channel that would do the same."""
    claimed = [
        _said(term, kinds, place)
        for term, kinds in ((shape.stiffness, _OF_STIFFNESS), (shape.damping, _OF_DAMPING))
        if term.law.power is not None
    ]
    if not claimed:
        if shape.simple:
            return "nothing is missing beyond the scatter that calibration could not take up"
        return "a force is missing, but it follows no simple law of amplitude: look at the picture"
    if _is_microslip(shape):
        claimed.append("both together are what micro-slip in a joint does")
    if not shape.simple:
        claimed.append("this is the best of the simple laws, but amplitude by amplitude the force departs from it")
    return "; ".join(claimed)


def _said(term: Term, kinds: "Mapping[str, _Kind]", place: Place) -> str:
    text = kinds[term.law.name].said(term, place)
    if term.rivals:
        others = " or ".join(kinds[law.name].short(law) for law in term.rivals)
        text += f" (these data could not tell it from {others})"
    return text


def _is_microslip(shape: Shape) -> bool:
    """Softer and more damped the larger the amplitude."""
    softer = shape.stiffness.law.name == "rising" and shape.stiffness.size < 0
    more = shape.damping.law.name in ("rising", "quadratic") and shape.damping.size > 0
    return softer and more


@dataclass(frozen=True)
class _Kind:
    """said(term, place): the sentence; name: of the law among others"""

    said: Callable[[Term, Place], str]
    name: str

    def short(self, law: Law) -> str:
        return self.name.format(power=law.power)


def _number(value: float, deviation: float, unit: str) -> str:
    """With as many digits as the deviation allows."""
    if not deviation > 0 or value == 0:
        return f"{value:.3g} {unit}"
    digits = int(np.clip(np.floor(np.log10(abs(value) / deviation)) + 2, 2, 4))
    return f"{value:.{digits}g} ± {deviation:.1g} {unit}"


def _constant(term: Term, place: Place) -> str:
    size, where = _number(abs(term.size), term.deviation, "N/m"), f"at {place.point} at every amplitude"
    if term.size > 0:
        return f"stiffness is missing, {size} {where}, as of a spring or a stiffer support"
    per = 1e3 / place.omega**2
    mass = _number(-per * term.size, per * term.deviation, "g")
    return (
        f"the model is too stiff by {size} {where}: a softer support, or a further mass of {mass} (a mass shows as "
        "stiffness that falls with the square of frequency from mode to mode)"
    )


def _cubic(term: Term, place: Place) -> str:
    # k_3 u^3 at amplitude A is as stiff as 3/4 k_3 A^2
    per = 4 / 3 / place.amplitude**2
    number = _number(per * abs(term.size), per * term.deviation, "N/m^3")
    if term.size > 0:
        how, kind = "stiffness is missing that grows with the square of amplitude", "hardening"
    else:
        how, kind = "the model is too stiff, by what grows with the square of amplitude", "softening"
    return f"{how}, as of a {kind} cubic spring of {number} at {place.point}"


def _falling(term: Term, place: Place) -> str:
    how = "is missing" if term.size > 0 else "is too much"
    return (
        f"stiffness {how} at small amplitudes, and less so at large ones, as where a contact sticks that slips later "
        f"({_where(term, place, 'N/m')})"
    )


def _rising(term: Term, place: Place) -> str:
    if term.size > 0:
        how = "stiffness is missing the more, the larger the amplitude"
    else:
        how = "the structure softens with amplitude more than the model"
    return f"{how} ({_where(term, place, 'N/m')})"


def _viscous(term: Term, place: Place) -> str:
    size = f"{_number(abs(term.size), term.deviation, 'N s/m')} at {place.point} at every amplitude"
    if term.size > 0:
        return f"damping is missing, {size}, as of a viscous damper or of a material that damps more"
    return f"the model has too much damping, by {size}: material or viscous damping is set too high"


def _quadratic(term: Term, place: Place) -> str:
    if term.size < 0:
        return f"the model has too much damping, in proportion to amplitude ({_where(term, place, 'N s/m')})"
    # |u| v with coefficient b takes as much as a dashpot 4 b A / (3 pi), |v| v as one of 8 b w A / (3 pi)
    numbers = [
        _number(per * term.size, per * term.deviation, unit)
        for per, unit in (
            (3 * np.pi / (4 * place.amplitude), "N s/m^2"),
            (3 * np.pi / (8 * place.omega * place.amplitude), "N s^2/m^2"),
        )
    ]
    return (
        f"damping is missing in proportion to amplitude, as of a quadratic damper at {place.point}: {numbers[0]} times "
        f"|u| v, or {numbers[1]} times |v| v (air, an orifice, a joint)"
    )


def _coulomb(term: Term, place: Place) -> str:
    if term.size < 0:
        how = "which falls with 1/amplitude as that of dry friction"
        return f"the model has too much damping, {how} ({_where(term, place, 'N s/m')})"
    # a slip force F takes as much as a dashpot 4 F / (pi w A)
    per = np.pi * place.omega * place.amplitude / 4
    number = _number(per * term.size, per * term.deviation, "N")
    return f"damping is missing that falls with 1/amplitude, as of dry friction of {number} at {place.point}"


def _less_damping(term: Term, place: Place) -> str:
    how = "is missing" if term.size > 0 else "is too much"
    return f"damping {how} at small amplitudes most ({_where(term, place, 'N s/m')})"


def _more_damping(term: Term, place: Place) -> str:
    where = _where(term, place, "N s/m")
    if term.size < 0:
        return f"the model has too much damping at large amplitudes ({where})"
    return f"damping is missing that rises with amplitude ({where}), as of micro-slip in a joint"


def _where(term: Term, place: Place, unit: str) -> str:
    size = _number(abs(term.size), term.deviation, unit)
    return f"{size} at {1e6 * place.amplitude:.3g} µm, in proportion to amplitude to the power {term.law.power:g}"


_OF_STIFFNESS = {
    "constant": _Kind(_constant, "a constant stiffness"),
    "cubic": _Kind(_cubic, "a cubic spring"),
    "falling": _Kind(_falling, "stiffness that falls with amplitude"),
    "rising": _Kind(_rising, "stiffness that changes with amplitude to the power {power:g}"),
    "nothing": _Kind(_constant, "none"),
}
_OF_DAMPING = {
    "viscous": _Kind(_viscous, "viscous damping"),
    "quadratic": _Kind(_quadratic, "a quadratic damper"),
    "Coulomb": _Kind(_coulomb, "dry friction"),
    "falling": _Kind(_less_damping, "damping that falls with amplitude"),
    "rising": _Kind(_more_damping, "damping that rises with amplitude to the power {power:g}"),
    "nothing": _Kind(_viscous, "none"),
}
