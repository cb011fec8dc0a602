"""The results as markdown: goals for docs/hidden_effects.md, every case for NOTES.md beside this file."""

from collections.abc import Sequence
from math import isfinite

from updamp.benchmarks.hidden_effects.goals import Goal, ablated, ablation_names, identification
from updamp.benchmarks.hidden_effects.scored_case import Detectability, ScoredCase

KINDS = {
    "single": "One effect", "none": "Nothing hidden", "outside": "Outside the catalogue", "pair": "Two effects",
    "resolution": "At 146 patches",
}  # fmt: skip
_STRENGTHS = ("strong", "medium", "weak", "")


def document(cases: Sequence[ScoredCase], goals: Sequence[Goal], planned: int) -> str:
    """Everything between the marks of the page."""
    parts = [f"{len(cases)} of {planned} cases are scored.", goal_table(goals), ablation_table(cases)]
    return "\n\n".join(part for part in parts if part)


def all_cases(cases: Sequence[ScoredCase]) -> str:
    """Everything between the marks of the notes."""
    parts = []
    for kind, title in KINDS.items():
        of_kind = [c for c in cases if c.kind == kind]
        if of_kind:
            parts += [f"### {title}", case_table(of_kind)]
    return "\n\n".join(parts)


def goal_table(goals: Sequence[Goal]) -> str:
    lines = ["| goal | wanted | reached | 95 % interval (Wilson; Clopper-Pearson) | met |", "|---|---|---|---|---|"]
    for g in goals:
        if g.of == 0:
            lines.append(f"| {g.name} | {g.wanted} | none yet | | |")
            continue
        both = "; ".join(f"{100 * low:.0f}-{100 * high:.0f} %" for low, high in (g.wilson, g.exact))
        lines.append(f"| {g.name} | {g.wanted} | {_count(g)} | {both} | {'yes' if g.met else 'no'} |")
    return "\n".join(lines)


def ablation_table(cases: Sequence[ScoredCase]) -> str:
    """A column for each ablation that was stored, beside the whole method over the cases that have any; "" for none."""
    names = ablation_names(cases)
    if not names:
        return ""
    whole = identification([c for c in cases if c.ablations], lambda c: c.mark, lambda c: c.detectable)
    columns = [whole, *(ablated(cases, name) for name in names)]
    head = " | ".join(("without a part of the method", "whole", *names))
    lines = [f"| {head} |", "|---" * (len(names) + 2) + "|"]
    for row in zip(*columns, strict=True):
        lines.append(f"| {row[0].name} | " + " | ".join(_count(g) if g.of else "-" for g in row) + " |")
    return "\n".join(lines)


def case_table(cases: Sequence[ScoredCase]) -> str:
    """Sorted by what is hidden, strongest first."""
    ordered = sorted(cases, key=lambda c: (c.truth, _STRENGTHS.index(c.strength), c.case))
    head = ("case", "hidden", "expected score, visibility", "verdict", "mark", "error", "held out", "s of one core")
    lines = ["| " + " | ".join(head) + " |", "|---" * len(head) + "|"]
    return "\n".join([*lines, *("| " + " | ".join(_cells(c)) + " |" for c in ordered)])


def _cells(c: ScoredCase) -> tuple[str, ...]:
    hidden = " + ".join(f"`{name}`" for name in c.truth) or "-"
    effects = c.by_laboratory or c.by_diagnosis
    not_detectable = " (not detectable)" if c.detectable is False else ""
    return (
        c.case[-3:],
        f"{hidden} {c.strength}".strip(),
        "; ".join(_score_and_visibility(s) for s in effects.values()) + not_detectable,
        verdict(c),
        c.mark if c.mark not in ("wrong", "false alarm") else f"**{c.mark}**",
        _fall(c.error.before, c.error.after),
        _fall(c.error.held_out_before, c.error.held_out_after),
        f"{c.processor:.0f}",
    )


def verdict(c: ScoredCase) -> str:
    if not c.called.names_something:
        return c.called.verdict
    group = f"one of {', '.join(f'`{n}`' for n in c.called.group)}" if c.called.verdict == "inseparable" else ""
    outright = [n for n in c.called.effects if c.called.verdict == "identified" or n not in c.called.group]
    return "; ".join(filter(None, [" + ".join(f"`{n}`" for n in outright), group]))


def _score_and_visibility(s: Detectability) -> str:
    return f"{s.score:.0f}, {s.visibility:.2f}" if isfinite(s.score) else "-"


def _fall(before: float, after: float) -> str:
    return f"{before:.2g} to {after:.2g}" if isfinite(before) and isfinite(after) else "-"


def _count(g: Goal) -> str:
    return f"{g.count} of {g.of}"
