"""Complex amplitudes whose phases, or imaginary parts, have a column or variable of their own."""

from collections.abc import Callable, Iterator, Mapping
from pathlib import Path
from typing import Annotated, Literal, Self

import numpy as np
from pydantic import Field, model_validator

from updamp.measurement.measurement import MeasurementError, near
from updamp.measurement.recorded import Complex, Floats, complex_of
from updamp.rig.fields import InputTable

_TO_RADIANS = {"rad": 1.0, "deg": np.pi / 180}
Name = Annotated[str, Field(examples=["tip_phase"])]


class SeparateParts(InputTable):
    """phase: label -> where its phase is; imaginary: label -> where its imaginary part is. A channel with neither is
    as it stands: the force that the phases refer to, or an amplitude alone."""

    phase: Mapping[str, Name] = {}
    phase_unit: Literal["rad", "deg"] | None = None
    imaginary: Mapping[str, Name] = {}

    @model_validator(mode="after")
    def _phases_are_clear(self) -> Self:
        if self.phase and self.phase_unit is None:
            raise ValueError('phase_unit: missing; add it, such as phase_unit = "deg"')
        if both := set(self.phase) & set(self.imaginary):
            raise ValueError(f"phase: {', '.join(sorted(both))} has a phase and an imaginary part; keep one of them")
        return self

    def parts_of(self, label: str) -> Iterator[str]:
        """Where else numbers of a label are"""
        yield from (table[label] for table in (self.phase, self.imaginary) if label in table)

    def together(self, label: str, values: Complex, part: Callable[[str], Floats]) -> Complex:
        """Values of a label with its phase or imaginary part. part: numbers by where they are, shaped as the values"""
        if label in self.imaginary:
            return complex_of(np.real(values), part(self.imaginary[label]))
        if label in self.phase:
            assert self.phase_unit is not None
            turned = np.exp(1j * _TO_RADIANS[self.phase_unit] * part(self.phase[label]))
            with np.errstate(invalid="ignore"):  # infinities are refused later, with their place
                return np.asarray(values * turned)
        return values

    def check_labels(self, path: Path, labels: tuple[str, ...], what: str) -> None:
        """raises: MeasurementError for a phase or imaginary part of what is no channel, or that is its own amplitude

        what: a label is, such as "column"
        """
        for key, table in (("phase", self.phase), ("imaginary", self.imaginary)):
            for label, place in table.items():
                if label not in labels:
                    raise MeasurementError(
                        f'{path}: options.{key}: "{label}" = "{place}": no channel has the label "{label}"; '
                        f"{near(label, labels)} (a label is the name of the amplitude's {what})"
                    )
                if label == place:
                    other = "phase" if key == "phase" else "imaginary part"
                    raise MeasurementError(
                        f'{path}: options.{key}: "{label}" = "{place}" is the {what} of the amplitude itself; name '
                        f"that of its {other}"
                    )
