"""The posterior where it is known: one frequency that is stated, and a mass that it says nothing about."""

import json

import numpy as np
import pytest
from support.modal_study import write_study
from support.study_runs import run

from updamp.design.methods.posterior import Emulator, combinations, quadratic_terms
from updamp.design.outputs import write_outputs
from updamp.design.study_file import StudyError, read_study

TARGET = '[[objectives]]\nresponse = "free"\ngoal = "target"\ntarget = "85 Hz"\ntolerance = "2 Hz"\n'
METHOD = 'kind = "posterior"\nsamples = 16\nrounds = 1\ndesigns_a_round = 4'


def test_what_is_stated_is_determined_and_what_is_not_keeps_its_prior(folder):
    result = run(write_study(folder, METHOD, TARGET))
    assert len(result.records) == 20
    frequency, mass = result.method.draws["frequency"], result.method.draws["mass"]
    assert frequency.mean() == pytest.approx(85, abs=0.15)
    assert frequency.std() == pytest.approx(2, rel=0.05), "the tolerance, as the response is the variable"
    logs = np.log(mass / 500) / np.log(16)
    assert logs.mean() == pytest.approx(0.5, abs=0.02)
    assert logs.std() == pytest.approx(1 / np.sqrt(12), rel=0.05), "even over its bounds, which are logarithmic"
    summary = result.method.summary
    assert summary["emulator_error_in_tolerances"]["free"] < 1e-6
    assert summary["variables"]["mass"]["narrowed_to"] == pytest.approx(1, abs=0.03)
    narrow, wide = summary["combinations"]
    assert set(narrow["weights"]) == {"frequency"}
    assert narrow["deviation"] == pytest.approx(np.sqrt(12) * 2 / 40, rel=0.05)
    assert set(wide["weights"]) == {"mass"}
    later = [one.values["frequency"] for one in result.records[16:]]
    assert np.abs(np.array(later) - 85).max() < 8, "the second round is drawn from the posterior of the first"


def test_it_is_written_and_is_the_same_again(folder):
    path = write_study(folder, METHOD, TARGET)
    first, again = run(path), run(path)
    assert [one.values for one in first.records] == [one.values for one in again.records]
    names = write_outputs(first)
    assert {"posterior.csv", "posterior.png"} <= set(names)
    lines = (folder / "out" / "posterior.csv").read_text().splitlines()
    assert lines[0] == "frequency [Hz],mass [g]"
    assert len(lines) == 1 + len(first.method.draws["mass"])
    assert json.loads((folder / "out" / "study.json").read_text())["summary"]["share_of_prior"] < 0.5


def test_an_emulator_is_exact_for_a_quadratic_and_knows_its_error_where_it_is_not():
    rng = np.random.default_rng(3)
    shares, coefficients = rng.random((60, 3)), rng.standard_normal((10, 2))
    exact = quadratic_terms(shares) @ coefficients
    emulator = Emulator.fitted(shares, exact)
    np.testing.assert_allclose(emulator.coefficients, coefficients, atol=1e-6)
    assert emulator.error.max() < 1e-6
    noisy = Emulator.fitted(shares, exact + 0.3 * rng.standard_normal(exact.shape))
    assert noisy.error == pytest.approx(0.3 * np.sqrt(1 + 10 / 60), rel=0.3)
    with pytest.raises(ValueError, match="5 designs are known, at least 6 are needed"):
        Emulator.fitted(shares[:5], exact[:5])


def test_few_designs_do_where_products_are_small():
    rng = np.random.default_rng(5)
    shares, coefficients = rng.random((24, 6)), rng.standard_normal((28, 1))
    coefficients[7:] *= 0.01
    emulator = Emulator.fitted(shares, quadratic_terms(shares) @ coefficients)
    elsewhere = rng.random((500, 6))
    off = quadratic_terms(elsewhere) @ (emulator.coefficients - coefficients)
    assert np.sqrt(np.square(off).mean()) < 0.03, "28 coefficients from 24 designs"
    assert emulator.error[0] == pytest.approx(np.sqrt(np.square(off).mean()), rel=0.6)


def test_a_sum_that_is_determined_is_named():
    rng = np.random.default_rng(4)
    a = rng.random(20_000)
    draws = np.stack([a, 1 - a + 0.01 * rng.standard_normal(20_000), rng.random(20_000)], axis=1)
    first = combinations(draws, ["a", "b", "c"])[0]
    assert set(first["weights"]) == {"a", "b"}
    assert first["weights"]["a"] == pytest.approx(first["weights"]["b"], rel=0.01)
    assert first["deviation"] < 0.05


def test_it_wants_targets(folder):
    with pytest.raises(StudyError, match="targets are missing"):
        read_study(write_study(folder, METHOD))


def test_a_narrow_posterior_is_followed_by_designs_that_differ_and_says_what_it_rests_on(folder):
    narrow = TARGET.replace("2 Hz", "0.0001 Hz")
    result = run(write_study(folder, f"{METHOD}\ndraws = 50000", narrow))
    values = [tuple(one.values.values()) for one in result.records]
    assert len(set(values)) == len(values), "none is solved twice"
    assert result.method.summary["effective_draws"] < 100
    assert any("independent draws of 50000 from the bounds" in note for note in result.method.notes)
