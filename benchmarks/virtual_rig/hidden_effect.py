"""What can be hidden in the bench: a name, values for three strengths, and what it does physically."""

from collections.abc import Callable, Mapping
from dataclasses import dataclass

from virtual_rig.bench import Bench

from updamp.rig import Rig

Values = Mapping[str, float]
STRENGTHS = ("weak", "medium", "strong")


@dataclass(frozen=True)
class HiddenEffect:
    """strengths: "weak", "medium", "strong" -> values; apply(bench, values, rig) -> the bench with it"""

    name: str
    sentence: str
    strengths: Mapping[str, Values]
    apply: Callable[[Bench, Values, Rig], Bench]
    in_catalogue: bool = True


@dataclass(frozen=True)
class Hidden:
    """One that is hidden in a measurement. strength: for the record, "" where the values are not those of one"""

    name: str
    values: Values
    strength: str = ""


def strengths(parameter: str, weak: float, medium: float, strong: float) -> dict[str, Values]:
    return {name: {parameter: value} for name, value in zip(STRENGTHS, (weak, medium, strong), strict=True)}
