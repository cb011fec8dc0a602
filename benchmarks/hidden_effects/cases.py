"""The blind benchmark's cases: what is hidden in each, with which seed, in the order in which data are made.

A case goes by a number that tells nothing: the numbers are shuffled over all kinds.
"""

import json
from collections.abc import Iterator
from dataclasses import asdict, dataclass
from hashlib import sha256
from typing import Literal

import numpy as np

from updamp.benchmarks.virtual_rig.bench import STRENGTHS, Hidden
from updamp.benchmarks.virtual_rig.laboratory import HIDDEN, hidden
from updamp.benchmarks.virtual_rig.plan import SIX_CURVES, NoiseLevels, TestPlan

Kind = Literal["none", "single", "outside", "pair", "resolution"]

PLAN = TestPlan(SIX_CURVES, assemblies=3, points=40)
NOISE = NoiseLevels()
# Seed of a case is this plus its number.
SEEDS = 9000
NULLS, NULLS_FIRST = 24, 12

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
SMALL, FINE = ("laboratory", "diagnosis"), ("laboratory_100", "diagnosis_146")


@dataclass(frozen=True)
class Case:
    """number: neutral, from 1; kind: "none" where nothing is hidden, "resolution" for repetitions at 146 patches
    laboratory, fitted: mesh presets of the rig file; repeats: number of the case that this one repeats, 0 for none
    """

    number: int
    kind: Kind
    hidden: tuple[Hidden, ...]
    seed: int
    laboratory: str = SMALL[0]
    fitted: str = SMALL[1]
    repeats: int = 0

    @property
    def name(self) -> str:
        return f"case_{self.number:03d}"

    @property
    def strength(self) -> str:
        """Of a single effect, "" otherwise."""
        return self.hidden[0].strength if len(self.hidden) == 1 else ""

    @property
    def effects(self) -> tuple[str, ...]:
        return tuple(one.name for one in self.hidden)

    @property
    def detail(self) -> str:
        """For people: it gives the truth away."""
        return " + ".join(f"{one.name} {one.strength}" for one in self.hidden) or "nothing"

    @property
    def in_catalogue(self) -> bool:
        return all(HIDDEN[name].in_catalogue for name in self.effects)

    @property
    def catalogue_values(self) -> dict[str, dict[str, float]]:
        """What is hidden in the parameters of updamp's catalogue: effect -> name -> value, in SI; none for effects
        outside it. The laboratory's parameters have the catalogue's names and meaning, which tests check."""
        return {one.name: dict(one.values) for one in self.hidden if HIDDEN[one.name].in_catalogue}

    @property
    def digest(self) -> str:
        """Of all that its data depend on but the laboratory's code."""
        content = {"case": asdict(self), "plan": asdict(PLAN), "noise": asdict(NOISE)}
        return sha256(json.dumps(content, sort_keys=True).encode()).hexdigest()[:16]


@dataclass(frozen=True)
class _Wanted:
    kind: Kind
    hidden: tuple[Hidden, ...]
    fine: bool = False


def cases() -> tuple[Case, ...]:
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


def by_name(names: tuple[str, ...] = ()) -> tuple[Case, ...]:
    """Those of the names ("case_012"), or of the kinds, strengths or effects, that are given; all for none.

    raises: ValueError naming what selects nothing
    """
    everything = cases()
    chosen: dict[int, Case] = {}
    for name in names:
        matching = [c for c in everything if name in (c.name, c.kind, c.strength, *c.effects)]
        if not matching:
            raise ValueError(f"no case '{name}': case_001 to case_{len(everything):03d}, a kind, strength or effect")
        chosen |= {c.number: c for c in matching}
    return tuple(c for c in everything if c.number in chosen) if names else everything


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
    return (_Wanted("single", _of(f"{name}:{strength}")) for name, e in HIDDEN.items() if e.in_catalogue)


def _of(*texts: str) -> tuple[Hidden, ...]:
    return tuple(hidden(*text.split(":")) for text in texts)
