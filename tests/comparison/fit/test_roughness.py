"""Noise read off runs: its size, and how well few points tell it."""

import numpy as np
import pytest
from scipy.stats import multivariate_normal, norm

from updamp.comparison.fit.roughness import KNOWN_FROM_ONE, known_to, roughness, shrunk


def test_noise_is_told_from_the_roughness_of_a_run():
    rng = np.random.default_rng(0)
    x = np.linspace(0, 3, 400)
    assert roughness(np.sin(x) + 0.01 * rng.standard_normal(400)) == pytest.approx(0.01, rel=0.15)


def test_how_well_it_is_known_follows_from_the_correlation_of_third_differences():
    quartile = norm.ppf(0.75)
    within = [(-quartile, -1), (quartile, 1)]
    variance = 0.25
    for r in (-0.75, 0.3, -0.05):
        both = sum(s * t * multivariate_normal.cdf([a, b], cov=[[1, r], [r, 1]]) for a, s in within for b, t in within)
        variance += 2 * (both - 0.25)
    assert np.sqrt(variance) / (2 * norm.pdf(quartile) * quartile) == pytest.approx(KNOWN_FROM_ONE, rel=1e-3)


@pytest.mark.parametrize("points", [12, 15, 40, 100])
def test_it_is_known_as_well_as_in_draws(points: int):
    rng = np.random.default_rng(points)
    drawn = [np.log(roughness(each)) for each in rng.standard_normal((4000, points))]
    assert np.std(drawn) == pytest.approx(known_to(points), rel=0.1)


@pytest.mark.parametrize("points", [15, 40])
def test_runs_of_one_noise_are_drawn_together_whatever_their_points(points: int):
    rng = np.random.default_rng(points)
    left = [
        np.std(shrunk(levels, [points] * 12)) / np.std(levels)
        for levels in (np.log([roughness(run) for run in rng.standard_normal((12, points))]) for _ in range(200))
    ]
    assert np.mean(left) < 0.25


def test_runs_that_really_differ_stay_apart():
    rng = np.random.default_rng(2)
    deviations = np.geomspace(0.001, 0.1, 12)
    levels = np.log([roughness(s * rng.standard_normal(40)) for s in deviations])
    assert np.std(shrunk(levels, [40] * 12)) > 0.9 * np.std(levels)
