"""The calibration that a rig file has taken up:

[calibration]
origin = "fitted with edge_gap to ..., 2026-11-20"
sliding_friction = 0.94           # factors on the rig file's own values

`sliding_friction` is the factor on the friction coefficient in vibration alone: the preload stays that of the stated
coefficient, which eq. (5) of Pesaresi et al. (2017) and static contact take from the rig file. `youngs_modulus` and
`loss_factor` are factors on those of blades and damper alike, also where the damper has a material of its own.
"""

import math
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace
from difflib import get_close_matches

import numpy as np

from updamp.effects.rig_model import RigModel
from updamp.rig.effects import Calibration
from updamp.rig.errors import RigError


@dataclass(frozen=True)
class Nuisance:
    """A factor on a quantity that is known only roughly, and that differs a little from one assembly to the next.

    The fit sees its logarithm, which is normally distributed about 0.

    deviation: prior standard deviation of the logarithm; largest: bound on its size
    scatter: what its logarithm is expected to vary by from one assembly to the next (standard deviation), before the
        repeats have been looked at
    source: where these come from
    apply(model, factor) -> model
    """

    name: str
    sentence: str
    deviation: float
    largest: float
    scatter: float
    source: str
    apply: Callable[[RigModel, float], RigModel]


def _stiffness_of_material(model: RigModel, factor: float) -> RigModel:
    c = model.components
    changed = replace(
        c, omega_squared=c.omega_squared * factor, residual=c.residual / factor, hysteretic=c.hysteretic * factor
    )
    return replace(model, components=changed)


def _loss_factor(model: RigModel, factor: float) -> RigModel:
    c = model.components
    return replace(model, components=replace(c, hysteretic=c.hysteretic * factor, viscous=c.viscous * factor))


def _modal_mass(model: RigModel, factor: float) -> RigModel:
    """Frequencies and loss factors stay."""
    c = model.components
    return replace(model, components=replace(c, phi=c.phi / np.sqrt(factor), residual=c.residual / factor))


@dataclass(frozen=True)
class _ContactEntry:
    """A factor on one entry of the contacts' parameters."""

    entry: str

    def __call__(self, model: RigModel, factor: float) -> RigModel:
        assert model.contacts is not None, "asked for where there are contacts only"
        return model.with_contacts(**{self.entry: getattr(model.contacts.parameters, self.entry) * factor})


# What is assumed here is an engineer's reading of how well each is known before a test; what repeats say replaces
# `scatter`, and a calibration that ends several `deviation` off is told and bars an effect's name.
YOUNGS_MODULUS = Nuisance(
    name="youngs_modulus",
    sentence="Young's modulus of blades and damper",
    deviation=0.01,
    largest=0.05,
    scatter=2e-4,
    source="assumed: handbook values of one steel differ by a per cent; 2e-4 is 0.7 K, at 3e-4 a kelvin",
    apply=_stiffness_of_material,
)
LOSS_FACTOR = Nuisance(
    name="loss_factor",
    sentence="material loss factor",
    deviation=0.5,
    largest=1.5,
    scatter=0.02,
    source="assumed: what a clamp loses is in it, so that a free blade's is known to a factor of 1.6 there",
    apply=_loss_factor,
)
FRICTION = Nuisance(
    name="sliding_friction",
    sentence="friction coefficient in vibration, preload as stated",
    deviation=0.3,
    largest=1.5,
    scatter=0.05,
    apply=_ContactEntry("mu"),
    source="assumed: a third either way between tests of one pair of surfaces, a twentieth from assembly to assembly",
)
TANGENTIAL = Nuisance(
    name="tangential_stiffness",
    sentence="tangential contact stiffness",
    deviation=0.7,
    largest=2.5,
    scatter=0.05,
    source="assumed: a factor of two either way; Pesaresi et al. (2017), Fig. 11, study three decades of it",
    apply=_ContactEntry("kt"),
)
NORMAL = replace(TANGENTIAL, name="normal_stiffness", sentence="normal contact stiffness", apply=_ContactEntry("kn"))
PRELOAD = Nuisance(
    name="preload",
    sentence="preload of the contacts",
    deviation=0.02,
    largest=0.1,
    scatter=0.03,
    source="assumed: dead weights are known to 0.1 %, what pulleys and wires take of them to 2 %",
    apply=_ContactEntry("n0"),
)
MODAL_STIFFNESS = Nuisance(
    name="modal_stiffness",
    sentence="modal stiffness",
    deviation=0.01,
    largest=0.05,
    scatter=2e-4,
    source="assumed: of what is identified in a test frequencies are known best; as Young's modulus",
    apply=_stiffness_of_material,
)
MODAL_MASS = Nuisance(
    name="modal_mass", sentence="modal mass", deviation=0.05, largest=0.5, scatter=0.01,
    source="assumed: it is known as well as sensors and force are calibrated, half a decibel", apply=_modal_mass,
)  # fmt: skip


@dataclass(frozen=True)
class _OfMode:
    """What a factor on all identified modes does, on one of them alone."""

    apply_to_all: Callable[[RigModel, float], RigModel]
    mode: int

    def __call__(self, model: RigModel, factor: float) -> RigModel:
        before, own = model.components, self.mode
        after = self.apply_to_all(model, factor).components
        phi, omega_squared = before.phi.copy(), before.omega_squared.copy()
        hysteretic, viscous = before.hysteretic.copy(), before.viscous.copy()
        phi[:, own], omega_squared[own] = after.phi[:, own], after.omega_squared[own]
        hysteretic[own], viscous[own] = after.hysteretic[own], after.viscous[own]
        changed = replace(before, omega_squared=omega_squared, phi=phi, hysteretic=hysteretic, viscous=viscous)
        return replace(model, components=changed)


def _of_each_mode(modes: Sequence[str]) -> tuple[Nuisance, ...]:
    """Of several modes: each has been identified by itself, and is off by itself, beside what all have in common."""
    return tuple(
        replace(
            nuisance,
            name=f"{mode}_{nuisance.name}",
            sentence=f"{nuisance.sentence} of the mode '{mode}' by itself",
            apply=_OfMode(nuisance.apply, i),
        )
        for i, mode in enumerate(modes)
        for nuisance in OF_MODES
    )


def together_of_mode(names: Sequence[str], modes: Sequence[str]) -> dict[str, tuple[int, int]]:
    """Places among the names of the factor on all modes and of the one on each by itself, under what they are together:
    the product is what a test of that mode tells."""
    return {
        f"{nuisance.sentence} of the mode '{mode}'": (names.index(nuisance.name), names.index(own))
        for mode in modes
        for nuisance in OF_MODES
        if nuisance.name in names and (own := f"{mode}_{nuisance.name}") in names
    }


OF_STRUCTURE, OF_CONTACTS = (YOUNGS_MODULUS, LOSS_FACTOR), (FRICTION, TANGENTIAL, NORMAL, PRELOAD)
OF_RIG, OF_MODES = (*OF_STRUCTURE, *OF_CONTACTS), (MODAL_STIFFNESS, LOSS_FACTOR, MODAL_MASS)


def nuisances(model: RigModel) -> tuple[Nuisance, ...]:
    """Those that the model has a place for."""
    if model.identified:
        return (*OF_MODES, *(_of_each_mode(model.modes) if len(model.modes) > 1 else ()))
    return OF_RIG if model.contacts else OF_STRUCTURE


_KNOWN = {nuisance.name: nuisance for nuisance in (*OF_RIG, *OF_MODES)}
# Earlier name -> present one.
_RENAMED = {"friction_coefficient": FRICTION.name}


def present_name(name: str) -> str:
    """Of a factor that a diagnosis made by an earlier version may name otherwise."""
    return _RENAMED.get(name, name)


def read_calibration(table: object) -> Calibration:
    """From the table [calibration] of a rig file, as read.

    raises: RigError with every problem found, one a line
    """
    if not isinstance(table, Mapping):
        raise RigError("calibration: a table of factors is wanted: [calibration] with sliding_friction = 0.94")
    stated = dict(table)
    origin = stated.pop("origin", "")
    problems = [line for name, factor in stated.items() if (line := _problem(name, factor))]
    if not isinstance(origin, str):
        problems.append(f"calibration.origin = {origin!r}: text is wanted that says where the factors come from")
    if problems:
        raise RigError("\n".join(problems))
    return Calibration(factors={name: float(factor) for name, factor in stated.items()}, origin=origin)


def _problem(name: str, factor: object) -> str:
    if name in _RENAMED:
        return (
            f"calibration.{name}: is now called {_RENAMED[name]}, since the factor acts on friction in vibration alone "
            f"and leaves the preload as stated; write {_RENAMED[name]} = {factor}. To change the preload too, change "
            f"contact.{name} instead"
        )
    known_one = _named(name)
    if known_one is None:
        close = get_close_matches(name, _KNOWN, n=1)
        known = f"did you mean {close[0]}?" if close else f"allowed are {', '.join(_KNOWN)}"
        return f"calibration.{name}: unknown factor; {known}"
    lowest, highest = bounds(known_one)
    if isinstance(factor, bool) or not isinstance(factor, int | float):
        return f"calibration.{name} = {factor!r}: a factor is wanted, a plain number such as 1.02"
    if not lowest <= factor <= highest:
        return f"calibration.{name} = {factor!r}: out of range: allowed is {lowest:.4g} to {highest:.4g}"
    return ""


def _named(name: str) -> Nuisance | None:
    """The factor of that name, or of that one mode; whether there is such a mode the model knows (`calibrated`)."""
    of_one_mode = (nuisance for nuisance in OF_MODES if name.endswith(f"_{nuisance.name}"))
    return _KNOWN.get(name) or next(of_one_mode, None)


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
