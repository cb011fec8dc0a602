"""The page of a study in a real browser: drawn without an error, and what is pointed at is shown."""

import shutil

import pytest
from selenium import webdriver
from selenium.webdriver.common.by import By
from selenium.webdriver.support.ui import Select
from support.modal_study import write_study
from support.study_runs import run

from updamp.design.page.page import study_page, write_page
from updamp.design.page.sensitivities import rank_correlations

GOALS = (
    '[[responses]]\nname = "twin"\nkind = "free_frequency"\n'
    '[[objectives]]\nresponse = "free"\n[[objectives]]\nresponse = "twin"\ngoal = "maximise"\n'
    '[[constraints]]\nresponse = "free"\nupper = "95 Hz"\n'
)


@pytest.fixture
def result(folder):
    return run(write_study(folder, 'kind = "latin_hypercube"\nsamples = 9', GOALS))


def test_ranks_tell_what_acts_and_which_way(result):
    found = {(one.response, one.variable): one.value for one in rank_correlations(result)}
    assert found["free", "frequency"] == pytest.approx(1)
    assert abs(found["free", "mass"]) < 0.9


def test_nothing_leaves_the_page(result):
    html = study_page(result)
    assert "default-src 'none'" in html
    assert "<script src" not in html


def test_the_page_draws_and_shows_the_design_that_is_chosen(result, tmp_path):
    chromium, driver = shutil.which("chromium"), shutil.which("chromedriver")
    if chromium is None or driver is None:
        pytest.skip("chromium or chromedriver is missing: apt-get install chromium chromium-driver")
    write_page(tmp_path / "study.html", result)
    options = webdriver.ChromeOptions()
    options.binary_location = chromium
    for argument in ("--headless=new", "--no-sandbox", "--disable-dev-shm-usage", "--window-size=1280,1600"):
        options.add_argument(argument)
    options.set_capability("goog:loggingPrefs", {"browser": "ALL"})
    browser = webdriver.Chrome(options, webdriver.ChromeService(driver))
    try:
        browser.get((tmp_path / "study.html").as_uri())
        assert browser.get_log("browser") == []
        assert browser.find_element(By.TAG_NAME, "body").get_attribute("data-ready") == "yes"
        across = Select(browser.find_element(By.ID, "study-x"))
        assert across.first_selected_option.text == "free [Hz]", "two objectives against each other to begin with"
        across.select_by_visible_text("mass [g]")
        points = browser.execute_script("return updamp.plot('designs').data.map(t => t.x.length)")
        assert sum(points) == 9
        lines = browser.execute_script("return updamp.plot('parallel').data.map(t => t.x.length)")
        assert sum(lines) == 9 * (4 + 1), "four axes and a break a design"
        browser.execute_script("updamp.plot('designs').emit('plotly_hover', {points: [{customdata: 4}]})")
        assert browser.find_element(By.ID, "study-picture").text.startswith("Design 5")
    finally:
        browser.quit()
