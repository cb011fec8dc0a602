"""The report in a real browser, opened from disk."""

import base64
import json
import re
import shutil
from collections.abc import Callable, Iterator
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import plotly.graph_objects as go
import pytest
from selenium import webdriver
from selenium.webdriver.common.by import By
from selenium.webdriver.common.keys import Keys
from selenium.webdriver.support.ui import Select, WebDriverWait
from support.synthetic_comparison import LEVELS, synthetic_comparison
from support.synthetic_verdict import EFFECTS, synthetic_verdict

from updamp.comparison.comparison import Comparison, CurvePair, MeasuredCurve, ModelCurve
from updamp.report.page import write_report

WIDTH, HEIGHT = 1280, 800  # a laptop's
ARGUMENTS = ("--headless=new", "--no-sandbox", "--disable-dev-shm-usage", f"--window-size={WIDTH},{HEIGHT}")
PIXEL = base64.b64decode(
    "iVBORw0KGgoAAAANSUhEUgAAAAEAAAABCAYAAAAfFcSJAAAADUlEQVR42mNk+M9QDwADhgGAWjR9awAAAABJRU5ErkJggg=="
)


@pytest.fixture(scope="module")
def comparison() -> Comparison:
    return synthetic_comparison(sweeps=(True, False))


@pytest.fixture(scope="module")
def browser() -> Iterator[webdriver.Chrome]:
    chromium, driver = shutil.which("chromium"), shutil.which("chromedriver")
    if chromium is None or driver is None:
        pytest.skip("chromium or chromedriver is missing: apt-get install chromium chromium-driver")
    options = webdriver.ChromeOptions()
    options.binary_location = chromium
    for argument in ARGUMENTS:
        options.add_argument(argument)
    options.set_capability("goog:loggingPrefs", {"browser": "ALL", "performance": "ALL"})
    chrome = webdriver.Chrome(options, webdriver.ChromeService(driver))
    yield chrome
    chrome.quit()


@pytest.fixture(scope="module")
def opened(
    browser: webdriver.Chrome, comparison: Comparison, tmp_path_factory: pytest.TempPathFactory
) -> webdriver.Chrome:
    path = tmp_path_factory.mktemp("report") / "report.html"
    write_report(comparison, path, {"A dot": PIXEL}, synthetic_verdict(comparison))
    browser.get(path.as_uri())
    return browser


@pytest.fixture
def page(opened: webdriver.Chrome) -> Iterator[webdriver.Chrome]:
    """As opened, one curve on show; no test leaves an error in the console."""
    opened.execute_script("updamp.selection.select({mode: 'IP', level: 0.96, channel: 'tip_left', sweep: 'up'})")
    yield opened
    assert opened.get_log("browser") == []


def choose(page: webdriver.Chrome, what: str, text: str) -> None:
    Select(page.find_element(By.ID, f"select-{what}")).select_by_visible_text(text)


def chosen(page: webdriver.Chrome, what: str) -> str:
    return Select(page.find_element(By.ID, f"select-{what}")).first_selected_option.text


def traces(page: webdriver.Chrome, plot: str) -> list[dict[str, Any]]:
    found = page.execute_script("return JSON.stringify(document.getElementById(arguments[0]).data)", f"plot-{plot}")
    listed: list[dict[str, Any]] = json.loads(found)
    return listed


def measured(page: webdriver.Chrome, axis: str = "y") -> list[dict[str, Any]]:
    return [t for t in traces(page, "response") if t["mode"] == "markers" and t["yaxis"] == axis]


def shows(page: webdriver.Chrome, curves: list[CurvePair]) -> None:
    """The points on show are the repeats of these curves and no others."""
    expected = [1e3 * np.abs(m.receptance) for curve in curves for m in curve.measured]
    shown = measured(page)
    assert len(shown) == len(expected)
    for trace, values in zip(shown, expected, strict=True):
        np.testing.assert_allclose(trace["y"], values, rtol=1e-6)


@pytest.fixture
def pick(comparison: Comparison) -> Callable[..., list[CurvePair]]:
    def matching(**wanted: Any) -> list[CurvePair]:
        return [c for c in comparison.curves if all(getattr(c, name) == value for name, value in wanted.items())]

    return matching


def test_opens_from_disk_without_errors_or_requests(page: webdriver.Chrome) -> None:
    WebDriverWait(page, 10).until(lambda driver: driver.find_element(By.TAG_NAME, "body").get_attribute("data-ready"))
    messages = [json.loads(entry["message"])["message"] for entry in page.get_log("performance")]
    requests = [m["params"]["request"]["url"] for m in messages if m["method"] == "Network.requestWillBeSent"]
    assert len([url for url in requests if url.startswith("file:")]) == 1
    assert [url for url in requests if not url.startswith(("file:", "data:", "blob:"))] == []
    assert len(page.find_elements(By.CSS_SELECTOR, ".js-plotly-plot .main-svg")) >= 10
    assert page.find_elements(By.CSS_SELECTOR, "[data-title='Share chart...']") == []  # would send the data away


def test_mode_selector_changes_the_curves(page: webdriver.Chrome, pick: Callable[..., list[CurvePair]]) -> None:
    shows(page, pick(mode="IP", level=0.96, channel="tip_left", upwards=True))
    choose(page, "mode", "OOP")
    shows(page, pick(mode="OOP", level=0.96, channel="tip_left", upwards=True))
    assert page.find_element(By.ID, "selection").text == "Shown: OOP, 0.96 N, tip_left, sweep upwards."


def test_channel_and_level_selectors(page: webdriver.Chrome, pick: Callable[..., list[CurvePair]]) -> None:
    choose(page, "channel", "tip_right")
    choose(page, "level", "17 N")
    shows(page, pick(mode="IP", level=17.0, channel="tip_right", upwards=True))
    choose(page, "level", "all levels")
    shows(page, pick(mode="IP", channel="tip_right", upwards=True))
    legend = page.find_elements(By.CSS_SELECTOR, "#plot-response .legendtext")
    assert [entry.text for entry in legend] == [f"{level:g} N" for level in LEVELS]


def test_sweep_selector(page: webdriver.Chrome, pick: Callable[..., list[CurvePair]]) -> None:
    choose(page, "sweep", "▼ downwards")
    shows(page, pick(mode="IP", level=0.96, channel="tip_left", upwards=False))
    choose(page, "sweep", "both")
    shows(page, pick(mode="IP", level=0.96, channel="tip_left"))
    assert {t["marker"]["symbol"] for t in measured(page)} == {"triangle-up-open", "triangle-down-open"}


def test_what_a_sweep_jumps_over_is_dotted(page: webdriver.Chrome, pick: Callable[..., list[CurvePair]]) -> None:
    choose(page, "level", "17 N")
    branch = pick(mode="IP", level=17.0, channel="tip_left", upwards=True)[0].after
    lines = [t for t in traces(page, "response") if t["name"] == "calibrated model" and t["yaxis"] == "y"]
    solid, dotted = (
        np.array([y is not None for t in lines if (t["line"].get("dash") == "dot") == is_dotted for y in t["y"]])
        for is_dotted in (False, True)
    )
    assert 0 < (~branch.visited).sum() < len(branch.visited)
    np.testing.assert_array_equal(solid, branch.visited)
    assert dotted[~branch.visited].all()
    assert dotted.sum() <= (~branch.visited).sum() + 4  # its ends touch the solid line


def test_model_before_can_be_hidden_and_the_scale_changed(page: webdriver.Chrome) -> None:
    assert any(t["name"] == "before calibration" for t in traces(page, "response"))
    page.find_element(By.ID, "show-before").click()
    assert not any(t["name"] == "before calibration" for t in traces(page, "response"))
    page.find_element(By.ID, "show-before").click()
    page.find_element(By.ID, "logarithmic").click()
    assert page.execute_script("return document.getElementById('plot-response')._fullLayout.yaxis.type") == "log"
    page.find_element(By.ID, "logarithmic").click()


def test_click_on_the_map_selects_the_curve_and_marks_the_frequency(page: webdriver.Chrome) -> None:
    """A real click, in the middle of the worst cell of the other mode."""
    page.execute_script("document.getElementById('plot-residual-map').scrollIntoView({block: 'center'})")
    cell = page.execute_script(
        """const {maps} = updamp.data.misfit, plot = document.getElementById("plot-residual-map");
        const map = maps.findIndex(each => each.mode === "OOP"), {edges, cells, levels, up} = maps[map];
        let row = 0, column = 0;
        cells.forEach((line, r) => line.forEach((cell, c) => {
          if (cell && cell.size > (cells[row][column]?.size ?? 0)) [row, column] = [r, c];
        }));
        const x = plot._fullLayout["xaxis" + (map + 1)], y = plot._fullLayout["yaxis" + (map + 1)];
        const box = plot.getBoundingClientRect();
        return {...cells[row][column], level: levels[row], up: up[row],
          left: box.left + x._offset + x.l2p((edges[column] + edges[column + 1]) / 2),
          top: box.top + y._offset + y.l2p(row)};
        """
    )
    for kind, buttons in (("mouseMoved", 0), ("mousePressed", 1), ("mouseReleased", 1)):
        event = {
            "type": kind,
            "x": cell["left"],
            "y": cell["top"],
            "button": "left",
            "buttons": buttons,
            "clickCount": 1,
        }
        page.execute_cdp_cmd("Input.dispatchMouseEvent", event)
    WebDriverWait(page, 5).until(lambda driver: chosen(driver, "mode") == "OOP")
    assert chosen(page, "level") == f"{cell['level']:g} N"
    assert chosen(page, "channel") == cell["channel"]
    assert chosen(page, "sweep").endswith("upwards" if cell["up"] else "downwards")
    shapes = page.execute_script("return document.getElementById('plot-response').layout.shapes")
    assert [shape["x0"] for shape in shapes] == [cell["f"]]
    assert "Hz marked" in page.find_element(By.ID, "selection").text


def test_worst_places_work_from_the_keyboard(page: webdriver.Chrome) -> None:
    button = page.find_elements(By.CSS_SELECTOR, "#worst-places button")[0]
    text = button.text
    button.send_keys(Keys.ENTER)
    assert f" {chosen(page, 'mode')}, {chosen(page, 'level')}" in text
    assert text.endswith(chosen(page, "channel"))


def test_residuals_and_backbones_follow_the_selection(page: webdriver.Chrome, comparison: Comparison) -> None:
    for mode in ("OOP", "IP"):
        choose(page, "mode", mode)
        wanted = [
            r.amplitude for r in comparison.residuals if r.mode == mode and r.channel == "tip_left" and "_up" in r.run
        ]
        shown = [y for t in traces(page, "residual-amplitude") if t["yaxis"] == "y" for y in t["y"]]
        np.testing.assert_allclose(np.sort(shown), np.sort(wanted), rtol=1e-5)
        backbone = next(b for b in comparison.model_backbones if (b.mode, b.channel) == (mode, "tip_left"))
        line = next(t for t in traces(page, "backbones") if t["name"] == "calibrated model" and t["yaxis"] == "y")
        np.testing.assert_allclose(line["y"], backbone.frequency, rtol=1e-6)
        np.testing.assert_allclose(line["x"], 1e6 * backbone.amplitude, rtol=1e-6)


def test_signature_follows_effect_and_curve(page: webdriver.Chrome, comparison: Comparison) -> None:
    signatures = synthetic_verdict(comparison).signatures
    for effect in list(EFFECTS)[:2]:
        choose(page, "effect", effect)
        wanted = next(
            s for s in signatures if (s.effect, s.run, s.channel) == (effect, "ip_0.96N_up", "tip_left")
        )  # fmt: skip
        line = next(t for t in traces(page, "signatures") if t["mode"] == "lines" and t["yaxis"] == "y")
        assert line["name"] == effect
        np.testing.assert_allclose(line["y"], wanted.amplitude, rtol=1e-5)


def test_every_plot_is_what_plotly_knows(page: webdriver.Chrome) -> None:
    """A misspelt property is passed over in silence in the browser, but not here."""
    script = "return JSON.stringify([...document.querySelectorAll('.js-plotly-plot')].map(p => [p.data, p.layout]))"
    for data, layout in json.loads(page.execute_script(script)):
        go.Figure(data, layout)


@pytest.mark.parametrize("width", [1024, 1280])
def test_nothing_sticks_out_sideways(page: webdriver.Chrome, width: int) -> None:
    page.execute_cdp_cmd(
        "Emulation.setDeviceMetricsOverride", {"width": width, "height": 700, "deviceScaleFactor": 1, "mobile": False}
    )
    try:
        script = "return document.documentElement.scrollWidth"
        WebDriverWait(page, 5).until(
            lambda driver: driver.execute_script(script) <= width, "page wider than the window"
        )
    finally:
        page.execute_cdp_cmd("Emulation.clearDeviceMetricsOverride", {})


def test_prints_whole_plots_without_controls(page: webdriver.Chrome) -> None:
    page.execute_script(
        """window.widths = [];
        window.addEventListener("beforeprint", () => {
          window.widths = [...document.querySelectorAll(".js-plotly-plot")].map(plot => plot._fullLayout.width);
        });"""
    )
    answer = page.execute_cdp_cmd("Page.printToPDF", {"printBackground": True, "preferCSSPageSize": True})
    pdf = base64.b64decode(answer["data"])
    assert pdf.startswith(b"%PDF")
    assert 5 <= len(re.findall(rb"/Type\s*/Page\b", pdf)) <= 16
    widths = page.execute_script("return window.widths")
    assert len(widths) == 10
    assert set(widths) == {862}  # of the paper's 690, times 0.8
    size = "return document.getElementById('plot-response')._fullLayout.width"
    WebDriverWait(page, 5).until(lambda driver: driver.execute_script(size) > 900)  # as wide as before on screen
    page.execute_cdp_cmd("Emulation.setEmulatedMedia", {"media": "print"})
    hidden = page.find_elements(By.CSS_SELECTOR, "nav, .controls, .places, .modebar-container")
    assert len(hidden) >= 5
    assert not any(element.is_displayed() for element in hidden)
    page.execute_cdp_cmd("Emulation.setEmulatedMedia", {"media": ""})


def overlapping_labels(page: webdriver.Chrome) -> list[list[str]]:
    """Pairs of tick labels of one axis that lie over each other."""
    found: list[list[str]] = page.execute_script(
        """if (document.querySelectorAll("g.xtick text").length < 30) return [["none", "found"]];
        return [...document.querySelectorAll(".xaxislayer-above, .yaxislayer-above")].flatMap(layer => {
          const labels = [...layer.querySelectorAll("g[class$='tick'] text")].map(
            text => [text.textContent, text.getBoundingClientRect()]);
          return labels.flatMap(([one, a], i) => labels.slice(i + 1).filter(([, b]) => a.left < b.right
            && b.left < a.right && a.top < b.bottom - 3 && b.top < a.bottom - 3).map(([other]) => [one, other]));
        });"""
    )
    return found


def test_tick_labels_of_the_page_do_not_overlap(page: webdriver.Chrome) -> None:
    assert overlapping_labels(page) == []


def test_screenshot_is_no_blank_page(page: webdriver.Chrome, tmp_path: Path) -> None:
    """For the eye: the picture stays in pytest's folder."""
    page.execute_script("document.getElementById('response').scrollIntoView({behavior: 'instant'})")
    path = tmp_path / "report.png"
    assert page.save_screenshot(str(path))
    assert path.stat().st_size > 30_000


def test_words_from_the_data_run_no_code(browser: webdriver.Chrome, tmp_path: Path) -> None:
    """Names of runs, channels and modes reach plotly's legends, hovers and titles."""
    evil = '<img src="x" onerror="window.broken = 1"><script>window.broken = 1</script>'
    few = synthetic_comparison(levels=(0.96,), repeats=1, points=9)
    curves = tuple(replace(curve, run=evil, mode=evil, channel=evil) for curve in few.curves[:1])
    residuals = tuple(replace(r, run=evil, mode=evil, channel=evil) for r in few.residuals[:9])
    states = {evil: (0.25, 0.25, 0.25, 0.25)}
    path = tmp_path / "report.html"
    write_report(replace(few, curves=curves, residuals=residuals, contact_states=states, title=evil), path)
    browser.get(path.as_uri())
    assert browser.execute_script("return document.body.dataset.ready") == "yes"
    assert browser.execute_script("return window.broken") is None
    assert evil in browser.find_element(By.ID, "selection").text
    assert browser.get_log("browser") == []


def test_gaps_in_the_data_leave_gaps(browser: webdriver.Chrome, tmp_path: Path) -> None:
    """No solution of the model, points without a residual, a repeat without points, a single channel and level."""
    few = synthetic_comparison(levels=(0.96,), repeats=2, points=9)
    curve = few.curves[0]
    nothing = ModelCurve(np.zeros(0), np.zeros(0, complex), np.zeros(0, bool))
    empty = MeasuredCurve(2, np.zeros(0), np.zeros(0, complex), np.zeros(0))
    first = curve.measured[0]
    broken = replace(first, receptance=np.where(np.arange(9) == 3, np.nan, first.receptance))
    gap = replace(curve, measured=(broken, empty), after=nothing, before=nothing, band=np.zeros((0, 3)))
    unsolved = tuple(replace(r, size=np.nan, amplitude=np.nan) for r in few.residuals[:4])
    residuals = (*unsolved, *few.residuals[4:9])
    path = tmp_path / "report.html"
    write_report(replace(few, curves=(gap,), residuals=residuals, model_backbones=()), path)
    browser.get(path.as_uri())
    assert browser.execute_script("return document.body.dataset.ready") == "yes"
    assert browser.get_log("browser") == []
    assert "4 points without a solution of the model are left out" in browser.find_element(By.ID, "misfit").text
    assert [t["y"][3] for t in measured(browser) if t["y"]] == [None]
    assert not browser.find_element(By.ID, "select-mode").is_enabled()


def test_labels_of_logarithmic_axes_do_not_overlap(browser: webdriver.Chrome, tmp_path: Path) -> None:
    """Displacements over less than a decade to over four of them."""
    comparison = synthetic_comparison(levels=(5.0, 20.0, 30.0, 40.0, 50.0, 60.0, 70.0, 80.0))
    write_report(comparison, tmp_path / "report.html")
    browser.get((tmp_path / "report.html").as_uri())
    WebDriverWait(browser, 10).until(
        lambda driver: driver.find_element(By.TAG_NAME, "body").get_attribute("data-ready")
    )
    assert overlapping_labels(browser) == []
    ticks = browser.execute_script("return document.getElementById('plot-backbones')._fullLayout.xaxis3.tickvals")
    assert 3 <= len(ticks) <= 6
    colours = browser.execute_script(
        "return [...new Set(document.getElementById('plot-residual-amplitude').data.map(each => each.marker.color))]"
    )
    assert len(colours) == 8
    assert browser.get_log("browser") == []
