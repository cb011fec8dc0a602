"""What each effect would do to the data, over the residual that is to be explained."""

from updamp.report.markup import figure_element
from updamp.report.section import Content, Report, ReportSection

TEXT = """<p>Points: residual of the calibrated model. Line: what the effect would change, calibration taken out and
scaled to fit. The missing effect is the one whose line follows the points, over all force levels and both modes.</p>
<form class="controls" autocomplete="off"><label>Effect <select id="select-effect"></select></label>
<span>Mode, force level, channel and sweep as chosen above.</span></form>"""


def render(report: Report) -> Content | None:
    if report.verdict is None or not report.verdict.signatures:
        return None
    upwards = {curve.run: curve.upwards for curve in report.comparison.curves}
    rows = [
        {
            "effect": each.effect, "mode": each.mode, "level": each.level, "channel": each.channel,
            "up": upwards.get(each.run, True), "f": each.frequency,
            "amplitude": each.amplitude, "phase": each.phase,
            "residual": {"amplitude": each.residual_amplitude, "phase": each.residual_phase},
        }
        for each in report.verdict.signatures
    ]  # fmt: skip
    plot = figure_element(
        "signatures",
        "Change of amplitude and of phase that the chosen effect makes, against frequency, over the residual.",
        height=400,
    )
    return Content(TEXT + plot, data={"signatures": rows}, scripts=("selection.js", "signatures.js"))


SECTION = ReportSection("signatures", "Signatures against the residual", render, "Signatures")
