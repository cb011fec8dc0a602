"""What stands in the laboratory: everything physical that a hidden effect or an assembly may alter, in SI."""

from collections.abc import Callable, Mapping
from dataclasses import dataclass, replace
from math import cos, sin

import numpy as np
from numpy.typing import NDArray

from updamp.benchmarks.virtual_rig.bodies import Bodies
from updamp.rig.pressure import UniformPressure
from updamp.rig.rig import Rig

Floats = NDArray[np.float64]
# Displacement and velocity (n_time,) [m, m/s] -> force and its derivatives by both.
PointForce = Callable[[Floats, Floats], tuple[Floats, Floats, Floats]]


@dataclass(frozen=True, eq=False)
class Patches:
    """Of the contact, one entry a patch.

    mu [-]; kt, kn [N/m]; n0: pressing at rest [N]; gap: to be closed before the normal spring acts [m]
    viscosity: of a film, in all three directions while in contact [N s/m]
    speed_drop, speed_scale: mu (1 - speed_drop |v| / (|v| + speed_scale)), v the sliding speed [-, m/s]
    spread: half-width of the uniform distribution of slip limits about mu N within a patch, as a share of it
    exponent, stated_at: dN/du = kn (N / stated_at)^exponent, and as much for kt [-], (n,) [N]
    """

    mu: Floats
    kt: Floats
    kn: Floats
    n0: Floats
    gap: Floats
    viscosity: Floats
    speed_drop: float = 0.0
    speed_scale: float = 1e-3
    spread: float = 0.0
    exponent: float = 0.0
    stated_at: Floats | None = None

    @property
    def at_rest(self) -> Floats:
        """(n, 3) stiffness in t1, t2, n of a patch that sticks, for small motion about rest [N/m]"""
        k = np.column_stack([self.kt, self.kt, self.kn])
        return k if self.stated_at is None else k * ((self.n0 / self.stated_at) ** self.exponent)[:, None]


@dataclass(frozen=True, eq=False)
class BenchAttachment:
    """Linear, on the displacement sum_i weight_i u_i of points. dynamic_stiffness: at w [rad/s], complex [N/m]"""

    name: str
    direction: Mapping[str, float]
    dynamic_stiffness: Callable[[float], complex]


@dataclass(frozen=True, eq=False)
class BenchElement:
    """Nonlinear, on the displacement sum_i weight_i u_i of points."""

    name: str
    direction: Mapping[str, float]
    force: PointForce


@dataclass(frozen=True, eq=False)
class Bench:
    """loss_factor: hysteretic, of the blades; damper_loss: the damper's over that
    loss_growth: b in loss_factor (1 + b A), A the amplitude of the tip, each blade its own [1/m]
    tuning: factors on the frequencies of "blade_left", "blade_right" and "damper": those of another Young's modulus
    clamp_compliance: turning of each blade's root about z [rad/(N m)]
    mean_share: of the mean motion that the contacts see; 0 where the mean position is held
    force_drop: what the shaker's force loses unrecorded, see `stepped_sine.py`
    loose_gain: of the channel "tip_left", see `sensors.py`
    viscous_at: [rad/s] where viscous damping in place of the hysteretic is equal to it, None for hysteretic damping
    running_in: growth of the logarithm of friction from an assembly's first run to its last
    changes: relative, of dimensions that are other than the rig file says, by name; None for none
    """

    bodies: Bodies
    patches: Patches
    attachments: tuple[BenchAttachment, ...]
    excitation: str
    loss_factor: float
    elements: tuple[BenchElement, ...] = ()
    loss_growth: float = 0.0
    tuning: Mapping[str, float] | None = None
    clamp_compliance: float = 0.0
    mean_share: float = 0.0
    force_drop: float = 0.0
    loose_gain: float = 0.0
    viscous_at: float | None = None
    changes: Mapping[str, float] | None = None
    running_in: float = 0.0
    damper_loss: float = 1.0

    @property
    def loss_factors(self) -> dict[str, float]:
        """Of each body, where no tip moves."""
        return {name: self.loss_factor * (self.damper_loss if name == "damper" else 1.0) for name in BODIES}

    def in_run(self, place: float) -> "Bench":
        """As it is in one of an assembly's runs. place: from -1/2 for the first to 1/2 for the last"""
        if self.running_in == 0:
            return self
        return replace(self.with_patches(mu=self.patches.mu * np.exp(self.running_in * place)), running_in=0.0)

    def with_patches(self, **entries: Floats | float) -> "Bench":
        return replace(self, patches=replace(self.patches, **entries))

    def with_attachment(self, *more: BenchAttachment) -> "Bench":
        return replace(self, attachments=(*self.attachments, *more))

    def with_element(self, *more: BenchElement) -> "Bench":
        return replace(self, elements=(*self.elements, *more))

    def standing_on(
        self, bodies: Bodies, attachments: tuple[BenchAttachment, ...], changes: Mapping[str, float]
    ) -> "Bench":
        """Other bodies and wires, of a rig with changed dimensions."""
        return replace(self, bodies=bodies, attachments=attachments, changes=changes)

    def tuned(self, **factors: float) -> "Bench":
        """Factors on top of those that are there."""
        tuning = {name: (self.tuning or {}).get(name, 1.0) * factors.get(name, 1.0) for name in BODIES}
        return replace(self, tuning=tuning)


BODIES = ("blade_left", "blade_right", "damper")


def bench_of(rig: Rig, bodies: Bodies) -> Bench:
    """The rig as its file says, nothing hidden: uniform pressure after eq. (5) of Pesaresi et al. (2017).

    raises: ValueError for a rig whose file states another pressure
    """
    contact, angle, n = rig.contact, rig.platform.underside_angle, len(bodies.area)
    if not isinstance(contact.pressure, UniformPressure):
        raise ValueError(f"contact.pressure of {rig.name}: the laboratory knows uniform pressure alone")
    pressure = rig.load.pull / (bodies.area.sum() * (cos(angle) + contact.friction_coefficient * sin(angle)))
    patches = Patches(
        mu=np.full(n, contact.friction_coefficient),
        kt=contact.tangential_stiffness * bodies.area,
        kn=contact.normal_stiffness * bodies.area,
        n0=pressure * bodies.area,
        gap=np.zeros(n),
        viscosity=np.zeros(n),
    )
    excitation = f"blade_{rig.excitation.blade}.excitation.x"
    own, blades = rig.damper_material.loss_factor, rig.material.loss_factor
    return Bench(bodies, patches, wires(rig), excitation, blades, damper_loss=own / blades)


def spring(name: str, direction: Mapping[str, float], stiffness: float) -> BenchAttachment:
    return BenchAttachment(name, direction, lambda _: stiffness)


def wires(rig: Rig, axial_factor: float = 1.0) -> tuple[BenchAttachment, ...]:
    """Both wires: axial stiffness upwards, tension over length sideways, and the roll moment of a pull that acts above
    the damper's centroid."""
    sideways, upwards = rig.load.pull / 2 / rig.wire.length, axial_factor * rig.wire.axial_stiffness / 2
    ends = [
        spring(f"wire_{end}.{axis}", {f"damper.wire_{end}.{axis}": 1.0}, k)
        for end in ("back", "front")
        for axis, k in (("x", sideways), ("y", upwards), ("z", sideways))
    ]
    arm = 1 / (2 * rig.face_bottom[0])
    roll = {"damper.corner_right.y": arm, "damper.corner_left.y": -arm}
    return (*ends, spring("wire_roll", roll, rig.load.pull * rig.wire.attachment_height))


# What can be hidden in the bench: a name, values for three strengths, and what it does physically.

Values = Mapping[str, float]
STRENGTHS = ("weak", "medium", "strong")


@dataclass(frozen=True)
class Renamed:
    """What updamp's catalogue has for a hidden effect of another name. values: the catalogue's from those here"""

    name: str
    values: Callable[[Values], Values]


@dataclass(frozen=True)
class HiddenEffect:
    """strengths: "weak", "medium", "strong" -> values; apply(bench, values, rig) -> the bench with it
    in_catalogue: whether it is hidden as one of the catalogue's, which has it by this name and these parameters
    renamed: of one that is not, where the catalogue has its law all the same; None where it does not
    """

    name: str
    sentence: str
    strengths: Mapping[str, Values]
    apply: Callable[[Bench, Values, Rig], Bench]
    in_catalogue: bool = True
    renamed: Renamed | None = None

    @property
    def catalogue_name(self) -> str:
        """What it is called by a diagnosis that names it; its own name where none can."""
        return self.renamed.name if self.renamed else self.name

    def catalogue_values(self, values: Values) -> Values | None:
        """Parameters of the catalogue's effect, in SI; None where there is none."""
        if self.renamed:
            return self.renamed.values(values)
        return values if self.in_catalogue else None


@dataclass(frozen=True)
class Hidden:
    """One that is hidden in a measurement. strength: for the record, "" where the values are not those of one"""

    name: str
    values: Values
    strength: str = ""


def strengths(parameter: str, weak: float, medium: float, strong: float) -> dict[str, Values]:
    return {name: {parameter: value} for name, value in zip(STRENGTHS, (weak, medium, strong), strict=True)}
