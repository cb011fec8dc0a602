"""All effects that can be hidden, by name."""

from collections.abc import Mapping, Sequence
from types import MappingProxyType

from virtual_rig import hidden_in_contact, hidden_in_structure, hidden_outside
from virtual_rig.bench import Bench
from virtual_rig.hidden_effect import Hidden, HiddenEffect

from updamp.rig import Rig

HIDDEN: Mapping[str, HiddenEffect] = MappingProxyType(
    {e.name: e for e in (*hidden_in_structure.EFFECTS, *hidden_in_contact.EFFECTS, *hidden_outside.EFFECTS)}
)


def hidden(name: str, strength: str) -> Hidden:
    """raises: ValueError naming what there is"""
    if name not in HIDDEN:
        raise ValueError(f"no effect '{name}' can be hidden; there are {', '.join(HIDDEN)}")
    if strength not in HIDDEN[name].strengths:
        raise ValueError(f"strength '{strength}' of '{name}': one of {', '.join(HIDDEN[name].strengths)} is wanted")
    return Hidden(name, HIDDEN[name].strengths[strength], strength)


def with_hidden(bench: Bench, effects: Sequence[Hidden], rig: Rig) -> Bench:
    """In the order of the registry, so that what is scaled and what is set does not depend on the order of naming."""
    for name, effect in HIDDEN.items():
        for one in effects:
            if one.name == name:
                bench = effect.apply(bench, one.values, rig)
    return bench
