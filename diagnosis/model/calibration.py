"""The calibration that a rig file has taken up:

[calibration]
origin = "fitted with edge_gap to ..., 2026-11-20"
friction_coefficient = 0.94       # factors on the rig file's own values
"""

import math
from collections.abc import Mapping
from difflib import get_close_matches

from updamp.diagnosis.model.parameters import OF_MODES, OF_RIG, Nuisance, nuisances
from updamp.diagnosis.model.rig_model import RigModel
from updamp.rig_effects import Calibration
from updamp.rig_errors import RigError

_KNOWN = {nuisance.name: nuisance for nuisance in (*OF_RIG, *OF_MODES)}


def read_calibration(table: object) -> Calibration:
    """From the table [calibration] of a rig file, as read.

    raises: RigError with every problem found, one a line
    """
    if not isinstance(table, Mapping):
        raise RigError("calibration: a table of factors is wanted: [calibration] with friction_coefficient = 0.94")
    stated = dict(table)
    origin = stated.pop("origin", "")
    problems = [line for name, factor in stated.items() if (line := _problem(name, factor))]
    if not isinstance(origin, str):
        problems.append(f"calibration.origin = {origin!r}: text is wanted that says where the factors come from")
    if problems:
        raise RigError("\n".join(problems))
    return Calibration(factors={name: float(factor) for name, factor in stated.items()}, origin=origin)


def _problem(name: str, factor: object) -> str:
    if name not in _KNOWN:
        close = get_close_matches(name, _KNOWN, n=1)
        known = f"did you mean {close[0]}?" if close else f"allowed are {', '.join(_KNOWN)}"
        return f"calibration.{name}: unknown factor; {known}"
    lowest, highest = bounds(_KNOWN[name])
    if isinstance(factor, bool) or not isinstance(factor, int | float):
        return f"calibration.{name} = {factor!r}: a factor is wanted, a plain number such as 1.02"
    if not lowest <= factor <= highest:
        return f"calibration.{name} = {factor!r}: out of range: allowed is {lowest:.4g} to {highest:.4g}"
    return ""


def bounds(nuisance: Nuisance) -> tuple[float, float]:
    """Of its factor."""
    return math.exp(-nuisance.largest), math.exp(nuisance.largest)


def calibrated(model: RigModel, calibration: Calibration) -> RigModel:
    """The model with the factors applied.

    raises: ValueError for a factor that the model has no place for
    """
    places = {nuisance.name: nuisance for nuisance in nuisances(model)}
    for name, factor in calibration.factors.items():
        if name not in places:
            raise ValueError(
                f"calibration.{name}: this model has no place for it; it has {', '.join(places)}; take the line out"
            )
        model = places[name].apply(model, factor)
    return model
