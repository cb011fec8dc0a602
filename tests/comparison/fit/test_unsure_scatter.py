"""Few assemblies: what they differ by is learnt from them, whatever was assumed, and intervals know how well."""

import numpy as np
import pytest

from updamp.comparison.fit.repeat_scatter import _independent
from updamp.comparison.fit.scatter import Assembly, Scatter, learn
from updamp.comparison.fit.unsure_scatter import widening

PLACES = np.linspace(-1, 1, 24)
COMMON = np.column_stack([np.ones(24), PLACES, PLACES**2])
TRUE = np.array([1.0, 2.0, 3.0])
WIDE = np.full(3, 1e3)


def assemblies(rng: np.random.Generator, count: int, deviation: float) -> list[Assembly]:
    """Of a parabola whose first two coefficients differ from one assembly to the next, with noise of unit size"""
    made = []
    for repeat in range(count):
        random = COMMON[:, :2]
        y = COMMON @ TRUE + random @ rng.normal(0, deviation, 2) + rng.normal(0, 1, len(COMMON))
        made.append(Assembly(repeat, y, COMMON, random, ("level", "slope"), np.zeros(2)))
    return made


def estimate(made: list[Assembly], scatter: Scatter) -> tuple[np.ndarray, np.ndarray]:
    """(3,) generalised least squares with the covariance written out, and (3, 3) its covariance"""
    information, right = np.zeros((3, 3)), np.zeros(3)
    for a in made:
        spread = a.random * a.deviations(scatter)
        weighed = np.linalg.solve(scatter.noise**2 * (np.eye(len(a.residual)) + spread @ spread.T), a.common)
        information, right = information + a.common.T @ weighed, right + weighed.T @ a.residual
    covariance = np.linalg.inv(information)
    return covariance @ right, covariance


@pytest.mark.parametrize("assumed", [3.0, 0.3], ids=["as assumed", "ten times it"])
def test_intervals_of_three_assemblies_hold_the_truth(assumed):
    """In 120 draws 95 % are 114 +- 2.4; taking what was learnt for exact holds 80 to 105 of them."""
    rng = np.random.default_rng(11)
    inside, taken_for_exact = np.zeros(3), np.zeros(3)
    for _ in range(120):
        made = assemblies(rng, 3, 3.0)
        scatter = learn(made, Scatter({"level": assumed, "slope": assumed}), furthest=np.inf)
        found, covariance = estimate(made, scatter)
        off = np.abs(found - TRUE) / 1.96
        taken_for_exact += off < np.sqrt(np.diag(covariance))
        inside += off < np.sqrt(np.diag(covariance + widening(made, scatter, WIDE)))
    assert np.all(inside >= 104), inside
    assert np.all(taken_for_exact[:2] < 106), taken_for_exact
    assert inside[2] == taken_for_exact[2], "all assemblies have the curvature in common"


def test_what_repeats_differ_by_is_found_far_from_what_is_assumed():
    """A prior of a factor of e against eight assemblies pulls by ten to the power 1 / 15."""
    made = assemblies(np.random.default_rng(2), 8, 3.0)
    close = learn(made, Scatter({"level": 3.0, "slope": 3.0}), furthest=np.inf).parameters
    for assumed in (0.3, 30.0):
        far = learn(made, Scatter({"level": assumed, "slope": assumed}), furthest=np.inf).parameters
        assert far["level"] == pytest.approx(close["level"], rel=0.3)
        assert far["slope"] == pytest.approx(close["slope"], rel=0.3)


def test_one_assembly_tells_no_scatter_that_could_be_unsure():
    made = assemblies(np.random.default_rng(3), 1, 3.0)
    assert not widening(made, Scatter({"level": 3.0, "slope": 3.0}), WIDE).any()


def test_widening_is_of_what_assemblies_differ_in():
    """A sum in which the offsets cancel is known as well as before."""
    made = _independent(assemblies(np.random.default_rng(4), 3, 3.0))
    more = widening(made, Scatter({"level": 3.0, "slope": 3.0}), WIDE)
    assert np.linalg.eigvalsh(more).min() > -1e-9 * np.trace(more)
