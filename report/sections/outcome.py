"""On top: the verdict in words, what stands out of the scatter, and the numbers behind it."""

import math
from html import escape

from scipy.stats import chi2

from updamp.comparison.comparison import ASKED_FIRST, LACK_OF_FIT, Comparison, Finding
from updamp.comparison.fit.failing_model import RISK
from updamp.report.markup import level_name, level_word, number, paragraph
from updamp.report.section import Content, Report, ReportSection

FEW = 5  # findings that are not folded away
BEFORE_SEARCH = """The model that the search for the missing effect began with: calibrated, without any effect that the
verdict on top of this page names. What of it stands out of the scatter:"""

TO_LOOK_AT = "Runs and points to look at, whatever the model does:"


def render(report: Report) -> Content:
    """Where the page has the verdict of a diagnosis, that is the only one."""
    comparison = report.comparison
    html = ""
    if comparison.questions:
        html += "".join(paragraph(text) for text in (f"{ASKED_FIRST.capitalize()}:", *comparison.questions))
    if report.verdict is None:
        html += f'<p class="verdict {_kind(comparison)}">{escape(verdict_sentence(comparison))}</p>'
    else:
        html += paragraph(BEFORE_SEARCH if comparison.findings else verdict_sentence(comparison))
    if comparison.findings:
        html += _findings([_finding(finding, comparison) for finding in comparison.findings])
    if comparison.to_look_at:
        html += paragraph(TO_LOOK_AT) + "".join(f"<p>{escape(odd)}</p>" for odd in comparison.to_look_at)
    return Content(html + _cards(comparison))


def _findings(entries: list[str]) -> str:
    """The first few, the others folded away: the numbers below are to be seen too."""
    if len(entries) <= FEW + 1:
        return f'<ol class="findings">{"".join(entries)}</ol>'
    return (
        f'<ol class="findings">{"".join(entries[:FEW])}</ol>'
        f"<details><summary>{len(entries) - FEW} more</summary>"
        f'<ol class="findings" start="{FEW + 1}">{"".join(entries[FEW:])}</ol></details>'
    )


def verdict_sentence(comparison: Comparison) -> str:
    if comparison.adequate:
        return "The model agrees with the measurement: no misfit beyond repeatability."
    several = len(comparison.findings)
    if several == 0:
        return "The model does not describe the measurement: the misfit exceeds repeatability, without a clear pattern."
    things = "one thing stands" if several == 1 else f"{several} things stand"
    if within_scatter(comparison):
        return f"The misfit as a whole is of the size of the scatter; {things} out of it."
    return f"The model does not describe the measurement: {things} out of the scatter."


def within_scatter(comparison: Comparison) -> bool:
    """Whether chi-square is no larger than chance has it in all but RISK of the cases: what stands out then is too
    small beside the scatter to be seen in the misfit as a whole."""
    if (told := comparison.provenance.get(LACK_OF_FIT)) is not None:
        return float(told) >= RISK
    free = comparison.values - comparison.parameters
    return free > 0 and float(chi2.sf(comparison.chi2_after, free)) >= RISK


def _kind(comparison: Comparison) -> str:
    if comparison.adequate:
        return "fair" if comparison.questions else "good"
    return "fair" if within_scatter(comparison) else "bad"


def _finding(finding: Finding, comparison: Comparison) -> str:
    where = [
        finding.mode or "all modes",
        level_name(finding.level, comparison.level_unit)
        if finding.level is not None
        else f"all {level_word(comparison)}s",
    ]
    where += [finding.channel] if finding.channel else []
    tags = "".join(f'<span class="tag">{escape(tag)}</span>' for tag in (finding.quantity, *where))
    sure = (
        f"{number(abs(finding.significance), 2)} standard deviations of the scatter"
        if math.isfinite(finding.significance)
        else "scatter not known"
    )
    return f'<li><p>{escape(finding.text)}</p><p class="small">{tags}{sure}</p></li>'


def _cards(comparison: Comparison) -> str:
    free = max(comparison.values - comparison.parameters, 1)
    rms = [math.sqrt(chi2 / max(comparison.values, 1)) for chi2 in (comparison.chi2_before, comparison.chi2_after)]
    repeats = {(c.run, m.repeat) for c in comparison.curves for m in c.measured}
    names = ("Misfit before calibration", "Misfit after calibration") if comparison.calibration else ("Misfit",)
    cards = [
        *((name, number(value, 3), "times the scatter") for name, value in zip(names, rms, strict=False)),
        ("Reduced chi-square", number(comparison.chi2_after / free, 3), f"χ² over {free} degrees of freedom"),
    ]
    if comparison.curves:
        runs = {curve.run for curve in comparison.curves}
        channels = {curve.channel for curve in comparison.curves}
        what = f"{len(repeats)} sweeps in all, {len(channels)} channel{'s' if len(channels) > 1 else ''}"
        cards.append(("Runs compared", str(len(runs)), what))
    else:
        cards.append(("Stated features", str(len(comparison.features)), "no measured curve"))
    inside = "".join(
        f'<div class="card"><dt>{name}</dt><dd><strong>{value}</strong><span>{unit}</span></dd></div>'
        for name, value, unit in cards
    )
    return f'<dl class="cards">{inside}</dl>'


SECTION = ReportSection("outcome", "Calibrated model against the measurement", render, "Comparison")
