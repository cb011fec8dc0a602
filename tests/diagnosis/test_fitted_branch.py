"""A branch with the sizes found for the patterns of numerical error is what the fit compares with."""

import numpy as np
from support.small_model import condition, parametrisation

from updamp.diagnosis.fitted_branch import at_sizes
from updamp.diagnosis.model.numerical_error import NumericalError
from updamp.diagnosis.model.predicted_branch import trace_branch, with_patterns


def test_patterns_are_added_as_the_fit_adds_them() -> None:
    plain = trace_branch(parametrisation(), np.zeros(4), condition(40.0))
    observed = plain.at(plain.place).value
    n, m = observed.shape
    pattern = np.zeros((n, 1, m))
    pattern[:, 0] = [0.002, 0.05, 0.03, -0.04, 0.0]
    none = np.zeros((n, m))
    name = plain.condition.name
    numerics = NumericalError(("shift",), {name: observed}, {name: none}, {name: pattern}, {name: none})
    branch = with_patterns(plain, numerics)
    u = np.array([0, 0, 0, 0, 1.5])
    fitted = at_sizes(branch, u)
    place = np.linspace(branch.place[0], branch.place[-1], 200)
    before, after = branch.at(place), fitted.at(place)
    expected = before.value + before.slopes[:, 4] * 1.5
    turns = np.round((after.value - expected)[:, 2::2] / (2 * np.pi))
    expected[:, 2::2] += 2 * np.pi * turns
    np.testing.assert_allclose(after.value, expected, atol=1e-3)
    np.testing.assert_allclose(fitted.u, u)
    assert at_sizes(fitted, u) is fitted
    # a parameter of the model: the branch stands where it was solved
    np.testing.assert_array_equal(at_sizes(branch, np.array([0.1, 0, 0, 0, 0])).state, branch.state)
