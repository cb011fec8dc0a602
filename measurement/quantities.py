"""Sensors' readings to peak displacements (or forces) in SI."""

import re
from collections.abc import Mapping
from contextlib import suppress
from dataclasses import dataclass

import numpy as np

from updamp.measurement.recorded import Complex, Floats
from updamp.rig.fields import LOGARITHMIC, Quantity, is_logarithmic


@dataclass(frozen=True)
class SensorQuantity:
    """si: its unit; example: as a person would write it; derivatives: of the displacement, None for a force"""

    si: str
    example: str
    derivatives: int | None


QUANTITIES: Mapping[str, SensorQuantity] = {
    "displacement": SensorQuantity("m", "2 mm", 0),
    "velocity": SensorQuantity("m/s", "30 mm/s", 1),
    "acceleration": SensorQuantity("m/s^2", "5 m/s^2", 2),
    "force": SensorQuantity("N", "17 N", None),
}

# What a stated amplitude is to be multiplied by to give the peak value.
AMPLITUDES: Mapping[str, float] = {"peak": 1.0, "rms": float(np.sqrt(2)), "peak_to_peak": 0.5}

# The standard gravity as people and programs call it; to pint they are gram, gauss and nothing.
GRAVITY: Mapping[str, str] = dict.fromkeys(("g", "G", "gn", "g_n", "g0"), "g_0")
# What programs write behind a unit: what kind of value of a vibration it is of.
_KINDS: Mapping[str, str] = {
    "rms": "rms", "eff": "rms", "pk": "peak", "peak": "peak", "0-pk": "peak", "0-p": "peak", "pp": "peak_to_peak",
    "p-p": "peak_to_peak", "pk-pk": "peak_to_peak", "peak-to-peak": "peak_to_peak",
}  # fmt: skip
_OF_A_KIND = re.compile(rf"(.*\S)[\s_]+[(\[]?({'|'.join(_KINDS)})[)\]]?", re.IGNORECASE)
_POWER = re.compile(r"(?<=[A-Za-z])(-?\d)")  # a digit behind a letter


def si_factor(unit: str, quantity: str, uncalibrated: bool = False) -> float:
    """One of the unit in SI, 1 where it is not calibrated.

    raises: ValueError naming the key `unit`, what is wrong and what is allowed
    """
    if uncalibrated:
        if is_logarithmic(unit):
            raise ValueError(f'unit = "{unit}": {LOGARITHMIC}')
        return 1.0
    kind = QUANTITIES[quantity]
    example = kind.example.split(maxsplit=1)[1]
    try:
        return Quantity(kind.si, f"1 {example}").to_si(f"1 {unit}")
    except ValueError as error:
        text = str(error).replace(f'"1 {example}"', f'"{example}"')
        hint = '; for multiples of the standard gravity write "g_0" ("g" is gram, "G" gauss)' if unit in GRAVITY else ""
        if _is_over_force(unit, kind):
            hint = (
                f'; for a response divided by the force state the unit of the response alone, such as "{example}", and '
                f"per_force = true beside it"
            )
        raise ValueError(f'unit = "{unit}": for quantity = "{quantity}": {text}{hint}') from None


def _is_over_force(unit: str, kind: SensorQuantity) -> bool:
    """Whether it is one of the quantity over a force's, as a frequency response function is exported."""
    try:
        Quantity(f"{kind.si}/N", f"1 {kind.si}/N").to_si(f"1 {unit}")
    except ValueError:
        return False
    return True


def is_over_force(label: str) -> bool:
    """Whether a label in a data file is the unit of a response over that of a force."""
    responses = [kind for kind in QUANTITIES.values() if kind.derivatives is not None]
    return bool(label) and any(_is_over_force(one, kind) for one in spellings(label) for kind in responses)


def unit_and_kind(label: str) -> tuple[str, str]:
    """Of a label in a data file such as "mm/s RMS": the unit, and which of AMPLITUDES it says, "" for none."""
    found = _OF_A_KIND.fullmatch(label.strip())
    return (found[1], _KINDS[found[2].lower()]) if found else (label, "")


def spellings(label: str) -> tuple[str, ...]:
    """Of a unit in a data file, whose capitals are not to be relied on, nor its sign of a power ("m/s2", "mm s-1")."""
    plain = _POWER.sub(r"^\1", label.strip("()[] "))
    # no prefix is a capital K, and "kn" is a knot
    kilo = [f"k{plain[1:]}", f"k{plain[1:].capitalize()}"] if plain[:1] in ("K", "k") and len(plain) > 1 else []
    return tuple(dict.fromkeys((label, plain, *kilo, plain.lower(), plain.capitalize())))


def label_factor(label: str, quantity: str) -> float:
    """As `si_factor`, of a label in a data file; an acceleration in g or G is one of gravity. raises: ValueError"""
    for spelled in (GRAVITY.get(one, one) for one in spellings(label)):
        try:
            return si_factor(spelled, quantity)
        except ValueError:
            continue
    raise ValueError(f'unit = "{label}": not understood as that of a {quantity}')


def quantity_of_label(label: str) -> str:
    """What else than it should a label in a data file measures: a quantity, or a voltage; "" where nobody can say."""
    for spelled in (GRAVITY.get(one, one) for one in spellings(label)):
        for quantity in QUANTITIES:
            with suppress(ValueError):
                si_factor(spelled, quantity)
                return quantity
    for spelled in spellings(label):
        with suppress(ValueError):
            Quantity("V", "1 V").to_si(f"1 {spelled}")
            return "voltage"
    return ""


def to_displacement(amplitude: Complex, angular_frequency: Floats, quantity: str, phase_of: str | None) -> Complex:
    """Displacement amplitudes [m] from those of a displacement, velocity or acceleration in SI: x = a / (i w)^d.

    Where the file states the phase of another derivative, p, than its amplitude's: x = |a| exp(i phase) / w^d / i^p.

    angular_frequency: of the amplitude's own harmonic [rad/s], broadcast against it
    """
    derivatives, turned = QUANTITIES[quantity].derivatives, QUANTITIES[phase_of or quantity].derivatives
    assert derivatives is not None
    assert turned is not None
    return np.asarray(amplitude / angular_frequency**derivatives * (-1j) ** turned)
