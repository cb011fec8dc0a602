"""Misfits of the peaks in words: one sentence for each mode and quantity, levels that agree taken together.

Sentences come by how much of the misfit they account for, as sum of squares over the tests that they name, the largest
first. What does not stand out of the scatter gets no sentence.
"""

from collections.abc import Collection, Mapping, Sequence
from dataclasses import dataclass

import numpy as np
from scipy.stats import norm

from updamp.comparison.comparison import Finding
from updamp.comparison.findings.direction import Direction
from updamp.comparison.findings.kinds import Amplitude, Damping, Frequency
from updamp.comparison.findings.peak_misfit import PeakMisfit
from updamp.comparison.findings.words import FAR_LESS, in_percent, level_of
from updamp.comparison.fit.failing_model import RISK
from updamp.comparison.fit.observations import Plan

# Share of the mean by which levels may differ that share a sentence.
ALIKE = 1 / 3
# Misfit of the damping, of its logarithm, that is worth an aside, and the one up to which it is right.
_LOSSES, _NO_LOSSES = 0.1, 0.05


@dataclass(frozen=True)
class _Sentence:
    """what: kind of misfit, in any test; with_damping: tests at whose heights it says the damping too"""

    finding: Finding
    what: Direction
    severity: float
    tests: frozenset[int]
    with_damping: frozenset[int] = frozenset()


def peak_findings(misfits: Sequence[PeakMisfit], plan: Plan, names: Mapping[str, str]) -> tuple[Finding, ...]:
    """Sentences on what stands out of the scatter: an adequate model gets any with a probability of `RISK`.

    names: of the channels, by point of the model
    """
    damping = {m.direction.test: m for m in misfits if isinstance(m.direction, Damping)}
    # each is held against the scatter in two ways, to two sides
    limit = float(norm.isf(RISK / 4 / max(len(misfits), 1)))
    sentences: list[_Sentence] = []
    for what in dict.fromkeys(m.direction.in_all_tests for m in misfits):
        same = [m for m in misfits if m.direction.in_all_tests == what]
        modes = dict.fromkeys(plan.conditions[m.direction.test].mode for m in same)
        groups = [[m for m in same if plan.conditions[m.direction.test].mode == mode] for mode in modes]
        if what.modes_share and len(modes) > 1 and _are_alike(same):
            groups = [same]
        for group in groups:
            sentences += _of_group(group, limit, plan, names, damping)
    beside_heights = frozenset[int]().union(*(s.with_damping for s in sentences))
    sentences = [s for s in sentences if not isinstance(s.what, Damping) or not s.tests <= beside_heights]
    sentences.sort(key=lambda s: -s.severity)
    return tuple(s.finding for s in sentences)


def without_peak_findings(tests: Sequence[int], plan: Plan) -> tuple[Finding, ...]:
    """A sentence for each mode that has conditions (places in the plan) at which the model has no peak to read."""
    sentences = []
    for mode in dict.fromkeys(plan.conditions[i].mode for i in tests):
        levels = [level_of(plan, i) for i in tests if plan.conditions[i].mode == mode]
        text = f"{mode}: the model has no peak where it was measured, at {_listed(levels)}"
        level = next(plan.conditions[i].level for i in tests if plan.conditions[i].mode == mode)
        sentences.append(Finding(text, mode, level, Frequency.quantity, "", float("nan"), float("nan")))
    return tuple(sentences)


def _are_alike(group: Sequence[PeakMisfit]) -> bool:
    logs = np.log1p([m.relative for m in group])
    return bool(np.all(np.abs(logs - logs.mean()) <= ALIKE * abs(logs.mean())))


def _of_group(
    group: Sequence[PeakMisfit],
    limit: float,
    plan: Plan,
    names: Mapping[str, str],
    damping: Mapping[int, PeakMisfit],
) -> list[_Sentence]:
    """Of one mode, or of all of them."""
    largest = max(m.severity for m in group)
    standing = [m for m in group if abs(m.significance) > limit and m.severity >= FAR_LESS * largest]
    if not standing:
        return []
    modes = dict.fromkeys(plan.conditions[m.direction.test].mode for m in group)
    worst = max(standing, key=lambda m: m.severity)
    together = len(group) > 1 and _are_alike(group)
    named = list(group) if together else standing
    what = f"{_span(group)} {_where(group, modes, plan)}" if together else _by_level(group, standing, limit, plan)
    mode = next(iter(modes)) if len(modes) == 1 else ""
    subject, channel = worst.direction.subject(plan, names, plural=not mode)
    text = f"{mode}: {subject} {what}" if mode else f"{subject} {what}"
    aside = _aside(named, damping, plan) if isinstance(worst.direction, Amplitude) else ""
    text += aside
    level = None if together else plan.conditions[worst.direction.test].level
    significance = max((m.significance for m in named), key=abs)
    relative = float(np.expm1(np.mean(np.log1p([m.relative for m in group])))) if together else worst.relative
    significance = float(np.copysign(significance, relative))
    finding = Finding(text, mode, level, worst.direction.quantity, channel, relative, significance)
    tests = frozenset(m.direction.test for m in named)
    severity = float(np.linalg.norm([m.severity for m in named]))
    beside = tests & damping.keys() if aside else frozenset[int]()
    return [_Sentence(finding, worst.direction.in_all_tests, severity, tests, beside)]


def _by_level(group: Sequence[PeakMisfit], standing: Sequence[PeakMisfit], limit: float, plan: Plan) -> str:
    small = [m for m in group if m.severity < FAR_LESS * max(m.severity for m in group)]
    far_less = [level_of(plan, m.direction.test) for m in small if abs(m.significance) > limit]
    right = [level_of(plan, m.direction.test) for m in small if abs(m.significance) <= limit]
    parts = [f"{in_percent(m.relative)} at {level_of(plan, m.direction.test)}" for m in standing]
    parts += [f"{what} at {_listed(at)}" for what, at in (("far less", far_less), ("right", right)) if at]
    return ", ".join(parts)


def _where(group: Sequence[PeakMisfit], modes: Collection[str], plan: Plan) -> str:
    """Of misfits that are alike: "at every force level" where they are read at all of these modes."""
    read = {m.direction.test for m in group}
    if not read.issuperset(i for i, c in enumerate(plan.conditions) if c.mode in modes):
        return f"at {_listed([level_of(plan, m.direction.test) for m in group])}"
    kind = "force level" if plan.conditions[0].unit == "N" else "level"
    return "in all runs" if len(modes) > 1 else f"at every {kind}"


def _span(group: Sequence[PeakMisfit]) -> str:
    """Such as "15 to 20 % low"."""
    values = sorted((m.relative for m in group), key=abs)
    first, last = in_percent(values[0]), in_percent(values[-1])
    return last if first == last else f"{first.split(' ')[0]} to {last}"


def _aside(named: Sequence[PeakMisfit], damping: Mapping[int, PeakMisfit], plan: Plan) -> str:
    """What the phase tells of the damping at these peaks, where it does: whether the losses are to blame."""
    known = [(m, damping[m.direction.test]) for m in named if m.direction.test in damping]
    if not known:
        return ""
    sizes = np.array([d.severity for _, d in known])
    opposite = all(d.relative * m.relative < 0 for m, d in known)
    where = "" if len(known) == len(named) else f" at {_listed([_name(plan, m) for m, _ in known])}"
    if opposite and np.all(sizes > _LOSSES):
        return f" (damping {_span([d for _, d in known])}{where})"
    small = np.array([d.severity < max(_NO_LOSSES, FAR_LESS * m.severity) for m, d in known])
    return f" (damping right{where})" if small.all() and min(m.severity for m, _ in known) > 2 * _NO_LOSSES else ""


def _name(plan: Plan, misfit: PeakMisfit) -> str:
    several = len(dict.fromkeys(c.mode for c in plan.conditions)) > 1
    mode = plan.conditions[misfit.direction.test].mode
    return f"{mode} {level_of(plan, misfit.direction.test)}" if several else level_of(plan, misfit.direction.test)


def _listed(levels: Sequence[str]) -> str:
    return ", ".join(dict.fromkeys(levels))
