"""The page as text: complete, self-contained, safe with whatever stands in the data."""

import json
import math
import re
from dataclasses import replace
from html.parser import HTMLParser
from pathlib import Path
from typing import Any

import numpy as np
import plotly.graph_objects as go
import pytest
from support.synthetic_comparison import features_only, synthetic_comparison
from support.synthetic_verdict import synthetic_verdict

from updamp.comparison.comparison import Comparison, UnlikeRun
from updamp.diagnosis.verdict import Explanation
from updamp.report.markup import MINUS, MISSING, TIMES, level_name, number, percent, with_unit
from updamp.report.page import build_page, write_report
from updamp.report.registry import SECTIONS
from updamp.report.section import Content, Report, ReportSection
from updamp.report.sections.outcome import SECTION as OUTCOME
from updamp.report.sections.outcome import TO_LOOK_AT

PNG = b"\x89PNG\r\n\x1a\n" + bytes(40)
HOSTILE = '</script><img src=x onerror="window.broken=1">&<b>'


class Tags(HTMLParser):
    def __init__(self) -> None:
        super().__init__()
        self.found: list[tuple[str, dict[str, str | None]]] = []

    def handle_starttag(self, tag: str, attrs: list[tuple[str, str | None]]) -> None:
        self.found.append((tag, dict(attrs)))


def tags_of(page: str) -> list[tuple[str, dict[str, str | None]]]:
    parser = Tags()
    parser.feed(page)
    return parser.found


def data_of(page: str) -> dict[str, Any]:
    found = re.search(r'<script type="application/json" id="report-data">(.*?)</script>', page, re.DOTALL)
    assert found
    data: dict[str, Any] = json.loads(found[1])
    return data


@pytest.fixture(scope="module")
def comparison() -> Comparison:
    return synthetic_comparison()


@pytest.fixture(scope="module")
def page(comparison: Comparison) -> str:
    return build_page(Report(comparison, synthetic_verdict(comparison), {"Slip at 17 N": PNG}), SECTIONS)


def test_ten_curves_stay_below_eight_megabytes(comparison: Comparison, tmp_path: Path) -> None:
    path = tmp_path / "report.html"
    write_report(comparison, path)
    assert len({curve.run for curve in comparison.curves}) == 10
    assert path.stat().st_size < 8e6


def test_nothing_is_fetched(page: str) -> None:
    places = [(tag, a.get("src"), a.get("href")) for tag, a in tags_of(page)]
    assert not [place for place in places if place[1] and not place[1].startswith("data:")]
    assert not [place for place in places if place[2] and not place[2].startswith(("#", "data:"))]
    assert "default-src 'none'" in page


def test_every_section_is_there_and_linked(page: str) -> None:
    ids = [a["id"] for _, a in tags_of(page) if "id" in a]
    assert len(ids) == len(set(ids))
    for section in SECTIONS:
        assert section.identifier in ids
        assert f'href="#{section.identifier}"' in page


def test_pictures_and_plots_say_what_they_show(page: str) -> None:
    plots = [a for _, a in tags_of(page) if a.get("role") == "img"]
    assert len(plots) == 10
    assert all(len(str(a["aria-label"])) > 40 for a in plots)
    assert [a["alt"] for tag, a in tags_of(page) if tag == "img"] == ["Slip at 17 N"]


def test_figures_are_what_plotly_knows(page: str) -> None:
    figures = data_of(page)["figures"]
    assert set(figures) == {"contact-states", "gains", "confounding", "missing-force", "waterfall"}
    for figure in figures.values():
        go.Figure(figure["data"], figure["layout"])  # raises for an unknown property


def test_curves_in_the_page_are_those_compared(comparison: Comparison, page: str) -> None:
    for shown, curve in zip(data_of(page)["sections"]["response"]["curves"], comparison.curves, strict=True):
        np.testing.assert_allclose(shown["after"]["a"], 1e3 * np.abs(curve.after.receptance), rtol=1e-6)
        for values, measured in zip(shown["measured"], curve.measured, strict=True):
            complex_value = np.array(values["a"]) * np.exp(1j * np.radians(values["p"]))
            np.testing.assert_allclose(complex_value, 1e3 * measured.receptance, rtol=1e-5)
            assert np.abs(np.diff(values["p"])).max() < 180  # no curve is cut in two


def test_runs_that_are_unlike_their_repeats_are_shown_on_top(comparison: Comparison) -> None:
    run = UnlikeRun("OOP 17 N", "OOP", "17 N", 2, 6.2, 1e-9)
    page = build_page(Report(replace(comparison, unlike_repeats=(run,)), None, {}), SECTIONS)
    assert run.text in page
    assert TO_LOOK_AT not in build_page(Report(comparison, None, {}), SECTIONS)


def test_volts_are_shown_as_volts_and_phases_that_nobody_recorded_not_at_all(comparison: Comparison) -> None:
    silent = tuple(
        replace(curve, measured=tuple(replace(m, has_phase=False) for m in curve.measured))
        for curve in comparison.curves
    )
    own = replace(comparison, curves=silent, response_unit="V", force_unit="A", level_unit="A")
    data = data_of(build_page(Report(own, synthetic_verdict(comparison), {}), SECTIONS))
    assert data["units"] == {"displacement": "V", "receptance": "V/A"}
    assert data["level"] == {"unit": "A", "word": "force level"}
    shown, curve = data["sections"]["response"]["curves"][0], comparison.curves[0]
    np.testing.assert_allclose(shown["measured"][0]["a"], np.abs(curve.measured[0].receptance), rtol=1e-6)
    assert set(shown["measured"][0]["p"]) == {None}
    assert None not in shown["after"]["p"]
    figure = str(data["figures"]["missing-force"])
    assert "missing stiffness [A/V]" in figure
    assert "µm" not in figure


def test_cells_of_the_map_hold_every_residual_once(comparison: Comparison, page: str) -> None:
    maps = data_of(page)["sections"]["misfit"]["maps"]
    cells = [cell for each in maps for row in each["cells"] for cell in row if cell]
    assert sum(cell["n"] for cell in cells) == len(comparison.residuals)
    total = sum(cell["n"] * cell["size"] ** 2 for cell in cells)
    assert total == pytest.approx(sum(r.size**2 for r in comparison.residuals), rel=1e-5)


def test_page_opens_at_the_worst_curve(comparison: Comparison, page: str) -> None:
    start = comparison.curves[data_of(page)["sections"]["response"]["start"]]
    mean: dict[tuple[str, str], float] = {}
    for curve in comparison.curves:
        mine = [r.size**2 for r in comparison.residuals if (r.run, r.channel) == (curve.run, curve.channel)]
        mean[curve.run, curve.channel] = float(np.mean(mine))
    assert (start.run, start.channel) == max(mean, key=lambda key: mean[key])


def test_sections_without_content_are_left_out() -> None:
    page = build_page(Report(features_only()), SECTIONS)
    shown = {a["id"] for tag, a in tags_of(page) if tag == "section"}
    assert shown == {"outcome", "features", "assumptions", "provenance"}
    assert "selection.js" not in page
    assert "above the stated range" in page


def test_sensor_noise_is_a_factor_the_rest_relative(page: str) -> None:
    assert f"1.08 {TIMES} what is stated, or read off the runs" in page
    assert "4 %" in page


def test_adequate_model_is_called_so(comparison: Comparison) -> None:
    page = build_page(Report(replace(comparison, adequate=True, findings=())), SECTIONS)
    assert "no misfit beyond repeatability" in page


def test_a_misfit_of_the_size_of_the_scatter_is_not_called_a_failure(comparison: Comparison) -> None:
    free = comparison.values - comparison.parameters
    close, far = (build_page(Report(replace(comparison, chi2_after=r * free)), SECTIONS) for r in (0.99, 4.0))
    assert 'class="verdict fair">The misfit as a whole is of the size of the scatter' in close
    assert "does not describe" not in close
    assert 'class="verdict bad">The model does not describe the measurement' in far


def test_a_page_has_one_verdict(comparison: Comparison) -> None:
    page = build_page(Report(comparison, synthetic_verdict(comparison)), SECTIONS)
    assert page.count('class="verdict ') == 1
    assert "does not describe the measurement" not in page
    assert comparison.findings[0].text in page


def test_every_verdict_has_its_words(comparison: Comparison) -> None:
    verdict = synthetic_verdict(comparison)
    group = ("shaker_attachment", "blade_mistuning")
    page = build_page(Report(comparison, replace(verdict, verdict="inseparable", effects=(), group=group)), SECTIONS)
    assert "these data cannot tell which" in page
    assert "Cannot be separated" in page
    for outcome in ("adequate", "unknown", "undecidable"):
        bare = replace(
            verdict, verdict=outcome, effects=(), history=verdict.history[:1],
            error=replace(verdict.error, held_out_before=math.nan, held_out_after=math.nan),
        )  # fmt: skip
        assert 'class="verdict' in build_page(Report(comparison, bare), SECTIONS)


def explained(comparison: Comparison, **changes: object) -> str:
    """The part of the page that says how likely each explanation is."""
    page = build_page(Report(comparison, replace(synthetic_verdict(comparison), **changes)), SECTIONS)
    return page.partition("How likely, of what was fitted")[2].partition("</table>")[0]


def test_the_best_explanations_are_shown_whatever_the_verdict(comparison: Comparison) -> None:
    for outcome in ("identified", "unknown"):
        found = explained(comparison, verdict=outcome)
        assert found.index("material_damping") < found.index("contact_viscosity")
        assert all(text in found for text in ("very likely", "97 %", "3 %", "< 1 %"))
        assert "nothing is missing" not in found, "the fourth, of less than a percent"
    assert explained(comparison, explanations=()) == ""


def test_what_is_calibrated_together_with_what_is_missing_stands_beside_it(comparison: Comparison) -> None:
    told = "All above is of the model without effects. Together with material_damping:"
    both = tuple(replace(each, after=1.2345) for each in comparison.calibration)

    def page(**changes: object) -> str:
        return build_page(Report(comparison, replace(synthetic_verdict(comparison), **changes)), SECTIONS)

    together = page(calibration=both).partition(told)[2].partition("</table>")[0]
    assert together.count("1.23") >= len(both)
    assert told not in page(calibration=both, verdict="unknown", effects=())
    assert told not in page(calibration=())


def test_what_cannot_be_told_apart_has_one_probability(comparison: Comparison) -> None:
    each = (Explanation(("a",), 0.7, 1.0, 1.0), Explanation(("b",), 0.2, 1.05, 1.0), Explanation((), 0.1, 2.0, 2.0))
    found = explained(comparison, verdict="inseparable", effects=(), group=("a", "b"), explanations=each)
    assert "<code>a</code> or <code>b</code>" in found
    assert "90 %" in found
    assert "70 %" not in found


def test_what_is_missing_whichever_of_a_group_is_stands_beside_it(comparison: Comparison) -> None:
    each = (
        Explanation(("a", "b"), 0.7, 1.0, 1.0), Explanation(("c", "a"), 0.2, 1.05, 1.0),
        Explanation(("b", "c"), 0.06, 1.5, 2.0), Explanation(("a",), 0.04, 1.5, 2.0),
    )  # fmt: skip
    changes = {"verdict": "inseparable", "effects": ("a", "b"), "group": ("b", "c"), "explanations": each}
    found = explained(comparison, **changes)
    assert "<code>a</code>, and <code>b</code> or <code>c</code>" in found
    assert all(text in found for text in ("90 %", "6 %", "4 %"))
    page = build_page(Report(comparison, replace(synthetic_verdict(comparison), **changes)), SECTIONS)
    missing, _, apart = page.partition("<h3>Missing</h3>")[2].partition("<h3>Cannot be separated</h3>")
    assert missing.count("<li>") == 1
    assert "<code>a</code>" in missing
    assert apart.partition("</ul>")[0].count("<li>") == 2


def test_steps_without_held_out_data_say_so(comparison: Comparison) -> None:
    verdict = synthetic_verdict(comparison)
    history = tuple(replace(step, held_out=math.nan) for step in verdict.history)
    data = data_of(build_page(Report(comparison, replace(verdict, history=history)), SECTIONS))
    assert len(data["figures"]["waterfall"]["data"]) == 1
    assert any(a["text"] == "nothing was held out" for a in data["figures"]["waterfall"]["layout"]["annotations"])


def test_a_step_that_comes_twice_is_two_bars(comparison: Comparison) -> None:
    verdict = synthetic_verdict(comparison)
    history = (*verdict.history, *verdict.history[-2:])
    data = data_of(build_page(Report(comparison, replace(verdict, history=history)), SECTIONS))
    bars, axis = data["figures"]["waterfall"]["data"][0], data["figures"]["waterfall"]["layout"]["xaxis"]
    assert bars["x"] == axis["tickvals"] == list(range(len(history) + 1))
    assert len(set(axis["ticktext"])) < len(axis["ticktext"])


def test_many_findings_are_folded_away_after_the_first_ones(comparison: Comparison) -> None:
    findings = tuple(replace(comparison.findings[0], text=f"finding {k}", significance=-k) for k in range(1, 13))
    page = build_page(Report(replace(comparison, findings=findings)), SECTIONS)
    assert re.search(r"<summary>7 more</summary><ol class=\"findings\" start=\"6\"><li><p>finding 6<", page)
    assert all(f"finding {k}<" in page for k in range(1, 13))
    assert f"{MINUS}12 standard" not in page
    assert "more</summary>" not in build_page(Report(comparison), (OUTCOME,))


def test_levels_are_named_as_they_were_aimed_at() -> None:
    assert level_name(31.9901) == "32 N"
    assert level_name(0.096) == "0.096 N"
    assert level_name(1234.0, "m/s**2") == "1230 m/s²"


def test_words_from_the_data_stay_words(comparison: Comparison) -> None:
    finding = replace(comparison.findings[0], text=HOSTILE, mode=HOSTILE, channel=HOSTILE)
    curves = tuple(replace(curve, run=HOSTILE, mode=HOSTILE, channel=HOSTILE) for curve in comparison.curves[:2])
    hostile = replace(
        comparison, title=HOSTILE, findings=(finding,), curves=curves, assumptions=(HOSTILE,),
        provenance={HOSTILE: HOSTILE}, scatter={HOSTILE: 1.0},
        calibration=(replace(comparison.calibration[0], name=HOSTILE, unit=HOSTILE),),
        features=(replace(comparison.features[0], quantity=HOSTILE, mode=HOSTILE),),
    )  # fmt: skip
    page = build_page(Report(hostile, pictures={HOSTILE: PNG}), SECTIONS)
    assert [a for tag, a in tags_of(page) if tag == "img" and a.get("src") == "x"] == []
    assert data_of(page)["sections"]["response"]["curves"][0]["run"] == HOSTILE


def test_picture_that_is_no_png_is_named(comparison: Comparison, tmp_path: Path) -> None:
    with pytest.raises(ValueError, match="picture 'Slip' is no PNG"):
        write_report(comparison, tmp_path / "report.html", {"Slip": b"GIF89a"})


def test_new_section_needs_no_more_than_itself(comparison: Comparison) -> None:
    mine = ReportSection(
        "mine", "My section", lambda report: Content(f"<p>{report.comparison.values}</p>", data={"x": 1})
    )
    page = build_page(Report(comparison), (*SECTIONS, mine))
    assert f"<p>{comparison.values}</p>" in page
    assert data_of(page)["sections"]["mine"] == {"x": 1}


@pytest.mark.parametrize(
    ("value", "text"),
    [
        (0.0, "0"), (393.0, "393"), (269.05, "269.1"), (2.07e11, f"2.07 {TIMES} 10¹¹"), (0.1 + 0.2, "0.3"),
        (-3.4567e-7, f"{MINUS}3.457 {TIMES} 10⁻⁷"), (math.nan, MISSING), (math.inf, "∞"), (3.79984, "3.800"),
    ],
)  # fmt: skip
def test_numbers_are_written_as_engineers_do(value: float, text: str) -> None:
    assert number(value) == text


def test_units_and_per_cent() -> None:
    assert with_unit(6e10, "N/m**3") == f"6 {TIMES} 10¹⁰ N/m³"
    assert with_unit(math.nan, "Pa") == MISSING
    assert percent(0.0789) == "+7.9 %"
    assert percent(-0.31) == f"{MINUS}31 %"


def test_what_is_to_be_answered_first_stands_before_the_verdict(comparison: Comparison) -> None:
    """An adequate model that a unit stated wrongly was calibrated away for is not "good"."""
    asked = replace(comparison, adequate=True, findings=(), questions=("is it RMS & not peak?",))
    content = OUTCOME.render(Report(asked))
    assert content is not None
    assert content.html.index("is it RMS &amp; not peak?") < content.html.index('class="verdict fair"')
    sound = OUTCOME.render(Report(replace(asked, questions=())))
    assert sound is not None
    assert 'class="verdict good"' in sound.html
