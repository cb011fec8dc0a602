"""How the pressure of the pull is spread over the contact faces: one table a model, told apart by `model`."""

import csv
import math
from pathlib import Path
from typing import Annotated, Any, Literal, Self

from pydantic import BeforeValidator, Field, ValidationInfo, model_validator

from updamp.rig.fields import InputTable, Quantity

ORDER = 4
COEFFICIENTS = (ORDER + 1) * (ORDER + 2) // 2


class UniformPressure(InputTable):
    """The same pressure everywhere, eq. (5) of Pesaresi et al. 2017."""

    model: Literal["uniform"]


class TwoAreaPressure(InputTable):
    """A strip in the middle of the damper's length, over the whole slope, carries its own share of the load.

    The pressure is uniform in the strip and uniform outside it.

    central_share: share of the load in the strip; 0.8 is the paper's 80/20
    central_fraction: the strip's part of the damper's length
    """

    model: Literal["two_area"]
    central_share: Annotated[float, Field(strict=True, ge=0, le=1, examples=[0.8])]
    central_fraction: Annotated[float, Field(strict=True, gt=0, lt=1, examples=[0.5])]


def _square(rows: Any) -> Any:
    """Rows of any length up to ORDER + 1, filled with zeros to a square table."""
    size = ORDER + 1
    if not isinstance(rows, (list, tuple)) or not all(isinstance(row, (list, tuple)) for row in rows):
        raise ValueError("a list of rows is wanted, row i for s^i and column j for z^j, such as [[1.0, 0.0, -0.5], []]")
    if len(rows) > size or any(len(row) > size - i and any(row[size - i :]) for i, row in enumerate(rows)):
        raise ValueError(f"the order i + j of s^i z^j is at most {ORDER}: row i has up to {size} - i entries")
    filled = [list(row) + [0.0] * (size - len(row)) for row in rows]
    return tuple(tuple(row[:size]) for row in filled + [[0.0] * size] * (size - len(rows)))


def _scan(name: Any, info: ValidationInfo) -> Any:
    """Samples (s, z, pressure) of the file, which is sought beside the rig file."""
    if not isinstance(name, str):
        raise ValueError('the path of a CSV file is wanted, such as "film.csv"')
    path = Path((info.context or {}).get("folder", "."), name)
    try:
        with path.open(newline="", encoding="utf-8") as lines:
            header, *rows = [[cell.strip() for cell in row] for row in csv.reader(lines) if row] or [[]]
    except (OSError, UnicodeDecodeError) as error:
        raise ValueError(
            f"{path} cannot be read ({getattr(error, 'strerror', error)}); give a CSV file with columns s,z,pressure"
        ) from None
    if header != ["s", "z", "pressure"]:
        raise ValueError(f"{path} must start with the line s,z,pressure, not {','.join(header)}")
    return tuple(_sample(row, f"{path}, sample {number}") for number, row in enumerate(rows, start=1))


def _sample(row: list[str], where: str) -> tuple[float, ...]:
    try:
        s, z, pressure = map(float, row)
    except ValueError:
        raise ValueError(f"{where}: three numbers are wanted, not {','.join(row)}") from None
    if not (abs(s) <= 1 and abs(z) <= 1):
        raise ValueError(f"{where}: s and z run from -1 to 1 over the face, not s = {s:g}, z = {z:g}")
    if not (math.isfinite(pressure) and pressure >= 0):
        raise ValueError(f"{where}: a pressure is at least 0, not {pressure:g}")
    return s, z, pressure


_Number = Annotated[float, Field(strict=True)]
Row = tuple[_Number, _Number, _Number, _Number, _Number]


class PolynomialPressure(InputTable):
    """Shape of the pressure as a 4th-order polynomial of (s, z), or as a scan to which one is fitted.

    s runs from -1 at the lower end of the face to 1 at the upper, z from -1 to 1 along the damper. Only the
    shape counts: it is scaled to the load.

    coefficients: [i][j] multiplies s^i z^j, i + j <= 4, as numpy's polyval2d takes it
    map: in the file the path of a CSV with the columns s,z,pressure (any unit); here its samples
    """

    model: Literal["polynomial"]
    coefficients: Annotated[tuple[Row, Row, Row, Row, Row] | None, BeforeValidator(_square)] = None
    map: Annotated[tuple[tuple[float, float, float], ...] | None, BeforeValidator(_scan)] = None

    @model_validator(mode="after")
    def _has_one_shape(self) -> Self:
        if (self.coefficients is None) == (self.map is None):
            raise ValueError('map: state either coefficients or map, such as map = "film.csv"')
        if self.coefficients is not None and not (mean := self._mean(self.coefficients)) > 0:
            raise ValueError(f"coefficients: their mean over the face is {mean:g}; it must be above 0, to be scaled")
        if self.map is not None and len(self.map) < COEFFICIENTS:
            raise ValueError(f"map: {len(self.map)} samples; a 4th-order fit needs at least {COEFFICIENTS}")
        if self.map is not None and not any(pressure > 0 for _, _, pressure in self.map):
            raise ValueError("map: some pressure must be above 0, to be scaled to the load")
        return self

    @staticmethod
    def _mean(coefficients: tuple[Row, ...]) -> float:
        """Over [-1, 1]^2: odd powers vanish, even ones leave 1 / (power + 1)."""
        even = range(0, ORDER + 1, 2)
        return sum(coefficients[i][j] / ((i + 1) * (j + 1)) for i in even for j in even)


StatedPressure = UniformPressure | TwoAreaPressure | PolynomialPressure


class SurfaceProfile(InputTable):
    """How the damper's faces deviate from planes: an initial opening of the contact. [m], [rad]

    crown_height, crown_radius: the face is crowned up its slope as a circle about an axis along the damper;
        it ends where it has fallen by the height. If one is left out, the crown ends at the face's ends.
    tilt: the face falls away along +z by this angle
    edge_rounding: radius of the face's upper and lower edges
    """

    crown_height: Annotated[float, Quantity("m", "2 um", above=0, at_most=10_000)] | None = None
    crown_radius: Annotated[float, Quantity("m", "2 m", above=0)] | None = None
    tilt: Annotated[float, Quantity("rad", "0.01 deg", at_least=-5, at_most=5)] = 0.0
    edge_rounding: Annotated[float, Quantity("m", "0.2 mm", at_least=0, at_most=10_000)] = 0.0

    def crown(self, face_length: float) -> tuple[float, float] | None:
        """(height, radius) of the crown on a face of this length [m], parabola for circle; None without one."""
        half = face_length / 2
        if self.crown_radius is None:
            return None if self.crown_height is None else (self.crown_height, half**2 / (2 * self.crown_height))
        return self.crown_height or half**2 / (2 * self.crown_radius), self.crown_radius


class ByFacePressure(InputTable):
    """A stated pressure of its own for each face, such as uniform on the left and 90/10 on the right.

    Each face carries the load of eq. (5) of Pesaresi et al. 2017, whatever its shape.
    """

    model: Literal["by_face"]
    left: Annotated[StatedPressure, Field(discriminator="model", examples=[{"model": "uniform"}])]
    right: Annotated[StatedPressure, Field(discriminator="model", examples=[{"model": "uniform"}])]


class FePressure(InputTable):
    """Unilateral contact, with Coulomb friction or without, on the compliance of the finite elements.

    pull_on: where the pull acts: on the damper's end faces, as wires do, or on its mass, as the centrifugal load does
    """

    model: Literal["fe"]
    pull_on: Literal["ends", "mass"] = "ends"
    friction: Annotated[bool, Field(strict=True)] = True
    profile: SurfaceProfile = SurfaceProfile()
