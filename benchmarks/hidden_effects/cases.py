"""A case of the blind benchmark: what is hidden, in which test, with which seed."""

import json
from collections.abc import Sequence
from dataclasses import asdict, dataclass
from hashlib import sha256
from typing import Literal

from updamp.benchmarks.hidden_effects.kinds_of_test import EASY, KINDS_OF_TEST, KindOfTest
from updamp.benchmarks.virtual_rig.bench import Hidden
from updamp.benchmarks.virtual_rig.laboratory import HIDDEN

Kind = Literal["none", "single", "outside", "pair", "resolution"]
# Mesh presets of the laboratory and of the model that is fitted; the same with more contact elements.
SMALL, FINE = ("laboratory", "diagnosis"), ("laboratory", "diagnosis_146")


@dataclass(frozen=True)
class Case:
    """number: neutral, from 1; kind: "none" where nothing is hidden, "resolution" for repetitions at 146 patches
    laboratory, fitted: mesh presets of the rig file; repeats: number of the case that this one repeats, 0 for none
    test: name of a kind of test
    """

    number: int
    kind: Kind
    hidden: tuple[Hidden, ...]
    seed: int
    laboratory: str = SMALL[0]
    fitted: str = SMALL[1]
    repeats: int = 0
    test: str = EASY.name

    @property
    def name(self) -> str:
        return f"case_{self.number:03d}"

    @property
    def kind_of_test(self) -> KindOfTest:
        return KINDS_OF_TEST[self.test]

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
        """Whether all of it is hidden as the catalogue's."""
        return all(HIDDEN[name].in_catalogue for name in self.effects)

    @property
    def catalogue_values(self) -> dict[str, dict[str, float]]:
        """What is hidden by the catalogue's names and in its parameters, whose meaning tests check: effect -> name ->
        value, in SI; none for effects that it does not have."""
        known = (
            (HIDDEN[one.name].catalogue_name, HIDDEN[one.name].catalogue_values(one.values)) for one in self.hidden
        )
        return {name: dict(values) for name, values in known if values is not None}

    @property
    def digest(self) -> str:
        """Of all that its data depend on but the laboratory's code."""
        plan, noise = self.kind_of_test.plan, self.kind_of_test.noise
        content = {"case": asdict(self), "plan": asdict(plan), "noise": asdict(noise)}
        return sha256(json.dumps(content, sort_keys=True).encode()).hexdigest()[:16]


def chosen(everything: Sequence[Case], names: Sequence[str] = ()) -> tuple[Case, ...]:
    """Those of the names ("case_012"), or of the kinds, tests, strengths or effects, that are given; all for none.

    raises: ValueError naming what selects nothing
    """
    found: dict[int, Case] = {}
    for name in names:
        matching = [c for c in everything if name in (c.name, c.kind, c.test, c.strength, *c.effects)]
        if not matching:
            last = max(c.number for c in everything)
            raise ValueError(f"no case '{name}': case_001 to case_{last:03d}, a kind, test, strength or effect")
        found |= {c.number: c for c in matching}
    return tuple(c for c in everything if c.number in found) if names else tuple(everything)
