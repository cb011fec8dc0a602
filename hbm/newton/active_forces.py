"""Three ways to solve y + T G y = b, the equations of the elements that depart from stuck."""

from functools import cached_property
from typing import Any

import numpy as np
import scipy.linalg
from numpy.typing import NDArray
from scipy.linalg.lapack import sgetrs

from updamp.hbm.newton.active_operator import ActiveOperator
from updamp.hbm.newton.krylov import gmres
from updamp.hbm.newton.tangent import apply_tangent, real_form
from updamp.hbm.problem.receptance import Receptance
from updamp.hbm.problem.system import Departure

Floats = NDArray[np.float64]
Integers = NDArray[np.int64]

# Of what is left of each of many right-hand sides, where they are iterated on.
_MANY = 1e-9


class DirectForces:
    """The matrix I + T_S: G_:S on the active rows S, formed and factorised.

    The unknowns are ordered by harmonic, then row, so that what belongs to a harmonic lies together. Factorised is the
    transpose: in memory it is what LAPACK asks for.
    """

    def __init__(self, receptance: Receptance, departure: Departure, rows: Integers) -> None:
        self.rows, self._place = rows, _places(receptance, len(rows))
        matrix = _active_matrix(receptance, departure, rows, self._place)
        self._factors = scipy.linalg.lu_factor(matrix.T, overwrite_a=True, check_finite=False)

    def __call__(self, b: Floats, start: Floats | None = None) -> Floats:  # noqa: ARG002  a direct solver needs none
        y = np.zeros_like(b)
        y[self.rows] = self.solve(b[self.rows])
        return y

    @property
    def unknowns(self) -> int:
        return self._place.size

    @property
    def factors(self) -> "DirectForces":
        return self

    def solve_roughly(self, right: Floats) -> Floats:
        """On the active rows, in single precision: (n_active n_coefficients,) -> same. A preconditioner needs no more,
        and half the memory is read. It is scaled by its largest entry, which single precision may not hold."""
        factors, pivots = self._single
        order, size = self._place.ravel(), float(np.abs(right).max()) or 1.0
        ordered = np.empty(len(order), np.float32)
        ordered[order] = right / size
        return size * np.asarray(sgetrs(factors, pivots, ordered, trans=1, overwrite_b=True)[0][order], np.float64)

    def solve(self, right: Floats) -> Floats:
        """On the active rows, (n_active, n_coefficients, ...) -> same"""
        ordered = np.empty((self._place.size, *right.shape[2:]))
        ordered[self._place] = right
        solution = scipy.linalg.lu_solve(self._factors, ordered, trans=1, overwrite_b=True, check_finite=False)
        return np.asarray(solution[self._place])

    @cached_property
    def _single(self) -> tuple[NDArray[np.float32], NDArray[np.signedinteger[Any]]]:
        return np.asfortranarray(self._factors[0], np.float32), self._factors[1]

    @property
    def determinant_sign(self) -> float:
        """That of det(I + T G) = det J."""
        return _determinant_sign(self._factors)


class KrylovForces:
    """GMRES with the operator applied through modes and residual.

    With the factors of a point nearby as a preconditioner, what has changed since is all that is iterated on. Without,
    the reference springs are one already: with contact stiffness K and flexibility R the eigenvalues of G K lie at
    l / (1 + l), l those of R K, so those of I + T G lie between 1 / (1 + max l) and about 1, but for a few of resonant
    modes. Where it does not converge the equations are factorised and solved directly.

    near: factors of a similar matrix, on rows of its own, or None
    tolerance: of the residual, relative to b (with factors, of the preconditioned one, not below single precision);
        Newton's convergence becomes linear with this factor
    """

    def __init__(
        self,
        receptance: Receptance,
        departure: Departure,
        rows: Integers,
        near: DirectForces | None = None,
        tolerance: float = 1e-5,
    ) -> None:
        self._receptance, self._departure, self._rows, self._near = receptance, departure, rows, near
        self._unknowns = rows if near is None else np.union1d(rows, near.rows)
        self._known = slice(None) if near is None else _of_rows(self._unknowns, near.rows, receptance)
        self._operator = ActiveOperator(receptance, departure, self._unknowns)
        self._tolerance = tolerance
        self.iterations = 0

    def __call__(self, b: Floats, start: Floats | None = None) -> Floats:
        """start: a first guess of y, such as the solution for a nearby point"""
        if "_direct" in self.__dict__:
            return self._direct(b)
        right, first = b[self._unknowns].ravel(), None if start is None else start[self._unknowns].ravel()
        # Preconditioned from the left: y itself is what is iterated on, and a first guess of it can be used.
        operator = self._operator if self._near is None else lambda y: self._precondition(self._operator(y))
        limit = self._iterations_worth_it
        found = gmres(operator, self._precondition(right), first, self._tolerance, limit)
        self.iterations += found.iterations
        return self._spread(found.value) if found.converged else self._direct(b)

    def solve(self, right: Floats) -> Floats:
        """Each of (n_active, n_coefficients, n) by itself, to within `_MANY`, where all of them take less than a
        factorisation; else directly. A space shared by all (block GMRES) did not pay for its orthogonalisation.
        """
        if self._near is not None or "_direct" in self.__dict__:
            return self._direct.solve(right)
        found, left = np.empty_like(right), self._iterations_for_many
        for j in range(right.shape[2]):
            limit = left // (right.shape[2] - j)
            one = gmres(self._operator, right[:, :, j].ravel(), None, _MANY, limit)
            if not one.converged:
                return self._direct.solve(right)
            found[:, :, j], left = one.value.reshape(right.shape[:2]), left - one.iterations
        return found

    @property
    def factors(self) -> DirectForces | None:
        """The newest there are."""
        return self.__dict__.get("_direct", self._near)

    @property
    def determinant_sign(self) -> float:
        """That of `DirectForces`, which has to be made for it: costly."""
        return self._direct.determinant_sign

    @cached_property
    def _direct(self) -> DirectForces:
        return DirectForces(self._receptance, self._departure, self._rows)

    @property
    def _iterations_worth_it(self) -> int:
        """n / 8 of them cost about as much as a factorisation: 2/3 n^3 operations at the full speed of the processor,
        against 2 n^2 for a solution with the factors and as many for the operator, at the speed of its memory.
        """
        return max(len(self._unknowns) * self._receptance.system.harmonics.n_coefficients // 8, 20)

    @property
    def _iterations_for_many(self) -> int:
        """All that take as long as a factorisation: 2/3 n^3 operations at the full speed of the processor, against
        2 n^2 / c for the operator without factors, c coefficients, and as many for the orthogonalisation, at a third of
        it. Measured: c n / 18 of 2,058 unknowns take 0.17 s, a factorisation 0.24.
        """
        c = self._receptance.system.harmonics.n_coefficients
        return max(len(self._unknowns) * c**2 // 18, 1)

    def _precondition(self, right: Floats) -> Floats:
        if self._near is None:
            return right
        y = right.copy()
        y[self._known] = self._near.solve_roughly(right[self._known])
        return y

    def _spread(self, active: Floats) -> Floats:
        system = self._receptance.system
        forces = np.zeros((system.free.n_relative, system.harmonics.n_coefficients))
        forces[self._unknowns] = active.reshape(len(self._unknowns), -1)
        return forces


class ModalForces:
    """Without residual flexibility G = phi D^-1 phi^T, and y = b - T phi (D + phi^T T phi)^-1 phi^T b."""

    def __init__(self, receptance: Receptance, departure: Departure, rows: Integers) -> None:
        self._receptance, self._departure, self._rows = receptance, departure, rows
        self._factors = scipy.linalg.lu_factor(self._matrix(), overwrite_a=True, check_finite=False)

    def __call__(self, b: Floats, start: Floats | None = None) -> Floats:  # noqa: ARG002  a direct solver needs none
        y = np.zeros_like(b)
        y[self._rows] = self.solve(b[self._rows, :, None])[..., 0]
        return y

    def solve(self, right: Floats) -> Floats:
        """On the active rows, (n_active, n_coefficients, n) -> same"""
        phi, (n_active, c, n) = self._phi, right.shape
        loads = (phi[self._rows].T @ right.reshape(n_active, c * n)).reshape(-1, n)
        modal = scipy.linalg.lu_solve(self._factors, loads, overwrite_b=True, check_finite=False)
        motion = (phi @ modal.reshape(-1, c * n)).reshape(-1, c, n)
        return right - apply_tangent(self._receptance.system, self._departure, motion)[self._rows]

    @property
    def factors(self) -> None:
        """Its matrix is another one, and small."""

    @property
    def determinant_sign(self) -> float:
        """det J = det(D + phi^T T phi) / det D, and det D > 0: of each harmonic's real form it is |det D_k|^2, and the
        static stiffness of modes is positive.
        """
        return _determinant_sign(self._factors)

    @property
    def _phi(self) -> Floats:
        stuck = self._receptance.system.stuck
        return stuck.phi[: stuck.n_relative]

    def _matrix(self) -> Floats:
        system, phi = self._receptance.system, self._phi
        m, c = phi.shape[1], system.harmonics.n_coefficients
        matrix = np.zeros((m, c, m, c))
        for group, tangent in zip(system.groups, self._departure.tangents, strict=True):
            chosen = np.flatnonzero(tangent.any(axis=(1, 2, 3, 4)))
            local = phi[group.rows[chosen]]  # (n, d, m)
            n, d = local.shape[:2]
            # T[n, d, a, e, b] contracted over e, then over n and d: (m, a, b, m)
            half = tangent[chosen].transpose(0, 1, 2, 4, 3).reshape(n, d * c * c, d) @ local
            whole = local.reshape(n * d, m).T @ half.reshape(n * d, c * c * m)
            matrix += whole.reshape(m, c, c, m).transpose(0, 1, 3, 2)
        for k, part in system.harmonics.slices.items():
            stiffness = system.stuck.modal_dynamic_stiffness(k * self._receptance.w)
            matrix[:, part, :, part] += real_form(stiffness, k)
        return matrix.reshape(m * c, m * c)


def _of_rows(all_rows: Integers, rows: Integers, receptance: Receptance) -> Integers | slice:
    """Where the unknowns of `rows` stand among those of all rows, row by row."""
    if len(rows) == len(all_rows):
        return slice(None)
    c = receptance.system.harmonics.n_coefficients
    return (c * np.searchsorted(all_rows, rows)[:, None] + np.arange(c)).ravel()


def _determinant_sign(factors: tuple[Floats, NDArray[np.signedinteger[Any]]]) -> float:
    lu, pivots = factors
    swaps = np.count_nonzero(pivots != np.arange(len(pivots)))
    return float(np.prod(np.sign(np.diagonal(lu))) * (-1) ** swaps)


def _places(receptance: Receptance, n_active: int) -> Integers:
    """(n_active, n_coefficients) where the unknowns stand: by harmonic, then row, then cosine and sine."""
    slices = receptance.system.harmonics.slices.values()
    parts = [n_active * p.start + np.arange(n_active * (p.stop - p.start)).reshape(n_active, -1) for p in slices]
    return np.concatenate(parts, axis=1)


def _active_matrix(receptance: Receptance, departure: Departure, rows: Integers, places: Integers) -> Floats:
    """I + T_S: G_:S, ordered as `places` says."""
    system, n_active = receptance.system, len(rows)
    matrix = np.empty((places.size, places.size))
    number = np.full(system.free.n_relative, -1)
    number[rows] = np.arange(n_active)
    for group, tangent in zip(system.groups, departure.tangents, strict=True):
        wanted = number[group.rows] >= 0
        chosen = np.flatnonzero(wanted.any(axis=1))
        if not len(chosen):
            continue
        chosen_rows, wanted = group.rows[chosen], wanted[chosen]
        targets = places[number[chosen_rows[wanted]]]
        for k, part in system.harmonics.slices.items():
            G = receptance.block(k, chosen_rows.ravel(), rows).reshape(*chosen_rows.shape, n_active)
            product = _times(tangent[chosen][..., part], G, k)[wanted]
            matrix[targets, n_active * part.start : n_active * part.stop] = product
    matrix[np.diag_indices_from(matrix)] += 1
    return matrix


def _times(tangent: Floats, G: NDArray[np.complex128], k: int) -> Floats:
    """T G_k: tangent (n, d, n_coefficients, d, width), G (n, d, n_columns) -> (n, d, n_coefficients, n_columns width).

    width: of k, 1 or 2. With T_cos + i T_sin one complex product gives cosine and sine, as tangent.real_form has them.
    """
    n, d, c = tangent.shape[:3]
    if k == 0:
        return np.asarray(tangent[..., 0].reshape(n, d * c, d) @ G.real).reshape(n, d, c, -1)
    product = (tangent[..., 0] + 1j * tangent[..., 1]).reshape(n, d * c, d) @ G
    return product.view(np.float64).reshape(n, d, c, -1)
