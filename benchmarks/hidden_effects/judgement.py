"""Right, wrong, or neither: what a verdict is worth, given the truth. The rules were written before any verdict."""

from collections.abc import Iterable
from dataclasses import dataclass
from typing import Literal

Mark = Literal["right", "right group", "wide group", "partly", "wrong", "false alarm", "missed", "unknown", "undecided"]

LARGEST_GROUP = 2
NOTHING = "adequate"


@dataclass(frozen=True)
class Called:
    """What a diagnosis (or an ablation of it) says. verdict: as in `updamp.diagnosis.verdict`; effects: named outright;
    group: one of these is missing, which cannot be said"""

    verdict: str
    effects: tuple[str, ...] = ()
    group: tuple[str, ...] = ()

    @property
    def names_something(self) -> bool:
        return self.verdict in ("identified", "inseparable")


def judged(kind: str, truth: Iterable[str], called: Called) -> Mark:
    """kind: of the case; truth: what is hidden, by the catalogue's names where it has them

    raises: ValueError for a verdict that there is not
    """
    if called.verdict not in ("adequate", "identified", "inseparable", "unknown", "undecidable"):
        raise ValueError(f"verdict '{called.verdict}': none of those of updamp.diagnosis.verdict")
    hidden = frozenset(truth)
    if called.verdict == "undecidable":
        return "undecided"
    if not hidden:
        return "right" if called.verdict == NOTHING else "false alarm"
    if called.verdict == NOTHING:
        return "missed"
    if called.verdict == "unknown":
        return "right" if kind == "outside" else "unknown"
    return _named(hidden, called)


def _named(hidden: frozenset[str], called: Called) -> Mark:
    """Something is hidden, and something is named."""
    named, group = frozenset(called.effects), frozenset(called.group)
    if called.verdict == "identified":
        group = frozenset()
    # An inseparable group is named in `group`; some of its members may stand in `effects` as well.
    outright = named - group
    if outright - hidden or (group and not group & hidden - outright) or not outright | group:
        return "wrong"
    left = hidden - outright
    if not left:
        return "right"
    if not group or len(left) > 1:
        return "partly"
    return "right group" if len(group) <= LARGEST_GROUP else "wide group"


CORRECT: tuple[Mark, ...] = ("right", "right group")
CONFIDENTLY_WRONG: tuple[Mark, ...] = ("wrong", "false alarm")
