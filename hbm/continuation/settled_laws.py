"""Whether the laws of a curve's elements have settled in the periods that they march through: each is asked for the
same motions with one more."""

from dataclasses import fields, is_dataclass, replace
from typing import Any

import numpy as np

from updamp.hbm.continuation.response_curve import ResponseCurve
from updamp.hbm.problem.elements import ElementGroup, force_only
from updamp.hbm.problem.system import NonlinearSystem


def unsettled(system: NonlinearSystem, curve: ResponseCurve, allowed: float, asked: int) -> str:
    """Which law has not, with what one more cycle changes; "" where all have.

    allowed: change of a group's force, as a share of it; asked: points spread over the curve at which it is, beside
        that of the largest motion
    """
    largest = int(np.argmax(np.linalg.norm(curve.displacement, axis=(1, 2))))
    places = sorted({*np.linspace(0, len(curve) - 1, asked).astype(int).tolist(), largest})
    for group in system.groups:
        if not _may_be_unsettled(group.law):
            continue
        changes = [_change(system, group, curve, place) for place in places]
        if (worst := max(changes)) > allowed:
            name, cycles = type(group.law).__name__, group.law.cycles  # type: ignore[attr-defined]
            return (
                f"{name}: its force has not settled after cycles = {cycles}: one more changes it by {worst:.0%} at "
                f"{curve.frequency[places[int(np.argmax(changes))]]:.6g} Hz; let it march through more, such as "
                f"{2 * cycles}"
            )
    return ""


def _may_be_unsettled(law: Any) -> bool:
    """Where a law says in how many cycles it settles, `settles_in`, and is given them, it is not asked."""
    told = is_dataclass(law) and "cycles" in {field.name for field in fields(law)}
    return told and law.cycles < getattr(law, "settles_in", np.inf)


def _change(system: NonlinearSystem, group: ElementGroup, curve: ResponseCurve, place: int) -> float:
    motion = curve.displacement[place][group.rows], 2 * np.pi * float(curve.frequency[place])
    law: Any = group.law
    longer = replace(group, law=replace(law, cycles=law.cycles + 1))
    force, other = (force_only(g, *motion, system.harmonics, system.time_samples) for g in (group, longer))
    size = float(np.linalg.norm(other))
    return float(np.linalg.norm(other - force)) / size if size > 0 else 0.0
