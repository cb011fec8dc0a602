"""Small eigenvalues beside large ones keep their digits."""

import numpy as np
import pytest
import scipy.linalg

from updamp.hbm.graded_eigen import graded_eigh


def graded(rng: np.random.Generator, m: int, decades: float) -> tuple[np.ndarray, np.ndarray]:
    """D A D with a well-conditioned A; and D"""
    G = np.eye(m) + 0.3 * rng.normal(size=(m, m)) / np.sqrt(m)
    scale = 10.0 ** rng.permutation(np.linspace(0, decades / 2, m))
    return scale[:, None] * (G @ G.T) * scale, scale


def test_eigenvalues_of_the_inverse_are_the_inverse_ones():
    """Large eigenvalues of the inverse, which any solver gets right, are the small ones here."""
    rng = np.random.default_rng(4)
    matrix, scale = graded(rng, 12, 24.0)
    inverse = np.linalg.inv(matrix / np.outer(scale, scale)) / np.outer(scale, scale)
    lowest = 1 / scipy.linalg.eigvalsh((inverse + inverse.T) / 2)[::-1][:2]
    values, vectors = graded_eigh(matrix)
    np.testing.assert_allclose(values[:2], lowest, rtol=1e-13)
    np.testing.assert_allclose(vectors.T @ vectors, np.eye(12), atol=1e-13)
    assert abs(scipy.linalg.eigvalsh(matrix)[0] / lowest[0] - 1) > 1e-6  # or this test would show nothing


def test_every_vector_belongs_to_its_value():
    matrix, scale = graded(np.random.default_rng(5), 9, 12.0)
    values, vectors = graded_eigh(matrix)
    assert (np.diff(values) > 0).all()
    of_size_one = matrix / np.outer(scale, scale)
    left = of_size_one @ (scale[:, None] * vectors)
    np.testing.assert_allclose(left, vectors * values / scale[:, None], atol=1e-12 * np.abs(left).max())


@pytest.mark.parametrize("values", [(0.0, 0.0, 1.0, 3.0), (-1.0, 2.0, 5.0, 9.0)])
def test_without_positive_definiteness_it_is_the_usual_solver(values):
    Q = np.linalg.qr(np.random.default_rng(6).normal(size=(4, 4)))[0]
    matrix = Q * np.array(values) @ Q.T
    np.testing.assert_allclose(graded_eigh((matrix + matrix.T) / 2)[0], values, atol=1e-14)
