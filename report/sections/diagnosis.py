"""The verdict of the diagnosis in words."""

import math
from html import escape

from updamp.diagnosis.verdict import ErrorReached, Outcome, Verdict
from updamp.report.markup import number
from updamp.report.section import Content, Report, ReportSection

TITLES: dict[Outcome, str] = {
    "adequate": "Nothing is missing",
    "identified": "Missing effect identified",
    "inseparable": "One of a group is missing: these data cannot tell which",
    "unknown": "Something is missing that the catalogue does not hold",
    "undecidable": "These data do not suffice",
}
GOOD = ("adequate", "identified")


def render(report: Report) -> Content | None:
    verdict = report.verdict
    if verdict is None:
        return None
    kind = "good" if verdict.verdict in GOOD else "bad"
    html = f'<p class="verdict {kind}">{TITLES[verdict.verdict]}.<br><span>{escape(verdict.sentence)}</span></p>'
    return Content(html + _names(verdict) + _cards(verdict.error) + _strip(verdict))


def _names(verdict: Verdict) -> str:
    sentences = {candidate.name: candidate.sentence for candidate in verdict.candidates}
    title, names = ("Cannot be separated", verdict.group) if verdict.group else ("Missing", verdict.effects)
    items = "".join(f"<li><code>{escape(name)}</code> {escape(sentences.get(name, ''))}</li>" for name in names)
    return f'<h3>{title}</h3><ul class="findings">{items}</ul>' if items else ""


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
