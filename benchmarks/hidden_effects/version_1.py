"""Version 1 of the blind benchmark: an easy test, three strengths of every effect. The cases in the order in which data
are made.

A case goes by a number that tells nothing: the numbers are shuffled over all kinds.
"""

from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np

from updamp.benchmarks.hidden_effects.cases import FINE, Case, Kind
from updamp.benchmarks.virtual_rig.bench import STRENGTHS, Hidden
from updamp.benchmarks.virtual_rig.laboratory import hidden

# Seed of a case is this plus its number.
SEEDS = 9000
NULLS, NULLS_FIRST = 24, 12

# Of the catalogue as it was.
SINGLES = (
    "wire_stiffness", "shaker_attachment", "clamp_flexibility", "blade_mistuning", "material_damping",
    "blade_cubic_stiffness", "pressure_crown", "pressure_slope", "asymmetric_preload", "pressure_dependent_stiffness",
    "static_dynamic_coupling", "contact_viscosity", "velocity_dependent_friction", "sub_patch_microslip",
    "friction_gradient", "edge_gap",
)  # fmt: skip
# At strengths that show: docs/virtual_rig.md.
OUTSIDE = (
    ("quadratic_damping", ("weak", "medium", "strong")),
    ("force_drop_off", ("medium", "strong")),
    ("loose_sensor_gain", ("weak", "medium", "strong")),
    ("second_damper_contact", ("medium", "strong")),
    ("absorber_mass", ("medium", "strong")),
)
# Each shows by itself, and the two act in different places: clamps, blades, wires, load, friction, film.
PAIRS = (
    ("clamp_flexibility:medium", "friction_gradient:strong"),
    ("blade_mistuning:medium", "contact_viscosity:medium"),
    ("wire_stiffness:strong", "asymmetric_preload:strong"),
    ("material_damping:medium", "edge_gap:strong"),
    ("blade_cubic_stiffness:strong", "friction_gradient:strong"),
    ("wire_stiffness:medium", "blade_mistuning:strong"),
    ("pressure_slope:strong", "blade_cubic_stiffness:strong"),
    ("clamp_flexibility:strong", "contact_viscosity:medium"),
    ("asymmetric_preload:strong", "blade_mistuning:medium"),
    ("wire_stiffness:strong", "contact_viscosity:medium"),
    ("material_damping:medium", "blade_mistuning:strong"),
    ("clamp_flexibility:medium", "pressure_slope:strong"),
)
# Repeated with more contact elements, on both sides: nothing, one of friction and one of damping.
REPEATED = ("", "friction_gradient:strong", "contact_viscosity:medium")


@dataclass(frozen=True)
class _Wanted:
    kind: Kind
    hidden: tuple[Hidden, ...]
    fine: bool = False


def version_1() -> tuple[Case, ...]:
    """In the order in which data are made: what the method is worked out with comes first."""
    wanted = tuple(_wanted())
    numbers = np.random.default_rng(20261121).permutation(len(wanted)) + 1
    found: list[Case] = []
    for number, one in zip(numbers.tolist(), wanted, strict=True):
        if not one.fine:
            found.append(Case(number, one.kind, one.hidden, SEEDS + number))
            continue
        original = next(case for case in found if case.hidden == one.hidden)
        found.append(Case(number, one.kind, one.hidden, original.seed, *FINE, repeats=original.number))
    return tuple(found)


def _wanted() -> Iterator[_Wanted]:
    yield from [_Wanted("none", ())] * NULLS_FIRST
    yield from _singles("strong")
    yield from _singles("medium")
    yield from (_Wanted("outside", _of(f"{name}:{s}")) for name, strengths in OUTSIDE for s in strengths)
    yield from (_Wanted("pair", _of(*pair)) for pair in PAIRS)
    yield from (_Wanted("resolution", _of(*filter(None, [text])), fine=True) for text in REPEATED)
    yield from [_Wanted("none", ())] * (NULLS - NULLS_FIRST)
    yield from _singles("weak")


def _singles(strength: str) -> Iterator[_Wanted]:
    assert strength in STRENGTHS
    return (_Wanted("single", _of(f"{name}:{strength}")) for name in SINGLES)


def _of(*texts: str) -> tuple[Hidden, ...]:
    return tuple(hidden(*text.split(":")) for text in texts)
