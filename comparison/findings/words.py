"""Words that all sentences on misfits share: how much high or low, and at which levels."""

from collections.abc import Sequence

from updamp.comparison.fit.observations import Plan
from updamp.comparison.prediction.run_condition import RunCondition

# Share of a mode's largest misfit below which a level gets no number: it is right, or far less wrong.
FAR_LESS = 0.25
# Share of a level by which it may be off what it is called.
_AS_MEANT = 0.003
# Share by which sweeps in both directions may differ that are of one level: the force of a level is the median of what
# was measured, and the shaker's force drops at the resonance, in each direction over other frequencies.
_SAME_LEVEL = 0.05


def in_percent(relative: float) -> str:
    """Such as "0.15 % high"."""
    size = 100 * abs(relative)
    digits = 2 if size < 0.995 else 1 if size < 9.95 else 0
    return f"{size:.{digits}f} % {'high' if relative > 0 else 'low'}"


def levels_of(tests: Sequence[int], plan: Plan) -> str:
    return ", ".join(dict.fromkeys(level_of(plan, test) for test in tests))


def level_of(plan: Plan, test: int) -> str:
    """A test's level with its unit, and the sweep's direction where both were swept."""
    return f"{aimed_at(plan.conditions[test])}{_sweep(plan, test)}"


def aimed_at(condition: RunCondition) -> str:
    """Its level as it was meant, with its unit: a force is the mean of what was measured."""
    unit = condition.level_name.split(" ", 1)[1]
    short = [float(f"{condition.level:.{digits}g}") for digits in (1, 2, 3)]
    name = next((s for s in short if abs(s / condition.level - 1) < _AS_MEANT), short[-1])
    return f"{name:g} {unit}"


def _sweep(plan: Plan, test: int) -> str:
    """Named only where both directions were swept at the level."""
    this = plan.conditions[test]
    others = [
        c
        for c in plan.conditions
        if c.mode == this.mode and c.upwards != this.upwards and abs(c.level / this.level - 1) < _SAME_LEVEL
    ]
    return (" upwards" if this.upwards else " downwards") if others else ""
