"""Linear algebra of the modes: inverses of their dynamic stiffness at any frequency, and a symmetric eigenproblem
whose small eigenvalues keep their digits.

The inverses come from one decomposition if damping is hysteretic alone. With S = diag(1 / omega) the stiffness is
S^-1 (M - w^2 S^2) S^-1, M = I + i S hysteretic S. M and S^2 are symmetric, so that there are Y with Y^T M Y = I and
Y^T S^2 Y = diag(mu), and the inverse is (S Y) diag(1 / (1 - w^2 mu)) (S Y)^T. Scaled like this, modes
that are a thousand times as stiff as others cost these no digits.

`graded_eigh` is for matrices whose entries span many orders of magnitude: LAPACK's usual solvers err by round-off times
the largest eigenvalue. Stuck modes of a rig reach from 0.4 to 200 kHz: of the lowest one's frequency squared 11 digits
are left, and near resonance at a loss factor of 0.1 % 8 digits of the response. One-sided Jacobi on the Cholesky factor
(Demmel and Veselic 1992, SIAM J. Matrix Anal. Appl. 13, 1204-1245) finds every eigenvalue to round-off times the
condition of the matrix scaled to a unit diagonal: 14 digits.
"""

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import Protocol

import numpy as np
import scipy.linalg
from numpy.typing import NDArray

Floats = NDArray[np.float64]
Complex = NDArray[np.complex128]

# Of Y^T M Y from the identity, beyond which Y is not used: modes that coincide need not come out orthogonal.
_ORTHOGONAL = 1e-10


class ModalResponse(Protocol):
    """Inverses of the modes' dynamic stiffness at n multiples of one frequency, or of each of several."""

    def times(self, loads: Complex) -> Complex:
        """(m, n, ...) amplitudes of modal loads, of one multiple after the other, of several frequencies (m, n,
        n_frequencies, ...) -> the modes' amplitudes"""
        ...

    def rate_times(self, loads: Complex) -> Complex:
        """Likewise, their derivative by the frequency"""
        ...

    def matrix(self, number: int) -> Complex:
        """(m, m) at one of the multiples of the one frequency"""
        ...


class ModalInverse(Protocol):
    """Of the modes' dynamic stiffness at any frequency."""

    def at(self, w: float | Floats, orders: Sequence[int]) -> ModalResponse:
        """At orders, all above 0, times the angular frequency w > 0 [rad/s], one or (n_frequencies,)."""
        ...


@dataclass(frozen=True, eq=False)
class DecomposedInverse:
    """modes: (m, m) S Y; mu: (m,)"""

    modes: Complex
    mu: Complex

    def at(self, w: float | Floats, orders: Sequence[int]) -> ModalResponse:
        k = np.asarray(orders, dtype=float)
        gains = 1 / (1 - np.multiply.outer(self.mu, np.multiply.outer(k, w) ** 2))
        rates = 2 * np.multiply.outer(self.mu, np.multiply.outer(k**2, w)) * gains**2
        return DecomposedResponse(self.modes, gains, rates)


@dataclass(frozen=True, eq=False)
class DecomposedResponse:
    """modes: (m, m); gains, rates: (m, n) 1 / (1 - (k w)^2 mu) and its derivative by w; (m, n, n_frequencies) of
    several frequencies"""

    modes: Complex
    gains: Complex
    rates: Complex

    def times(self, loads: Complex) -> Complex:
        return self._scaled(loads, self.gains)

    def rate_times(self, loads: Complex) -> Complex:
        return self._scaled(loads, self.rates)

    def matrix(self, number: int) -> Complex:
        return np.asarray((self.modes * self.gains[:, number]) @ self.modes.T)

    def _scaled(self, loads: Complex, factors: Complex) -> Complex:
        decoupled = (self.modes.T @ loads.reshape(len(loads), -1)).reshape(loads.shape)
        decoupled *= factors.reshape(*factors.shape, *(1 for _ in loads.shape[factors.ndim :]))
        return np.asarray(self.modes @ decoupled.reshape(len(loads), -1)).reshape(loads.shape)


@dataclass(frozen=True, eq=False)
class DirectInverse:
    """omega_squared: (m,); hysteretic, viscous: (m, m), as in `LinearModel`"""

    omega_squared: Floats
    hysteretic: Floats
    viscous: Floats

    def at(self, w: float | Floats, orders: Sequence[int]) -> ModalResponse:
        return DirectResponse(self, w, tuple(orders))


@dataclass(frozen=True, eq=False)
class DirectResponse:
    """inverse: of which this is the response at orders times w"""

    inverse: DirectInverse
    w: float | Floats
    orders: tuple[int, ...]

    def times(self, loads: Complex) -> Complex:
        return _one_by_one(self._matrices, loads)

    def rate_times(self, loads: Complex) -> Complex:
        k = np.asarray(self.orders, dtype=float)
        kw = np.multiply.outer(k**2, self.w)[..., None, None]
        viscous = k.reshape(-1, *(1 for _ in kw.shape[1:])) * self.inverse.viscous
        return _one_by_one(-self._matrices, _one_by_one(1j * viscous - 2 * kw * np.eye(len(loads)), self.times(loads)))

    def matrix(self, number: int) -> Complex:
        return np.asarray(self._matrices[number])

    @cached_property
    def _matrices(self) -> Complex:
        """(n, m, m), or (n, n_frequencies, m, m)"""
        i = self.inverse
        frequencies = np.multiply.outer(np.asarray(self.orders, dtype=float), self.w)
        stiffness = [dynamic_stiffness(i.omega_squared, i.hysteretic, i.viscous, kw) for kw in frequencies.ravel()]
        return np.stack([_graded_inverse(each) for each in stiffness]).reshape(*frequencies.shape, *i.viscous.shape)


def _graded_inverse(stiffness: Complex) -> Complex:
    """Of a matrix whose rows may be of very different size, as those of modes with hardly any mass are: each row and
    column over the same power of 2, which rounds nothing off, it is inverted without a warning."""
    sizes = np.abs(np.diagonal(stiffness))
    scale = np.exp2(-np.round(np.log2(np.where(sizes > 0, sizes, 1.0)) / 2))
    both = np.outer(scale, scale)
    return np.asarray(both * scipy.linalg.inv(both * stiffness))


def _one_by_one(matrices: Complex, loads: Complex) -> Complex:
    """(..., m, m) times the parts of loads (m, ..., n_columns) or (m, ...)"""
    columns = loads.reshape(len(loads), *matrices.shape[:-2], -1)
    return np.asarray(np.moveaxis(matrices @ np.moveaxis(columns, 0, -2), -2, 0)).reshape(loads.shape)


def dynamic_stiffness(omega_squared: Floats, hysteretic: Floats, viscous: Floats, w: float) -> Complex:
    """(m, m) at w > 0, of matrices as in `LinearModel`"""
    return np.asarray(np.diag(omega_squared - w**2) + 1j * (hysteretic + w * viscous))


def modal_inverse(omega_squared: Floats, hysteretic: Floats, viscous: Floats) -> ModalInverse:
    """Decomposed where it can be, else inverted anew at every frequency."""
    if viscous.any() or omega_squared.min() <= 0:
        return DirectInverse(omega_squared, hysteretic, viscous)
    scale = 1 / np.sqrt(omega_squared)
    M = np.eye(len(scale)) + 1j * scale[:, None] * hysteretic * scale
    mu, Y = scipy.linalg.eig(np.linalg.solve(M, np.diag(scale**2)))
    Y = Y / np.sqrt(np.einsum("ij,ij->j", Y, M @ Y))
    if np.abs(Y.T @ M @ Y - np.eye(len(scale))).max() > _ORTHOGONAL:
        return DirectInverse(omega_squared, hysteretic, viscous)
    return DecomposedInverse(scale[:, None] * Y, mu)


# dgejsv: accurate whatever the scaling of rows and columns, left vectors, no right ones, all sizes, not transposed
_FULL_ACCURACY, _LEFT, _NONE, _ALL_SIZES, _AS_GIVEN, _UNPERTURBED = 2, 0, 3, 0, 0, 0


def graded_eigh(matrix: Floats) -> tuple[Floats, Floats]:
    """Eigenvalues, rising, and eigenvectors (orthonormal columns) of a symmetric matrix (m, m).

    Where it is not positive definite, as with rigid-body modes, those of LAPACK's usual solver.
    raises: numpy.linalg.LinAlgError where Jacobi's method does not converge
    """
    order = np.argsort(-np.diag(matrix), kind="stable")
    try:
        factor = np.linalg.cholesky(matrix[np.ix_(order, order)])
    except np.linalg.LinAlgError:
        values, vectors = scipy.linalg.eigh(matrix)
        return values, vectors
    sizes, left, _, work, _, status = scipy.linalg.lapack.dgejsv(
        factor, _FULL_ACCURACY, _LEFT, _NONE, _ALL_SIZES, _AS_GIVEN, _UNPERTURBED
    )
    if status != 0:
        raise np.linalg.LinAlgError(f"Jacobi's method for {len(matrix)} modes did not converge (dgejsv: {status})")
    vectors = np.empty_like(left)
    vectors[order] = left
    return (sizes * work[0] / work[1])[::-1] ** 2, vectors[:, ::-1]
