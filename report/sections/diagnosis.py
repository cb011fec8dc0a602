"""The verdict of the diagnosis in words."""

import math
from dataclasses import replace
from html import escape

from updamp.diagnosis.decision.explanations import in_words
from updamp.diagnosis.verdict import ErrorReached, Explanation, Outcome, Verdict
from updamp.report.markup import MISSING, number, table
from updamp.report.section import Content, Report, ReportSection

TITLES: dict[Outcome, str] = {
    "adequate": "Nothing is missing",
    "identified": "Missing effect identified",
    "inseparable": "One of a group is missing: these data cannot tell which",
    "unknown": "Something is missing that the catalogue does not hold",
    "undecidable": "These data do not suffice",
}
GOOD = ("adequate", "identified")
# Explanations that are shown: so many at least and at most, between them those of a percent or more.
LEAST, MOST, NOTEWORTHY = 3, 8, 0.01
TEXT = """<p>Each was taken for as likely as the others before the measurement. Whether any of them is right at all
shows in the misfit that the best one leaves: 1 is what the scatter leaves.</p>"""
HEAD = ("What is missing", "In words", "Probability", "Misfit left", "on held-out data")


def render(report: Report) -> Content | None:
    verdict = report.verdict
    if verdict is None:
        return None
    kind = "good" if verdict.verdict in GOOD else "bad"
    html = f'<p class="verdict {kind}">{TITLES[verdict.verdict]}.<br><span>{escape(verdict.sentence)}</span></p>'
    return Content(html + _names(verdict) + _cards(verdict.error) + _explanations(verdict) + _strip(verdict))


def _names(verdict: Verdict) -> str:
    sentences = {candidate.name: candidate.sentence for candidate in verdict.candidates}
    html = ""
    for title, names in (("Missing", verdict.outright), ("Cannot be separated", verdict.group)):
        items = "".join(f"<li><code>{escape(name)}</code> {escape(sentences.get(name, ''))}</li>" for name in names)
        html += f'<h3>{title}</h3><ul class="findings">{items}</ul>' if items else ""
    return html


def _explanations(verdict: Verdict) -> str:
    """The likeliest ones, however little they explain; nothing where there is but one."""
    alike = [e for e in verdict.explanations if _is_told_apart_by_nothing(e, verdict)]
    others = [(_joined(" and ", e.effects) or "nothing is missing", e) for e in verdict.explanations if e not in alike]
    if alike:  # what the verdict does not tell apart is not told apart here
        group = _joined(" or ", tuple(name for e in alike for name in e.effects if name in verdict.group))
        names = _joined(" and ", verdict.outright) + (f", and {group}" if verdict.outright else group)
        others.append((names, replace(alike[0], probability=sum(e.probability for e in alike))))
    if len(others) < 2:
        return ""
    best = sorted(others, key=lambda each: -each[1].probability)
    shown = [one for i, one in enumerate(best) if i < MOST and (i < LEAST or one[1].probability >= NOTEWORTHY)]
    return f"<h3>How likely, of what was fitted</h3>{TEXT}" + table(HEAD, [_row(*one) for one in shown], numbers_from=2)


def _is_told_apart_by_nothing(one: Explanation, verdict: Verdict) -> bool:
    """Of as many effects as the verdict's (of stated values alone it names none), some of them of its group."""
    outright, found = set(verdict.outright), set(one.effects)
    as_many = len(found) == max(len(verdict.effects), 1)
    return bool(verdict.group) and as_many and outright <= found <= outright | set(verdict.group)


def _joined(between: str, names: tuple[str, ...]) -> str:
    return between.join(f"<code>{escape(name)}</code>" for name in names)


def _row(names: str, each: Explanation) -> tuple[str, ...]:
    return (
        names,
        in_words(each.probability),
        _share(each.probability),
        number(each.misfit, 3),
        MISSING if math.isnan(each.held_out) else number(each.held_out, 3),
    )


def _share(probability: float) -> str:
    """Whole per cents; neither 0 nor 100."""
    if not NOTEWORTHY / 2 < probability < 1 - NOTEWORTHY / 2:
        return "> 99 %" if probability > 0.5 else "< 1 %"
    return f"{100 * probability:.0f} %"


def _strip(verdict: Verdict) -> str:
    """How it hangs on what was stated."""
    if not verdict.strip:
        return ""
    items = "".join(
        f"<li>from {100 * each.repeatability:g} %: {each.verdict}{escape(_of(each.effects))}</li>"
        for each in verdict.strip
    )
    return f'<h3>If another repeatability had been stated</h3><ul class="findings">{items}</ul>'


def _of(effects: tuple[str, ...]) -> str:
    return f" ({', '.join(effects)})" if effects else ""


def _cards(error: ErrorReached) -> str:
    cards = [
        ("Misfit in the fit", _fall(error.before, error.after)),
        ("Misfit on held-out data", _fall(error.held_out_before, error.held_out_after)),
        ("Repeatability", number(error.repeatability, 3)),
    ]
    known = (True, not math.isnan(error.held_out_before), not math.isnan(error.repeatability))
    cards = [card for card, shown in zip(cards, known, strict=True) if shown]
    inside = "".join(
        f'<div class="card"><dt>{name}</dt><dd><strong>{value}</strong><span>weighted residual RMS</span></dd></div>'
        for name, value in cards
    )
    return f'<dl class="cards">{inside}</dl>'


def _fall(before: float, after: float) -> str:
    return f"{number(before, 3)} → {number(after, 3)}"


SECTION = ReportSection("diagnosis", "Diagnosis", render)
