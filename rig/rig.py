"""The input model: what a rig file states. Everything in it is in SI."""

import hashlib
import math
from collections.abc import Mapping
from functools import reduce
from typing import Annotated, Any, Literal, Self

from pydantic import (
    AfterValidator,
    Field,
    SerializerFunctionWrapHandler,
    StringConstraints,
    model_serializer,
    model_validator,
)
from pydantic_core import to_json

from updamp.rig.effects import Calibration, CalibrationTable, Effects
from updamp.rig.fields import InputTable, Quantity, damped
from updamp.rig.mesh_divisions import MeshDivisions
from updamp.rig.pressure import ByFacePressure, FePressure, PolynomialPressure, TwoAreaPressure, UniformPressure

# Bounds are far beyond any test rig, and far within what floating-point numbers and hexahedra can be computed with;
# what is merely odd is asked (questions.py). A thousandth of a millimetre is below every tolerance of manufacture.
Length = Annotated[float, Quantity("m", "5 mm", at_least=0.001, at_most=10_000)]
Force = Annotated[float, Quantity("N", "10 N", above=0, at_most=1e9)]
Frequency = Annotated[float, Quantity("Hz", "430 Hz", above=0, at_most=1e6)]
AreaStiffness = Annotated[float, Quantity("N/m^3", "60000 N/mm^3", above=0, at_most=1e12)]
Name = Annotated[str, StringConstraints(pattern=r"^[A-Za-z][A-Za-z0-9_-]*$")]


class Material(InputTable):
    """Linear elastic material: of the blades, and of a damper that states none of its own, [damper.material]. SI."""

    youngs_modulus: Annotated[float, Quantity("Pa", "197 GPa", above=0, at_most=2000)]
    poissons_ratio: Annotated[float, Field(strict=True, ge=0, le=0.49, examples=[0.3])]
    density: Annotated[float, Quantity("kg/m^3", "7800 kg/m^3", above=0, at_most=30_000)]
    loss_factor: Annotated[float, Field(strict=True, ge=0, lt=1, examples=[0.0009]), AfterValidator(damped)]


class Blade(InputTable):
    """The right-hand blade, an upright beam clamped at height 0. [m]"""

    height: Annotated[float, Quantity("m", "150 mm", at_least=0.001, at_most=10_000)]
    thickness: Length
    width: Length
    axis_offset: Length


class Platform(InputTable):
    """The platform on the blade's inner side. [m], underside_angle [rad] from the horizontal."""

    top: Length
    gap: Length
    edge_thickness: Length
    underside_angle: Annotated[float, Quantity("rad", "45 deg", at_least=15, at_most=80)]


class Damper(InputTable):
    """Wedge damper under both platforms; lengths of the face along the underside. [m]

    With apex_height 0 the damper ends at the upper end of its faces and apex_flat has no meaning.

    material: of the damper alone, with all keys of [material]; left out where it is that of the blades
    """

    face_start: Length
    face_length: Length
    apex_height: Annotated[float, Quantity("m", "0.5 mm", at_least=0, at_most=10_000)]
    apex_flat: Length
    base_height: Length
    material: Material | None = None

    @property
    def dimensions(self) -> Self:
        """Without the material: what a mesh depends on."""
        return self.model_copy(update={"material": None})

    @model_serializer(mode="wrap")
    def _without_material(self, handler: SerializerFunctionWrapHandler) -> dict[str, Any]:
        """A material that is not stated leaves no trace: what was stored before it existed still holds."""
        return {name: value for name, value in handler(self).items() if name != "material" or value is not None}


class Wire(InputTable):
    """The pulling wires, one to each end of the damper. [N/m], [m]"""

    axial_stiffness: Annotated[float, Quantity("N/m", "1e6 N/m", above=0, at_most=1e15)]
    length: Length
    attachment_height: Annotated[float, Quantity("m", "3 mm", at_least=-1000, at_most=1000)]


class Load(InputTable):
    """Static load: the pull of both wires together. [N]"""

    pull: Force


class ExcitationPoint(InputTable):
    """Harmonic force along x on the outer side of one blade, at mid-width. [m]"""

    blade: Literal["left", "right"]
    height: Length

    @property
    def point(self) -> str:
        """Of the models that are built of the rig"""
        return f"blade_{self.blade}.excitation.x"


class Response(InputTable):
    """Where the blades' response is measured, below their tips. [m]"""

    below_top: Length


class Contact(InputTable):
    """Contact between damper and platforms. Stiffness per area [N/m^3]; law and coupling by name."""

    law: Literal["jenkins_box", "jenkins_box_sampled", "coulomb_circle"]
    coupling: Literal["patch", "nearest_node"] = "patch"
    friction_coefficient: Annotated[float, Field(strict=True, ge=0, le=2, examples=[0.6])]
    tangential_stiffness: AreaStiffness
    normal_stiffness: AreaStiffness
    pressure: Annotated[
        UniformPressure | TwoAreaPressure | PolynomialPressure | ByFacePressure | FePressure,
        Field(discriminator="model"),
    ]


class Reduction(InputTable):
    """Modes of each component, and the solver of the linear systems by name."""

    modes: Annotated[int, Field(strict=True, ge=1, examples=[24])]
    solver: Literal["pardiso", "cholmod", "amg"] = "pardiso"


# What harmonics = "auto" begins with, and how far the peak may move by more of them, as a share of it.
FIRST_HARMONICS, USUAL_TOLERANCE = (0, 1, 2, 3), 0.01


class HarmonicBalance(InputTable):
    """Harmonics kept, time samples a period, and periods until the hysteresis has settled.

    tolerance: only with harmonics = "auto", which is read as the first harmonics tried: `updamp run` adds further ones
    to a curve until its peak moves by no more than this share. None where harmonics are stated
    """

    harmonics: Annotated[tuple[Annotated[int, Field(strict=True, ge=0)], ...], Field(examples=[[0, 1, 2, 3]])]
    time_samples: Annotated[int, Field(strict=True, ge=4, examples=[128])]
    cycles: Annotated[int, Field(strict=True, ge=2, examples=[2])]  # the first one still remembers the start
    tolerance: Annotated[float, Field(strict=True, gt=0, le=0.5, examples=[0.01])] | None = None

    @model_validator(mode="before")
    @classmethod
    def _automatic(cls, stated: Any) -> Any:
        if not isinstance(stated, Mapping):
            return stated
        if stated.get("harmonics") == "auto":
            return {"tolerance": USUAL_TOLERANCE, **stated, "harmonics": list(FIRST_HARMONICS)}
        if isinstance(stated.get("harmonics"), str):
            raise ValueError(f'harmonics = "{stated["harmonics"]}": state a list such as [0, 1, 2, 3], or "auto"')
        if stated.get("tolerance") is not None:
            raise ValueError(
                f'tolerance = {stated["tolerance"]}: goes with harmonics = "auto" alone; state that, or leave it out'
            )
        return stated

    @model_serializer(mode="wrap")
    def _without_tolerance(self, handler: SerializerFunctionWrapHandler) -> dict[str, Any]:
        """A tolerance that is not stated leaves no trace: what was stored before it existed still holds."""
        return {name: value for name, value in handler(self).items() if name != "tolerance" or value is not None}

    @model_validator(mode="after")
    def _complete(self) -> Self:
        stated = f"harmonics = {list(self.harmonics)}"
        if 1 not in self.harmonics:
            raise ValueError(f"{stated}: must contain 1, that of the excitation, such as [0, 1, 2, 3]")
        if list(self.harmonics) != sorted(set(self.harmonics)):
            raise ValueError(f"{stated}: must increase, each stated once, such as [0, 1, 2, 3]")
        if self.time_samples <= (needed := 2 * max(self.harmonics)):
            raise ValueError(f"time_samples = {self.time_samples}: must be above {needed}, twice the highest harmonic")
        return self


def _ordered(window: tuple[float, float]) -> tuple[float, float]:
    if not window[0] < window[1]:
        raise ValueError('the lower frequency comes first and is below the upper one, such as ["434 Hz", "446 Hz"]')
    return window


def _each_once(forces: tuple[float, ...]) -> tuple[float, ...]:
    if len(set(forces)) < len(forces):
        raise ValueError('each force level is stated once, such as ["0.96 N", "17 N"]')
    return forces


class ModeStudy(InputTable):
    """Frequencies in which a mode's response is sought, (lower, upper). [Hz]"""

    window: Annotated[tuple[Frequency, Frequency], AfterValidator(_ordered), Field(examples=[["434 Hz", "446 Hz"]])]


class Study(InputTable):
    """Amplitudes of the excitation [N] and the modes to follow."""

    force_levels: Annotated[
        tuple[Force, ...], Field(min_length=1, examples=[["0.96 N", "17 N"]]), AfterValidator(_each_once)
    ]
    modes: Annotated[Mapping[Name, ModeStudy], Field(min_length=1)]


class Rig(InputTable):
    """A rig and the study made on it: exactly the keys of a rig file, checked, in SI.

    Heights are measured from the root, half-widths from the plane of symmetry.
    """

    name: Name
    damper_model: Literal["elastic", "lumped"] = "elastic"
    material: Material
    blade: Blade
    platform: Platform
    damper: Damper
    wire: Wire
    load: Load
    excitation: ExcitationPoint
    response: Response
    contact: Contact
    reduction: Reduction
    harmonic_balance: HarmonicBalance
    study: Study
    mesh: Annotated[Mapping[Name, MeshDivisions], Field(min_length=1)]
    effects: Effects = ()
    calibration: CalibrationTable = Calibration()

    @property
    def response_point(self) -> str:
        """Where peaks are told: the tip of the excited blade."""
        return f"blade_{self.excitation.blade}.tip.x"

    @property
    def windows(self) -> dict[str, tuple[float, float]]:
        """Mode of the study -> window of its curve [Hz]"""
        return {name: mode.window for name, mode in self.study.modes.items()}

    @property
    def damper_material(self) -> Material:
        """Its own where the file states one, else that of the blades."""
        return self.damper.material or self.material

    @property
    def loss_factors(self) -> dict[str, float]:
        """Component -> of its material"""
        blades = self.material.loss_factor
        return {"blade_left": blades, "blade_right": blades, "damper": self.damper_material.loss_factor}

    @property
    def underside_length(self) -> float:
        """Of the platform's sloping underside, from its inner edge to the stem. [m]"""
        reach = self.blade.axis_offset - self.blade.thickness / 2 - self.platform.gap / 2
        return reach / math.cos(self.platform.underside_angle)

    @property
    def edge_height(self) -> float:
        """Of the underside's upper end, at the gap. [m]"""
        return self.platform.top - self.platform.edge_thickness

    @property
    def junction_height(self) -> float:
        """Of the junction of underside and stem. [m]"""
        return self.edge_height - self.underside_length * math.sin(self.platform.underside_angle)

    def underside_point(self, distance: float) -> tuple[float, float]:
        """(x, y) on the right-hand underside at a distance along it from its inner edge. [m]"""
        angle = self.platform.underside_angle
        return self.platform.gap / 2 + distance * math.cos(angle), self.edge_height - distance * math.sin(angle)

    @property
    def face_top(self) -> tuple[float, float]:
        """(half-width, height) at the upper end of the damper's faces. [m]"""
        return self.underside_point(self.damper.face_start)

    @property
    def face_bottom(self) -> tuple[float, float]:
        """(half-width, height) at the lower end of the damper's faces. [m]"""
        return self.underside_point(self.damper.face_start + self.damper.face_length)

    @property
    def face_area(self) -> float:
        """Of one contact face. [m^2]"""
        return self.damper.face_length * self.blade.width

    @property
    def response_height(self) -> float:
        """Of the response points at the tips. [m]"""
        return self.blade.height - self.response.below_top

    @property
    def state(self) -> str:
        """SHA-256 of all that the file states."""
        return self.digest(*type(self).model_fields, *(table for table in APART if self.states(table)))

    def digest(self, *keys: str) -> str:
        """SHA-256 of what stands under the keys (dotted paths, such as "contact.pressure" or "mesh.full"); what is in
        a table of `APART` enters by its own keys alone."""
        return hashlib.sha256(to_json([(key, _keyed(self._at(key))) for key in keys])).hexdigest()

    def states(self, key: str) -> bool:
        """Whether something stands under a key that may be left out, such as "effects" or "damper.material.density"."""
        found = self._at(key)
        return isinstance(found, float) or bool(found)

    def _at(self, key: str) -> Any:
        return reduce(_entry, key.split("."), self)


# Tables within others that have keys of their own in `Rig.digest`: the mesh depends on the damper's dimensions and not
# on its material.
APART = ("damper.material",)


def _entry(table: Any, key: str) -> Any:
    """None below a table that is left out."""
    if table is None:
        return None
    return table[key] if isinstance(table, Mapping) else getattr(table, key)


def _keyed(entry: Any) -> Any:
    return entry.dimensions if isinstance(entry, Damper) else entry
