"""What an effect is: a change of the model that an engineer has a name for, with parameters that can be fitted."""

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from math import isfinite

from updamp.effects.rig_model import RigModel

Values = Mapping[str, float]
# Between the name of a joint's effect and the point that it was placed at.
AT = "@"


@dataclass(frozen=True)
class EffectParameter:
    """null: the value at which the effect is absent; lower, upper: bounds; typical: size that rigs of this kind show,
    where a search starts; unit: as pint reads it, "" for none; source: where the typical size comes from
    ends: bounds that are as good as any other value, such as the whole where the parameter is a share of something; a
        fit that stands at another one asks for what makes no sense
    grows_with: powers of stiffness, amplitude and angular frequency of a mode that its size grows with where one is
        known by its modes: sizes here are those of a beam of 5e5 N/m at 0.1 mm and 80 Hz (`sized.py`)
    shape: it says how another parameter's effect grows, such as an exponent or a gap, and does nothing by itself
    two_sided: whether both signs (or both sides of the null) make sense
    """

    name: str
    null: float
    lower: float
    upper: float
    typical: float
    unit: str
    source: str
    ends: tuple[float, ...] = ()
    grows_with: tuple[int, int, int] = (0, 0, 0)
    shape: bool = False

    def allows(self, value: float) -> bool:
        """Whether a rig file may state it. Of what grows with the rig the sign alone is known beforehand: bounds that
        are right for a beam rule out what was measured on a wire."""
        if self.grows_with == (0, 0, 0):
            return self.lower <= value <= self.upper
        return isfinite(value) and (value > 0 or self.lower < 0 or value == self.lower)

    @property
    def allowed(self) -> str:
        """In words, with the unit."""
        if self.grows_with == (0, 0, 0):
            return f"{self.lower:g} to {self.upper:g} {self.unit}".rstrip()
        wanted = "finite value" if self.lower < 0 else "value from 0 on" if self.lower == 0 else "positive value"
        return f"any {wanted}, in {self.unit}"

    @property
    def two_sided(self) -> bool:
        return self.lower < self.null < self.upper

    @property
    def whole(self) -> float:
        """The end farthest from the null, in typical sizes; the typical size itself where there is no such end."""
        return max((abs((end - self.null) / (self.typical - self.null)) for end in self.ends), default=1.0)


@dataclass(frozen=True)
class Effect:
    """name: for the rig file and the command line; sentence: what an engineer would say is missing

    apply(model, values) -> model: at null values a model with the same response as the one given, and differentiable
        in the values there. Structural effects change `components` or `attachments`, effects in the contact change
        `contacts`; all of them leave the rest alone, so that effects can be stacked.
    finite_step: the effect cannot be differentiated at its null value; its signature is taken from a step to the
        typical value
    of_measurement: whether it is a fault of the measurement: of `reading` alone, not of what moves
    modes: of how many modes runs are needed to tell it from other effects
    joint: point of the joint that it was placed at (`placed.py`), "" where it stays at the excitation
    """

    name: str
    sentence: str
    parameters: tuple[EffectParameter, ...]
    apply: Callable[[RigModel, Values], RigModel]
    finite_step: bool = False
    of_measurement: bool = False
    modes: int = 1
    joint: str = ""

    @property
    def kind(self) -> str:
        """Its name without the place of the joint."""
        return self.name.partition(AT)[0]

    @property
    def in_words(self) -> str:
        """Its sentence, with what kind of a cause it is."""
        return f"fault of the measurement: {self.sentence}" if self.of_measurement else self.sentence

    @property
    def has_two_signs(self) -> bool:
        """Whether the effect turned round makes sense too."""
        return all(p.two_sided for p in self.parameters if not p.shape)

    def of_size(self, size: float) -> tuple[float, ...]:
        """Factors on its parameters, counted from their null values, for so many times its size: turned round, what
        shapes it stays."""
        return tuple(abs(size) if p.shape else size for p in self.parameters)

    @property
    def sizes(self) -> tuple[tuple[float, ...], ...]:
        """Where a search begins, in typical sizes of the parameters: there, turned round where that makes sense too,
        and whole where it may be and first order from elsewhere does not lead there."""
        found = [self.of_size(size) for size in ((1.0, -1.0) if self.has_two_signs else (1.0,))]
        if self.finite_step and any(p.ends for p in self.parameters):
            found.append(tuple(p.whole for p in self.parameters))
        return tuple(found)

    def at_null(self) -> dict[str, float]:
        return {p.name: p.null for p in self.parameters}

    def at_typical(self) -> dict[str, float]:
        return {p.name: p.typical for p in self.parameters}
