"""A rig given by the modes of a test instead of by its geometry: a linear model without finite elements or contacts.

The rig file says `kind = "modal"`. Receptance of its modes r (D. J. Ewins, Modal Testing, 2000, ch. 2):

    H_jk(w) = sum_r phi_jr phi_kr / (w_r^2 (1 + i eta_r) - w^2)            (loss factor)
    H_jk(w) = sum_r phi_jr phi_kr / (w_r^2 + 2 i zeta_r w_r w - w^2)       (damping ratio)
"""

import math
from collections.abc import Mapping
from typing import Annotated, Any, Literal, Self

from pydantic import BeforeValidator, Field, StringConstraints, model_validator

from updamp.rig.effects import Calibration, CalibrationTable, Effects
from updamp.rig.fields import InputTable, Quantity
from updamp.rig.rig import Frequency, HarmonicBalance, Name

Point = Annotated[str, StringConstraints(pattern=r"^[A-Za-z][\w-]*(\.[A-Za-z][\w-]*)*\.[xyz]$")]

_NORMALISED = Quantity("kg^-0.5", "0.8 kg^-0.5")
ABOUT_A_MODE = 0.05  # of its frequency to both sides: the window of a mode identified in a test
_BALANCE = HarmonicBalance(harmonics=(1,), time_samples=128, cycles=2)


class Mode(InputTable):
    """frequency, undamped [Hz]; damping by `loss_factor` (hysteretic) or `damping_ratio` (viscous), one of them.

    shape: point -> displacement. With `modal_mass` [kg] in any scale, plain numbers ("the mass of an oscillator that
    moves by 1 where the shape says 1"); without it mass-normalised, with unit [kg^-1/2].
    """

    frequency: Frequency
    loss_factor: Annotated[float, Field(strict=True, ge=0, lt=1, examples=[0.006])] | None = None
    damping_ratio: Annotated[float, Field(strict=True, ge=0, lt=1, examples=[0.003])] | None = None
    modal_mass: Annotated[float, Quantity("kg", "1.2 kg", above=0)] | None = None
    shape: Annotated[Mapping[Point, Any], Field(min_length=1, examples=[{"beam.drive.x": 1.0}])]

    @model_validator(mode="after")
    def _one_damping(self) -> Self:
        if (self.loss_factor is None) == (self.damping_ratio is None):
            stated = "neither is" if self.loss_factor is None else "both are"
            raise ValueError(
                f"loss_factor, damping_ratio: {stated} stated; state one of them, such as loss_factor = 0.006"
            )
        return self

    @model_validator(mode="after")
    def _shape_in_its_unit(self) -> Self:
        if problems := [line for point in self.shape for line in self._problem(point)]:
            raise ValueError("\n".join(problems))
        if not any(self._entry(value) for value in self.shape.values()):
            raise ValueError("shape: the mode moves at none of its points; state those where it does")
        return self

    def _problem(self, point: str) -> list[str]:
        try:
            self._entry(self.shape[point])
        except ValueError as error:
            return [f'shape."{point}" = {self.shape[point]!r}: {error}']
        return []

    def _entry(self, value: object) -> float:
        if self.modal_mass is None:
            if isinstance(value, str):
                return _NORMALISED.to_si(value)
            raise ValueError(
                "without modal_mass shapes are mass-normalised: state the unit as text, such as "
                f'"{_NORMALISED.example}", or add modal_mass = "1.2 kg"'
            )
        if isinstance(value, bool) or not isinstance(value, int | float) or not math.isfinite(value):
            raise ValueError("with modal_mass the shape is a plain number, such as 1.0")
        return float(value)

    @property
    def normalised(self) -> dict[str, float]:
        """Point -> mass-normalised displacement [kg^-1/2]"""
        scale = 1.0 if self.modal_mass is None else 1 / math.sqrt(self.modal_mass)
        return {point: scale * self._entry(value) for point, value in self.shape.items()}


def _with_usual(stated: Any) -> Any:
    """What a table leaves out is as where there is none."""
    return {**_BALANCE.model_dump(), **stated} if isinstance(stated, Mapping) else stated


class ModalRig(InputTable):
    """Exactly the keys of a modal rig file, checked, in SI. A mode does not move at points that its shape leaves out.

    harmonic_balance: for effects that are tried on the model; by itself it is linear
    """

    kind: Literal["modal"]
    name: Name
    excitation: Point
    modes: Annotated[Mapping[Name, Mode], Field(min_length=1)]
    harmonic_balance: Annotated[HarmonicBalance, BeforeValidator(_with_usual)] = _BALANCE
    effects: Effects = ()
    calibration: CalibrationTable = Calibration()

    @model_validator(mode="after")
    def _excited(self) -> Self:
        if self.excitation not in self.points:
            raise ValueError(
                f'excitation = "{self.excitation}": no mode has a shape there; points are {", ".join(self.points)}'
            )
        return self

    @property
    def response_point(self) -> str:
        """Where peaks are told."""
        return self.excitation

    @property
    def windows(self) -> dict[str, tuple[float, float]]:
        """Mode -> window of its curve, about the frequency that the file states [Hz]"""
        at = {name: mode.frequency for name, mode in self.modes.items()}
        return {name: (f * (1 - ABOUT_A_MODE), f * (1 + ABOUT_A_MODE)) for name, f in at.items()}

    @property
    def points(self) -> tuple[str, ...]:
        """Those of all modes, in the order of the file."""
        return tuple(dict.fromkeys(point for mode in self.modes.values() for point in mode.shape))
