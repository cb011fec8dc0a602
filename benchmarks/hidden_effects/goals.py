"""The counts against what was asked for, with 95 % intervals."""

from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass

import numpy as np
from scipy.stats import binomtest

from updamp.benchmarks.hidden_effects.judgement import CONFIDENTLY_WRONG, CORRECT, Mark
from updamp.benchmarks.hidden_effects.scored_case import ScoredCase

LEVEL = 0.95
# What strong effects are to reach: errors before over after, on the data of the fit and on held-out ones; the last over
# repeatability; parameters.
BETTER, BETTER_HELD_OUT, FLOOR, PARAMETERS = 5.0, 3.0, 1.3, 0.15
SECONDS = 240.0
OUTSIDE = "'unknown' of those outside the catalogue, or the right name that it has for them since"


@dataclass(frozen=True)
class Goal:
    """count of `of` cases; wanted: in words; share: nan where there are none; wilson, exact: 95 % intervals of the
    share (Wilson 1927; Clopper and Pearson 1934); met: None where there are none"""

    name: str
    wanted: str
    count: int
    of: int
    share: float
    wilson: tuple[float, float]
    exact: tuple[float, float]
    met: bool | None


def goal(name: str, wanted: str, hits: Iterable[bool], met: Callable[[int, int], bool]) -> Goal:
    """hits: one of each case; met: of the count and of how many there are"""
    each = list(hits)
    return goal_of_counts(name, wanted, sum(each), len(each), met)


def goal_of_counts(name: str, wanted: str, k: int, n: int, met: Callable[[int, int], bool]) -> Goal:
    """k of n; met: of both"""
    if n == 0:
        nothing = (float("nan"), float("nan"))
        return Goal(name, wanted, 0, 0, float("nan"), nothing, nothing, None)
    test = binomtest(k, n)
    intervals = [test.proportion_ci(LEVEL, method) for method in ("wilson", "exact")]
    wilson, exact = ((float(i.low), float(i.high)) for i in intervals)
    return Goal(name, wanted, k, n, k / n, wilson, exact, met(k, n))


def identification(
    cases: Sequence[ScoredCase], mark: Callable[[ScoredCase], Mark], detectable: Callable[[ScoredCase], bool | None]
) -> tuple[Goal, ...]:
    """mark: of the whole diagnosis or of an ablation; detectable: by the laboratory's curves or the diagnosis itself"""
    single = [c for c in cases if c.kind == "single" and detectable(c)]

    def of(kind: str) -> list[ScoredCase]:
        return [c for c in cases if c.kind == kind]

    return (
        goal("right effect, or its group of two, of detectable single ones", "95 %",
             (mark(c) in CORRECT for c in single), lambda k, n: k >= 0.95 * n),
        goal("confidently wrong, of detectable single ones", "at most 2 %",
             (mark(c) in CONFIDENTLY_WRONG for c in single), lambda k, n: k <= 0.02 * n),
        goal("false alarms where nothing is hidden", "at most 1 of 24",
             (mark(c) == "false alarm" for c in of("none")), lambda k, n: k * 24 <= n),
        goal(OUTSIDE, "11 of 12",
             (mark(c) in CORRECT for c in of("outside")), lambda k, n: 12 * k >= 11 * n),
        goal("both of two effects", "9 of 12",
             (mark(c) in CORRECT for c in of("pair")), lambda k, n: 12 * k >= 9 * n),
    )  # fmt: skip


def carried_over(cases: Sequence[ScoredCase]) -> Goal:
    """Verdicts at 146 patches are those of the cases that they repeat."""
    known = {c.case: c for c in cases}
    pairs = [(c, known[c.repeats]) for c in cases if c.repeats in known]
    same = (
        (c.called.verdict, set(c.called.effects), set(c.called.group))
        == (o.called.verdict, set(o.called.effects), set(o.called.group))
        for c, o in pairs
    )
    return goal("same verdict at 146 patches", "3 of 3", same, lambda k, n: k == n)


def gains(cases: Sequence[ScoredCase]) -> tuple[Goal, ...]:
    """Of strong detectable effects that were found."""
    found = [c for c in cases if c.strength == "strong" and c.kind == "single" and c.detectable and c.mark in CORRECT]
    fitted = [c for c in found if c.recovered]

    def all_of(k: int, n: int) -> bool:
        return k == n

    return (
        goal(f"strong: error {BETTER:g} times lower", "all",
             (c.error.before >= BETTER * c.error.after for c in found), all_of),
        goal(f"strong: error on held-out data {BETTER_HELD_OUT:g} times lower", "all",
             (c.error.held_out_before >= BETTER_HELD_OUT * c.error.held_out_after for c in found), all_of),
        goal(f"strong: final error at most {FLOOR:g} times repeatability", "all",
             (c.error.after <= FLOOR * c.error.repeatability for c in found), all_of),
        goal("strong: parameters within 15 % of the truth", "all",
             (all(r.error <= PARAMETERS for r in c.recovered) for c in fitted), all_of),
        goal("strong: parameters' 95 % intervals hold the truth", "all",
             (all(r.inside for r in c.recovered) for c in fitted), all_of),
    )  # fmt: skip


def speed(cases: Sequence[ScoredCase]) -> Goal:
    small = [c for c in cases if c.kind != "resolution"]
    return goal(
        "diagnosis within 4 minutes of one core", "all", (c.processor <= SECONDS for c in small), lambda k, n: k == n
    )


def ablation_names(cases: Sequence[ScoredCase]) -> tuple[str, ...]:
    return tuple(dict.fromkeys(name for c in cases for name in c.ablations))


def ablated(cases: Sequence[ScoredCase], name: str) -> tuple[Goal, ...]:
    """The same counts for what an ablation says, over the cases that have it."""
    having = [c for c in cases if name in c.ablations]
    return identification(having, lambda c: c.ablations[name][1], lambda c: c.detectable)


def median_seconds(cases: Sequence[ScoredCase]) -> float:
    """Of one core"""
    return float(np.median([c.processor for c in cases])) if cases else float("nan")
