"""A number of a study file in the unit of the response that it limits or aims at."""

from updamp.rig.fields import Quantity


def in_unit_of(unit: str, stated: float | str) -> float:
    """raises: ValueError with an example, where the unit is missing, of another kind, or not wanted"""
    if not unit:
        if isinstance(stated, str):
            raise ValueError("a plain number is wanted, without a unit")
        return float(stated)
    return Quantity(unit, f"1 {unit}").in_unit(stated, unit)
