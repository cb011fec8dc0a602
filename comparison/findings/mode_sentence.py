"""One sentence on a quantity of a mode, such as its resonance: at all levels, or level by level, the worst first."""

from collections.abc import Sequence

import numpy as np

from updamp.comparison.comparison import Finding
from updamp.comparison.findings.direction import Misfit
from updamp.comparison.findings.words import FAR_LESS, in_percent, levels_of
from updamp.comparison.fit.observations import Plan

# Levels share a sentence where each is off the mean over all of them by no more than scatter makes it (3 deviations: 1
# in 370 by chance) and, where they are known so well that no two agree, a fifth of the mean: of 20 %, 4.
_BY_CHANCE, _OF_MEAN = 3.0, 0.2


def mode_sentence(
    thing: str, mode: str, all_levels: Sequence[Misfit], standing: Sequence[Misfit], plan: Plan
) -> list[Finding]:
    """That all levels agree, or those that stand out, the largest first, and what holds at the others; and where
    nothing was read. Of one mode and kind: all that was read, and what of it stands out."""
    if not standing:
        return []
    read = [m.direction.test for m in all_levels]
    unread = [i for i, c in enumerate(plan.conditions) if c.mode == mode and i not in read]
    not_read = f", not read at {levels_of(unread, plan)}" if unread else ""
    quantity = standing[0].direction.quantity
    mean, deviation = _mean(all_levels)
    if _are_alike(all_levels, mean):
        kind = "force level" if plan.conditions[0].unit == "N" else "level"
        where = levels_of(read, plan) if unread else f"every {kind}"
        text = f"{mode}: {thing} {in_percent(mean)} at {where}{not_read}"
        return [Finding(text, mode, None, quantity, "", mean, mean / deviation)]
    worst = max(standing, key=lambda m: m.size)
    level = plan.conditions[worst.direction.test].level
    text = f"{mode}: {thing} {_level_by_level(all_levels, standing, plan)}{not_read}"
    return [Finding(text, mode, level, quantity, "", worst.relative, worst.significance)]


def _mean(misfits: Sequence[Misfit]) -> tuple[float, float]:
    """With its deviation, each weighed as well as it is known."""
    values = np.array([m.relative for m in misfits])
    weights = np.array([1 / m.deviation**2 for m in misfits])
    return float(np.sum(weights * values) / np.sum(weights)), float(1 / np.sqrt(np.sum(weights)))


def _are_alike(misfits: Sequence[Misfit], mean: float) -> bool:
    alike = all(abs(m.relative - mean) < _BY_CHANCE * m.deviation + _OF_MEAN * abs(mean) for m in misfits)
    return len(misfits) > 1 and alike and all(np.sign(m.relative) == np.sign(mean) for m in misfits)


def _level_by_level(all_levels: Sequence[Misfit], standing: Sequence[Misfit], plan: Plan) -> str:
    by_size = sorted(standing, key=lambda m: -m.size)
    named = [m for m in by_size if m.size >= FAR_LESS * by_size[0].size]
    sizes = dict.fromkeys(in_percent(m.relative) for m in named)
    parts = [f"{size} at {_at([m for m in named if in_percent(m.relative) == size], plan)}" for size in sizes]
    rest = {
        "far less": [m for m in standing if m not in named],
        "right": [m for m in all_levels if m not in standing],
    }
    return ", ".join([*parts, *(f"{what} at {_at(some, plan)}" for what, some in rest.items() if some)])


def _at(misfits: Sequence[Misfit], plan: Plan) -> str:
    return levels_of([m.direction.test for m in misfits], plan)
