"""Springs added to modes and residual are exact: compared with the full matrices."""

import warnings
from dataclasses import replace

import numpy as np
import pytest
import scipy.linalg
import scipy.sparse

from updamp.hbm.problem.linear_model import LinearModel, add_springs, from_matrices
from updamp.hbm.problem.modal_algebra import DirectInverse


@pytest.fixture
def chain():
    """12 masses in a chain, 3 relative displacements and a point."""
    rng = np.random.default_rng(2)
    n = 12
    K = 2 * np.eye(n) - np.eye(n, k=1) - np.eye(n, k=-1)
    M = np.diag(rng.uniform(0.5, 1.5, n))
    rows = rng.normal(size=(3, n))
    return M, K, rows, {"tip": np.eye(n)[-1]}


def truncated(M, K, rows, points, kept) -> LinearModel:
    """`kept` modes and the exact static residual of the others."""
    full = from_matrices(M, np.zeros_like(M), K, rows, points)
    every = np.vstack([rows, *points.values()])
    residual = (
        every @ np.linalg.inv(K) @ every.T - full.phi[:, :kept] / full.omega_squared[:kept] @ full.phi[:, :kept].T
    )
    return replace(
        full,
        omega_squared=full.omega_squared[:kept],
        phi=full.phi[:, :kept],
        residual=residual,
        hysteretic=np.zeros((kept, kept)),
        viscous=np.zeros((kept, kept)),
    )


def test_without_truncation_frequencies_and_receptance_are_those_of_the_matrices(chain):
    M, K, rows, points = chain
    k = np.array([0.7, 2.0, 0.1])
    stiffened = add_springs(from_matrices(M, np.zeros_like(M), K, rows, points), np.eye(4, 3), k)
    K2 = K + rows.T * k @ rows
    np.testing.assert_allclose(stiffened.omega_squared, scipy.linalg.eigvalsh(K2, M), rtol=1e-10)
    every = np.vstack([rows, *points.values()])
    np.testing.assert_allclose(
        stiffened.receptance(0.37), every @ np.linalg.solve(K2 - 0.37**2 * M, every.T), rtol=1e-9, atol=1e-12
    )


def test_with_truncation_static_flexibility_stays_exact(chain):
    """The residual takes part: with springs however stiff the static receptance is that of the full model."""
    M, K, rows, points = chain
    every = np.vstack([rows, *points.values()])
    for k in (np.array([0.7, 2.0, 0.1]), np.array([1e4, 1e5, 1e3])):
        stiffened = add_springs(truncated(M, K, rows, points, 4), np.eye(4, 3), k)
        np.testing.assert_allclose(
            stiffened.receptance(0.0).real, every @ np.linalg.solve(K + rows.T * k @ rows, every.T), atol=1e-10
        )


def test_springs_one_by_one_or_all_at_once(chain):
    model, k = truncated(*chain, 5), np.array([0.7, 2.0, 0.1])
    at_once = add_springs(model, np.eye(4, 3), k)
    in_turn = model
    for i in range(3):
        in_turn = add_springs(in_turn, np.eye(4)[:, [i]], k[[i]])
    np.testing.assert_allclose(in_turn.receptance(0.4), at_once.receptance(0.4), rtol=1e-9, atol=1e-12)


def test_a_spring_of_no_stiffness_changes_nothing(chain):
    model = truncated(*chain, 5)
    same = add_springs(model, np.eye(4, 1), np.zeros(1))
    np.testing.assert_allclose(same.receptance(0.3), model.receptance(0.3), rtol=1e-11)


def test_unknown_point_names_those_there_are(chain):
    with pytest.raises(KeyError, match="tip"):
        truncated(*chain, 5).row("root")


@pytest.mark.parametrize(
    ("given", "said"),
    [
        ({"K": np.array([[2.0, 1.0], [0.0, 2.0]])}, "K is not symmetric"),
        ({"M": np.array([[1.0, 0.1], [0.0, 1.0]])}, "M is not symmetric"),
        ({"C": np.eye(3)}, r"C has shape \(3, 3\)"),
        ({"K": np.eye(2) * (2 + 0.02j)}, r"K is complex; .* hysteretic=eta"),
        ({"C": np.eye(2) * 0.02j}, "C is complex"),
        ({"K": np.full((2, 2), np.nan)}, "K has entries that are not finite"),
        ({"M": np.diag([1.0, 0.0])}, r"M is not positive definite: M\[1, 1\] = 0; every degree of freedom needs"),
        (
            {"M": np.array([[1.0, 3.0], [3.0, 8.0]])},
            "M is not positive definite: .* degree of freedom 0, counted from 0",
        ),
        ({"points": {"tip": np.zeros(2)}}, "point 'tip' is a row of zeros"),
        ({"relative": np.array([1.0, 0.0])}, r"relative has shape \(2,\)"),
        ({"points": {"tip": np.ones(3)}}, r"point 'tip' has shape \(3,\): \(2,\) is needed"),
    ],
)
def test_matrices_that_cannot_be_are_refused(given, said):
    """Of a K that is not symmetric one half was taken; one row given flat counted as two relative displacements."""
    matrices = {"M": np.eye(2), "C": np.zeros((2, 2)), "K": 2 * np.eye(2), "relative": np.eye(1, 2), "points": {}}
    with pytest.raises(ValueError, match=said):
        from_matrices(**(matrices | given))


@pytest.mark.parametrize(
    ("given", "error", "said"),
    [
        ({"M": 1.0}, ValueError, r"M has shape \(\): \(1, 1\) is needed"),
        ({"M": []}, ValueError, r"M has shape \(0,\): \(1, 1\) or more is needed"),
        ({"M": np.zeros((0, 0))}, ValueError, r"M has shape \(0, 0\): \(1, 1\) or more is needed"),
        (
            {"K": [["1", "0"], ["0", "1"]]},
            TypeError,
            r"K = \[\['1', '0'\], \['0', '1'\]\]: an array of numbers is needed",
        ),
        ({"K": [[1.0, 0.0], [1.0]]}, ValueError, r"K = \[\[1.0, 0.0\], \[1.0\]\]: its rows are of different lengths"),
        ({"C": scipy.sparse.eye(2)}, TypeError, r"C is sparse; .* give C.toarray\(\)"),
        ({"relative": None}, TypeError, "relative = None: an array of numbers"),
        ({"relative": 1.0}, ValueError, r"relative has shape \(\): \(1, 2\) is needed"),
        ({"points": ["a", "b"]}, TypeError, r"points = \['a', 'b'\]: a dict is needed, name -> row of 2 numbers"),
        ({"points": np.eye(2)}, TypeError, r"points = array\(.*: a dict is needed"),
        ({"points": {"tip": "x"}}, TypeError, "point 'tip' = 'x': an array of numbers"),
    ],
)
def test_what_is_no_matrix_is_named(given, error, said):
    """It was NumPy's own sentence."""
    matrices = {"M": np.eye(2), "C": np.zeros((2, 2)), "K": 2 * np.eye(2), "relative": np.eye(1, 2), "points": {}}
    with pytest.raises(error, match=said):
        from_matrices(**(matrices | given))


def test_lists_will_do_for_matrices():
    whole = [[2, -1], [-1, 2]]
    model = from_matrices([[1, 0], [0, 1]], whole, whole, [[1, 0.5]], {"tip": [1, 0]})
    same = from_matrices(np.eye(2), np.array(whole), np.array(whole), np.array([[1, 0.5]]), {"tip": np.eye(2)[0]})
    for one, other in ((model.phi, same.phi), (model.viscous, same.viscous), (model.omega_squared, same.omega_squared)):
        assert one.dtype == np.float64
        np.testing.assert_array_equal(one, other)
    assert from_matrices([[1]], [[0]], [[1]], [[1]], []).points == ()


def test_of_negative_damping_there_is_a_warning():
    """It was taken without a word. What round-off leaves, and gyroscopic forces, are none."""
    M, K = np.eye(2), np.diag([2.0, 3.0])
    with pytest.warns(
        UserWarning, match=r"C has negative damping, -0.02, .* degree of freedom 1, .* may then be unstable"
    ):
        model = from_matrices(M, np.diag([0.01, -0.02]), K, np.eye(2))
    np.testing.assert_allclose(np.diag(model.viscous), [0.01, -0.02])
    share = np.array([[1.0, -1 / 3], [-1 / 3, 1 / 9]])  # singular but for round-off
    for C in (np.zeros((2, 2)), share, share.T - 1e-12 * np.eye(2), np.array([[0.0, 0.7], [-0.7 + 1e-16, 0.0]])):
        from_matrices(M, C, K, np.eye(2))


def test_a_degree_of_freedom_with_hardly_any_mass_is_no_reason_to_warn():
    """Each inverse had its warning of an ill-conditioned matrix, where rows differ in size alone."""
    M, K, C = np.diag([1.0, 1e-18]), np.array([[2.0, -1.0], [-1.0, 2.0]]), np.array([[0.02, 0.01], [0.0, 0.02]])
    model, w = from_matrices(M, C, K, np.eye(2)), 1.3
    inverse = DirectInverse(model.omega_squared, model.hysteretic, model.viscous)
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        H = model.phi @ inverse.at(w, (1,)).matrix(0) @ model.phi.T
    np.testing.assert_allclose(H, np.linalg.inv(K - w**2 * M + 1j * w * C), rtol=1e-6)


def test_gyroscopic_damping_is_taken_whole():
    M, K, C = np.eye(2), np.diag([2.0, 3.0]), np.array([[0.05, 0.6], [-0.6, 0.08]])
    model, w = from_matrices(M, C, K, np.eye(2)), 1.3
    np.testing.assert_allclose(model.receptance(w), np.linalg.inv(K - w**2 * M + 1j * w * C), atol=1e-14)
