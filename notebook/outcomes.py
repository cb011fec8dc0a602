"""What a comparison with a measurement, and a diagnosis, hand to a notebook."""

from dataclasses import dataclass
from html import escape
from math import isnan, sqrt
from pathlib import Path
from typing import TYPE_CHECKING

from updamp.comparison.comparison import Comparison
from updamp.diagnosis.verdict import Candidate, Verdict
from updamp.report.markup import drawn_units, number, paragraph, percent, table, with_unit

if TYPE_CHECKING:
    from updamp.pictures.style import NotebookFigure


@dataclass(frozen=True, eq=False, repr=False)
class ComparisonResult:
    """Model against measurement.

    comparison: all numbers, as in comparison.json (`comparison/comparison.py`); report: the HTML file
    """

    comparison: Comparison
    report: Path

    @property
    def adequate(self) -> bool:
        """Whether nothing stands out of the scatter of the measurement."""
        return self.comparison.adequate

    @property
    def findings(self) -> tuple[str, ...]:
        """Where the model fails, in sentences, largest misfit first."""
        return tuple(finding.text for finding in self.comparison.findings)

    @property
    def calibration(self) -> dict[str, float]:
        """What was fitted: name -> value, in the unit that the comparison states"""
        return {entry.name: entry.after for entry in self.comparison.calibration}

    @property
    def error(self) -> tuple[float, float]:
        """Weighted root mean square of the residuals before and after calibration, in standard deviations of the
        scatter; nan where no curve was measured"""
        c = self.comparison
        before, after = (sqrt(chi2 / c.values) if c.values else float("nan") for chi2 in (c.chi2_before, c.chi2_after))
        return before, after

    def plot(self) -> "NotebookFigure":
        """Every run at every channel: measured, model as given, calibrated. Shows itself in a notebook.

        raises: ValueError where no curve was measured
        """
        if not self.comparison.curves:
            raise ValueError("the measurement states features only and has no curve to draw: see `comparison.features`")
        from updamp.pictures.curves import comparison_figure  # on call: matplotlib takes 0.5 s to load

        return comparison_figure(self.comparison.curves, drawn_units(self.comparison).receptance)

    def __repr__(self) -> str:
        before, after = self.error
        outcome = "adequate" if self.adequate else f"{len(self.findings)} findings"
        return f"<ComparisonResult error {before:.3g} -> {after:.3g} times the scatter, {outcome}; {self.report}>"

    def _repr_html_(self) -> str:
        before, after = self.error
        head = ("", "as given", "calibrated", "95 % interval")
        rows = [("error, times the scatter", number(before, 3), number(after, 3), "")]
        rows += [
            (
                escape(c.name), with_unit(c.before, c.unit), with_unit(c.after, c.unit),
                f"{number(c.lower)} … {number(c.upper)}",
            )
            for c in self.comparison.calibration
        ]  # fmt: skip
        texts = self.findings or ("No misfit beyond the scatter of the measurement.",)
        return table(head, rows) + "".join(map(paragraph, texts))


@dataclass(frozen=True, eq=False, repr=False)
class DiagnosisResult:
    """Which effect the model lacks.

    verdict: all that was found, as in diagnosis.json (`diagnosis/verdict.py`); folder: for `add_effect`
    report: the HTML file, None where none was asked for
    """

    verdict: Verdict
    folder: Path
    report: Path | None

    @property
    def outcome(self) -> str:
        """ "adequate", "identified", "inseparable", "unknown" or "undecidable", as `Verdict` explains"""
        return self.verdict.verdict

    @property
    def sentence(self) -> str:
        """The verdict in plain words."""
        return self.verdict.sentence

    @property
    def effects(self) -> tuple[str, ...]:
        """Names of those that are missing whichever of a group is; empty where none was identified."""
        return self.verdict.outright

    def __repr__(self) -> str:
        return f"<DiagnosisResult {self.outcome}: {self.sentence}>"

    def _repr_html_(self) -> str:
        head = ("Effect", "Score", "Visible share", "Fall of the held-out error", "Value", "")
        rows = [_row(candidate) for candidate in self.verdict.candidates]
        return paragraph(f"{self.outcome}: {self.sentence}") + table(head, rows)


def _row(candidate: Candidate) -> tuple[str, ...]:
    values = ", ".join(f"{escape(p.name)} = {with_unit(p.value, p.unit)}" for p in candidate.parameters)
    gain = "" if isnan(candidate.held_out_gain) else percent(-candidate.held_out_gain)
    judged = "accepted" if candidate.accepted else escape(candidate.reason)
    return escape(candidate.name), number(candidate.score, 3), number(candidate.visibility, 2), gain, values, judged
