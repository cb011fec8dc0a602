"""What a rig file states that can be, and hardly is meant so: each a question that names key, value and remedy.

A mode's name is that of its window: which resonance it has is known once there are frequencies. So windows are asked
about again then. With friction a resonance lies between that of
the blade alone, as if all contacts slipped freely, and that of the structure whose contacts all stick: less stiffness
never raises a frequency (Rayleigh).
"""

import math
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from itertools import combinations

import numpy as np

from updamp.rig.damper_mass import damper_mass
from updamp.rig.pressure import FePressure
from updamp.rig.rig import Material, Rig
from updamp.rig.size import VECTORS_A_MODE, size_of

Range = tuple[float, float]


@dataclass(frozen=True)
class Usual:
    """Values that materials and contacts of test rigs have; beyond them a unit was mistaken more often than not.

    youngs_modulus [Pa]: lead 16e9 to tungsten 411e9, with a factor of two to both sides
    density [kg/m^3]: balsa wood 100 to osmium 22,600
    loss_factor: highly damping polymers 0.3 or so; a steel blade has 1e-4 to 1e-2, little damped alloys 1e-5
    area_stiffness [N/m^3]: published contact stiffnesses lie between 1e12 and 1e15, with a factor of 100 to both sides
    modes: kept of each body; the reference rig has 24, and the contacts' own stiffness stands for those above
    slenderness: blade's height over its thickness; and its width over its height
    windows: of frequency, over that of the first bending mode by beam theory: the blade's modes without damper and
        stuck to it lie above half of it (the platform is a mass too), and 100 times it is beyond the modes kept
    """

    youngs_modulus: tuple[float, float] = (8e9, 800e9)
    density: tuple[float, float] = (100.0, 23_000.0)
    loss_factor: tuple[float, float] = (1e-5, 0.3)
    area_stiffness: tuple[float, float] = (1e10, 1e17)
    modes: int = 500
    slenderness: float = 500.0
    width: float = 20.0
    windows: tuple[float, float] = (0.5, 100.0)


def questions(rig: Rig) -> list[str]:
    """Empty where nothing is odd; the rig is run as it is, whatever is asked."""
    return [
        *_materials(rig),
        *_dimensions(rig),
        *_wires(rig),
        *_contact(rig),
        *_reduction(rig),
        *_study(rig),
    ]


def _materials(rig: Rig) -> Iterator[str]:
    """Of the blades, and of the damper where it has its own."""
    yield from _material("material", rig.material)
    if rig.damper.material is not None:
        yield from _material("damper.material", rig.damper.material)


def _material(table: str, material: Material) -> Iterator[str]:
    modulus, density, loss = material.youngs_modulus, material.density, material.loss_factor
    if not Usual.youngs_modulus[0] <= modulus <= Usual.youngs_modulus[1]:
        yield (
            f"{table}.youngs_modulus = {modulus / 1e6:g} MPa: metals have 16 to 411 GPa; is it meant in another unit "
            f'(steel: "197 GPa")?'
        )
    if not Usual.density[0] <= density <= Usual.density[1]:
        yield (
            f"{table}.density = {density:g} kg/m^3: materials have 100 to 23,000; is it meant in another unit "
            f'(steel: "7800 kg/m^3" or "7.8 g/cm^3")?'
        )
    if loss < Usual.loss_factor[0]:
        yield f"{table}.loss_factor = {loss:g}: steel has 0.0001 to 0.01; peaks have hardly a bound then; is it meant?"
    if loss > Usual.loss_factor[1]:
        yield f"{table}.loss_factor = {loss:g}: steel has 0.0001 to 0.01; is it meant in per cent, or as 1 / Q?"


def _dimensions(rig: Rig) -> Iterator[str]:
    height, thickness, width = rig.blade.height, rig.blade.thickness, rig.blade.width
    if height / thickness > Usual.slenderness:
        yield (
            f"blade.thickness = {thickness * 1e3:g} mm: a blade of {height * 1e3:g} mm would be "
            f"{height / thickness:.3g} times as high as it is thin; are both in the unit that is meant?"
        )
    if width / height > Usual.width:
        yield (
            f"blade.width = {width * 1e3:g} mm: {width / height:.3g} times as wide as it is high "
            f"({height * 1e3:g} mm); are both in the unit that is meant?"
        )
    damper, top = rig.damper, 2 * rig.face_top[0]
    if damper.apex_height == 0 and damper.apex_flat > top:
        yield (
            f"damper.apex_flat = {damper.apex_flat * 1e3:g} mm: has no meaning without an apex, apex_height = 0: the "
            f"damper's top is where its faces end, {top * 1e3:.6g} mm wide; is an apex meant?"
        )


def _wires(rig: Rig) -> Iterator[str]:
    """Pesaresi et al. 2017, eq. (1): the damper on its wires resonates along them above all that is looked at."""
    name, highest = max(((name, mode.window[1]) for name, mode in rig.study.modes.items()), key=lambda one: one[1])
    mass, stiffness = damper_mass(rig), rig.wire.axial_stiffness
    least = mass * (2 * math.pi * highest) ** 2
    if stiffness <= least:
        yield (
            f"wire.axial_stiffness = {stiffness:g} N/m: not above m w^2 = {least:.3g} N/m, eq. (1) of Pesaresi et al. "
            f"2017, with the damper's mass m = {mass * 1e3:.3g} g and w at {_hertz(highest)}, the upper end of "
            f"study.modes.{name}.window; is it in another unit, are stiffer wires meant, or a lower window?"
        )


def _reduction(rig: Rig) -> Iterator[str]:
    if (modes := rig.reduction.modes) > Usual.modes:
        mesh = next(iter(rig.mesh))
        memory = 8 * VECTORS_A_MODE * modes * size_of(rig, mesh).unknowns
        yield (
            f"reduction.modes = {modes}: 10 to 50 of each body are usual; finding so many takes {memory / 1e9:.2g} GB "
            f"or so of memory with mesh '{mesh}', and more with finer ones; is it meant?"
        )


def _contact(rig: Rig) -> Iterator[str]:
    for key in ("tangential_stiffness", "normal_stiffness"):
        stiffness = getattr(rig.contact, key)
        if not Usual.area_stiffness[0] <= stiffness <= Usual.area_stiffness[1]:
            yield (
                f"contact.{key} = {stiffness:g} N/m^3 ({stiffness / 1e9:g} N/mm^3): contacts have 1e3 to 1e6 N/mm^3; "
                f'is it meant in another unit, such as "60000 N/mm^3"?'
            )
    yield from _two_limits(rig)


def _two_limits(rig: Rig) -> Iterator[str]:
    """At rest friction is limited in t1 and t2 apart, whatever the law (fem/static_contact/unilateral_contact.py)."""
    pressure, friction = rig.contact.pressure, rig.contact.friction_coefficient
    if rig.contact.law == "coulomb_circle" and isinstance(pressure, FePressure) and pressure.friction and friction > 0:
        yield (
            f'contact.law = "coulomb_circle" limits friction in the plane, but contact.pressure.model = "fe" limits it '
            f"in each direction by itself: at rest a patch may carry up to {math.sqrt(2) * friction:.3g} N of friction "
            f"a newton of pressing force, where the law allows {friction:g}; is that meant? With the law "
            f'"jenkins_box" both have the same limits; contact.pressure.friction = false leaves friction out at rest'
        )


def _study(rig: Rig) -> Iterator[str]:
    strongest = max(rig.study.force_levels)
    if strongest > rig.load.pull:
        yield (
            f"study.force_levels: {_newton(strongest)} shakes harder than the wires pull, load.pull = "
            f"{_newton(rig.load.pull)}, and would throw the damper out; is one of both in another unit?"
        )
    bending = first_bending(rig)
    for name, mode in rig.study.modes.items():
        low, high = (share * bending for share in Usual.windows)
        if mode.window[1] < low or mode.window[0] > high:
            yield (
                f"study.modes.{name}.window = {_hertz(mode.window[0])} to {_hertz(mode.window[1])}: beam theory has "
                f"the blade's first bending mode near {bending:.3g} Hz, so no mode is likely there; is it in Hz?"
            )
    yield from _shared_windows({name: mode.window for name, mode in rig.study.modes.items()})


def _shared_windows(windows: Mapping[str, Range]) -> Iterator[str]:
    """Of two windows one of which has the middle of the other in it, where that one's resonance is looked for."""
    for (name, one), (other, its) in combinations(windows.items(), 2):
        low, high = max(one[0], its[0]), min(one[1], its[1])
        if any(low <= (window[0] + window[1]) / 2 <= high for window in (one, its)):
            yield (
                f"study.modes.{other}.window = {_hertz(its[0])} to {_hertz(its[1])} overlaps that of {name}, "
                f"{_hertz(one[0])} to {_hertz(one[1])}: a mode is whatever resonates most in its window, and both may "
                f"be the same resonance; should each have a window of its own?"
            )


def first_bending(rig: Rig) -> float:
    """Of a clamped beam without platform, Euler-Bernoulli: (1.8751^2 / 2 pi) (t / L^2) sqrt(E / 12 rho) [Hz]."""
    blade, material = rig.blade, rig.material
    speed = math.sqrt(material.youngs_modulus / (12 * material.density))
    return 1.8751**2 / (2 * math.pi) * blade.thickness / blade.height**2 * speed


def possible_resonances(free: Sequence[float], stuck: Sequence[float]) -> list[Range]:
    """(lowest, highest) frequency of each stuck mode's resonance [Hz].

    free: frequencies of the blades alone; stuck: of the structure with all contacts stuck
    """
    return [(float(max((f for f in free if f <= top), default=top)), float(top)) for top in stuck]


def empty_windows(windows: Mapping[str, Range], resonances: Sequence[Range], known_up_to: float) -> list[str]:
    """A question for each window below `known_up_to` [Hz] that no resonance can lie in.

    windows: mode -> (lower, upper) [Hz]; resonances: as `possible_resonances` has them
    """
    return [
        f"study.modes.{mode}.window = {low:g} to {high:g} Hz: no resonance of this mesh can lie there, the nearest are "
        f"{_listed(resonances, (low + high) / 2)}; is another window meant?"
        for mode, (low, high) in windows.items()
        if low < known_up_to and not any(low <= top and bottom <= high for bottom, top in resonances)
    ]


def undivided_windows(windows: Mapping[str, Range], coupled: Mapping[str, float]) -> list[str]:
    """A question for each window of a mode that is known by name and that the other one lies in too.

    windows: mode -> (lower, upper) [Hz]; coupled: mode -> frequency at forces so small that nothing slips or opens [Hz]
    """
    return [
        f"study.modes.{mode}.window = {low:g} to {high:g} Hz has {_named(inside)} in it, at small forces: the one that "
        f"responds most is followed as {mode}; is a window without the other meant?"
        for mode, (low, high) in windows.items()
        if len(inside := {name: at for name, at in coupled.items() if low <= at <= high}) > 1 and mode in coupled
    ]


def misnamed(found: Mapping[str, float], coupled: Mapping[str, float]) -> list[str]:
    """A sentence for each mode whose resonance is another mode's.

    found: mode -> frequency at the lowest force [Hz]; coupled: as in `undivided_windows`
    """
    nearest = {mode: min(coupled, key=lambda name: abs(coupled[name] - at)) for mode, at in found.items()}
    return [
        f"{mode}: its resonance at the lowest force, {at:.2f} Hz, is that of {nearest[mode]}: at small forces there "
        f"are {_named(coupled)}; give {mode} a window without {nearest[mode]}"
        for mode, at in found.items()
        if mode in coupled and nearest[mode] != mode
    ]


def _named(frequencies: Mapping[str, float]) -> str:
    return " and ".join(f"{name} at {at:.2f} Hz" for name, at in frequencies.items())


def _newton(force: float) -> str:
    return f"{force / 1e6:g} MN" if force >= 1e6 else f"{force:g} N"


def _hertz(frequency: float) -> str:
    return f"{frequency / 1e3:g} kHz" if frequency >= 1e4 else f"{frequency:g} Hz"


def _listed(resonances: Sequence[Range], middle: float) -> str:
    nearest = sorted(resonances, key=lambda one: abs(np.log(one[1] / middle)))[:2]
    return " and ".join(
        f"at {low:.0f} to {high:.0f} Hz" if high - low > 1 else f"at {high:.1f} Hz" for low, high in nearest
    )
