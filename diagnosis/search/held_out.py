"""Which runs no fit is to see, and how they are called in the verdict."""

from collections.abc import Sequence

from updamp.diagnosis.residual.observations import Plan
from updamp.diagnosis.search.baseline import Baseline


def held_out_runs(plan: Plan, runs: Sequence[str] | None, modes: Sequence[str]) -> tuple[str, ...] | None:
    """Names of the runs: those given and all of the modes; None where neither is given, for the usual choice.

    raises: ValueError for a mode that was not measured, and where nothing would be left to fit to
    """
    if not modes and runs is None:
        return None
    known = dict.fromkeys(c.mode for c in plan.conditions)
    unknown = [mode for mode in modes if mode not in known]
    if unknown:
        raise ValueError(f"no mode '{unknown[0]}' to hold out; there are {', '.join(known)}")
    wanted = {*(runs or ()), *(c.name for c in plan.conditions if c.mode in modes)}
    if wanted.issuperset(c.name for c in plan.conditions):
        raise ValueError("all runs are to be held out, and none is left to fit to: hold out fewer")
    return tuple(sorted(wanted))


def unseen(start: Baseline) -> str:
    """What the held-out error is of, in words."""
    fitted = {c.mode for c in start.train_plan.conditions}
    modes = dict.fromkeys(c.mode for c in start.held_out_plan.conditions)
    if modes and fitted.isdisjoint(modes):
        return f"{' and '.join(modes)}, of which the fit saw no run,"
    return "runs that the fit never saw"
