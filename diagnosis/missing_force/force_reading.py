"""What an engineer reads off the law of a missing force."""

from collections.abc import Callable, Mapping
from dataclasses import dataclass

import numpy as np

from updamp.diagnosis.missing_force.force_laws import FittedLaw, ForceLaw, PowerLaw


@dataclass(frozen=True)
class ReferenceMotion:
    """A mode's motion that sizes are stated at. point: of the channel that stiffness and damping are for
    amplitude: the mode's largest there [m]; omega: angular frequency at which most is seen of the mode [rad/s]"""

    point: str
    amplitude: float
    omega: float


def reading(force: ForceLaw, reference: ReferenceMotion) -> str:
    """Sentences without a full stop at the end, for a grounded element at the channel that would do the same."""
    claimed = [
        _sentence(fitted, kinds, reference)
        for fitted, kinds in ((force.stiffness, _OF_STIFFNESS), (force.damping, _OF_DAMPING))
        if fitted.law.power is not None
    ]
    if not claimed:
        if force.simple:
            return "nothing is missing beyond the scatter that calibration could not take up"
        return "a force is missing, but it follows no simple law of amplitude: look at the picture"
    if _is_microslip(force):
        claimed.append("both together are what micro-slip in a joint does")
    if not force.simple:
        claimed.append("this is the best of the simple laws, but amplitude by amplitude the force departs from it")
    return "; ".join(claimed)


def _sentence(fitted: FittedLaw, kinds: "Mapping[str, _Kind]", reference: ReferenceMotion) -> str:
    text = kinds[fitted.law.name].sentence(fitted, reference)
    if fitted.alternatives:
        others = " or ".join(kinds[law.name].short(law) for law in fitted.alternatives)
        text += f" (these data could not tell it from {others})"
    return text


def _is_microslip(force: ForceLaw) -> bool:
    """Softer and more damped the larger the amplitude."""
    softer = force.stiffness.law.name == "rising" and force.stiffness.size < 0
    more = force.damping.law.name in ("rising", "quadratic") and force.damping.size > 0
    return softer and more


@dataclass(frozen=True)
class _Kind:
    """sentence: what a fitted law says of the missing force; name: of the law beside others"""

    sentence: Callable[[FittedLaw, ReferenceMotion], str]
    name: str

    def short(self, law: PowerLaw) -> str:
        return self.name.format(power=law.power)


def _number(value: float, deviation: float, unit: str) -> str:
    """With as many digits as the deviation allows."""
    if not deviation > 0 or value == 0:
        return f"{value:.3g} {unit}"
    digits = int(np.clip(np.floor(np.log10(abs(value) / deviation)) + 2, 2, 4))
    return f"{value:.{digits}g} ± {deviation:.1g} {unit}"


def _constant(fitted: FittedLaw, reference: ReferenceMotion) -> str:
    size, where = _number(abs(fitted.size), fitted.deviation, "N/m"), f"at {reference.point} at every amplitude"
    if fitted.size > 0:
        return f"stiffness is missing, {size} {where}, as of a spring or a stiffer support"
    per = 1e3 / reference.omega**2
    mass = _number(-per * fitted.size, per * fitted.deviation, "g")
    return (
        f"the model is too stiff by {size} {where}: a softer support, or a further mass of {mass} (a mass shows as "
        "stiffness that falls with the square of frequency from mode to mode)"
    )


def _cubic(fitted: FittedLaw, reference: ReferenceMotion) -> str:
    # k_3 u^3 at amplitude A is as stiff as 3/4 k_3 A^2
    per = 4 / 3 / reference.amplitude**2
    number = _number(per * abs(fitted.size), per * fitted.deviation, "N/m^3")
    if fitted.size > 0:
        how, kind = "stiffness is missing that grows with the square of amplitude", "hardening"
    else:
        how, kind = "the model is too stiff, by what grows with the square of amplitude", "softening"
    return f"{how}, as of a {kind} cubic spring of {number} at {reference.point}"


def _falling(fitted: FittedLaw, reference: ReferenceMotion) -> str:
    how = "is missing" if fitted.size > 0 else "is too much"
    return (
        f"stiffness {how} at small amplitudes, and less so at large ones, as where a contact sticks that slips later "
        f"({_where(fitted, reference, 'N/m')})"
    )


def _rising(fitted: FittedLaw, reference: ReferenceMotion) -> str:
    if fitted.size > 0:
        how = "stiffness is missing the more, the larger the amplitude"
    else:
        how = "the structure softens with amplitude more than the model"
    return f"{how} ({_where(fitted, reference, 'N/m')})"


def _viscous(fitted: FittedLaw, reference: ReferenceMotion) -> str:
    size = f"{_number(abs(fitted.size), fitted.deviation, 'N s/m')} at {reference.point} at every amplitude"
    if fitted.size > 0:
        return f"damping is missing, {size}, as of a viscous damper or of a material that damps more"
    return f"the model has too much damping, by {size}: material or viscous damping is set too high"


def _quadratic(fitted: FittedLaw, reference: ReferenceMotion) -> str:
    if fitted.size < 0:
        return f"the model has too much damping, in proportion to amplitude ({_where(fitted, reference, 'N s/m')})"
    # |u| v with coefficient b takes as much as a dashpot 4 b A / (3 pi), |v| v as one of 8 b w A / (3 pi)
    numbers = [
        _number(per * fitted.size, per * fitted.deviation, unit)
        for per, unit in (
            (3 * np.pi / (4 * reference.amplitude), "N s/m^2"),
            (3 * np.pi / (8 * reference.omega * reference.amplitude), "N s^2/m^2"),
        )
    ]
    return (
        f"damping is missing in proportion to amplitude, as of a quadratic damper at {reference.point}: {numbers[0]} "
        f"times |u| v, or {numbers[1]} times |v| v (air, an orifice, a joint)"
    )


def _coulomb(fitted: FittedLaw, reference: ReferenceMotion) -> str:
    if fitted.size < 0:
        how = "which falls with 1/amplitude as that of dry friction"
        return f"the model has too much damping, {how} ({_where(fitted, reference, 'N s/m')})"
    # a slip force F takes as much as a dashpot 4 F / (pi w A)
    per = np.pi * reference.omega * reference.amplitude / 4
    number = _number(per * fitted.size, per * fitted.deviation, "N")
    return f"damping is missing that falls with 1/amplitude, as of dry friction of {number} at {reference.point}"


def _less_damping(fitted: FittedLaw, reference: ReferenceMotion) -> str:
    how = "is missing" if fitted.size > 0 else "is too much"
    return f"damping {how} at small amplitudes most ({_where(fitted, reference, 'N s/m')})"


def _more_damping(fitted: FittedLaw, reference: ReferenceMotion) -> str:
    where = _where(fitted, reference, "N s/m")
    if fitted.size < 0:
        return f"the model has too much damping at large amplitudes ({where})"
    assert fitted.law.power is not None, "it rises with one"
    by = f"a force by the power {fitted.law.power + 1:g} of the velocity, or, where stiffness is lost too, micro-slip"
    return f"damping is missing that rises with amplitude ({where}), as of {by}"


def _where(fitted: FittedLaw, reference: ReferenceMotion, unit: str) -> str:
    size = _number(abs(fitted.size), fitted.deviation, unit)
    return f"{size} at {1e6 * reference.amplitude:.3g} µm, in proportion to amplitude to the power {fitted.law.power:g}"


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
