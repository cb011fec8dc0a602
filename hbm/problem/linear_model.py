"""The linear structure seen from the contacts: modes plus residual flexibility, and springs added to it exactly.

Rows are generalised displacements: first the relative displacements at the contact elements (damper minus
platform, in t1, t2, n), then named points.
"""

import reprlib
import warnings
from dataclasses import dataclass, replace
from functools import cached_property
from typing import Any

import numpy as np
import scipy.linalg
from numpy.typing import NDArray

from updamp.hbm.problem.modal_algebra import ModalInverse, dynamic_stiffness, graded_eigh, modal_inverse

Floats = NDArray[np.float64]
Complex = NDArray[np.complex128]


@dataclass(frozen=True, eq=False)
class LinearModel:
    """y = H(w) f,  H(w) = phi (omega^2 - w^2 + i (hysteretic + w viscous))^-1 phi^T + residual.

    The hysteretic part acts at w > 0 only: the zero harmonic is static.

    omega_squared: (m,) [rad^2/s^2]
    phi: (n_rows, m) mass-normalised [kg^-1/2]
    residual: (n_rows, n_rows) [m/N]
    hysteretic: (m, m) [rad^2/s^2]; viscous: (m, m) [rad/s]
    n_relative: rows that are relative displacements
    points: names of the rows that follow them
    basis: (m, m) these modes in those of the model that springs were added to (add_springs); None where none were
    """

    omega_squared: Floats
    phi: Floats
    residual: Floats
    hysteretic: Floats
    viscous: Floats
    n_relative: int
    points: tuple[str, ...]
    basis: Floats | None = None

    @property
    def n_rows(self) -> int:
        return len(self.phi)

    @property
    def frequencies(self) -> Floats:
        """(m,) [Hz]"""
        return np.sqrt(np.maximum(self.omega_squared, 0.0)) / (2 * np.pi)

    @cached_property
    def has_residual(self) -> bool:
        """Whether there is residual flexibility at all"""
        return bool(self.residual.any())

    @property
    def flexibility_at_rest(self) -> Floats:
        """(n_rows, n_rows) [m/N] of all modes but rigid ones, and of what they leave"""
        elastic = self.omega_squared > 0
        phi = self.phi[:, elastic]
        return phi / self.omega_squared[elastic] @ phi.T + self.residual

    def row(self, point: str) -> int:
        """raises: KeyError naming the points there are"""
        if point not in self.points:
            raise KeyError(f"no point '{point}' in the model; there are {', '.join(self.points)}")
        return self.n_relative + self.points.index(point)

    def modal_dynamic_stiffness(self, w: float) -> Complex:
        """(m, m) at the angular frequency w [rad/s]"""
        if w > 0:
            return dynamic_stiffness(self.omega_squared, self.hysteretic, self.viscous, w)
        return np.diag(self.omega_squared - w**2).astype(np.complex128)

    @cached_property
    def modal_inverse(self) -> ModalInverse:
        """Of `modal_dynamic_stiffness` at w > 0"""
        return modal_inverse(self.omega_squared, self.hysteretic, self.viscous)

    def receptance(
        self, w: float, rows: Floats | slice = slice(None), columns: Floats | slice = slice(None)
    ) -> Complex:
        """H(w) [m/N] between the rows (and columns) chosen"""
        modal = scipy.linalg.solve(self.modal_dynamic_stiffness(w), self.phi[columns].T)
        return self.phi[rows] @ modal + self.residual[rows][:, columns]


def add_springs(model: LinearModel, directions: Floats, stiffness: Floats) -> LinearModel:
    """The model with springs on the displacements directions^T y: exact, whatever the modal truncation.

    u = Phi q + R f with f -> f - V W V^T (Phi q + R f), W = (S^-1 + V^T R V)^-1 (Woodbury).

    directions V: (n_rows, n_springs); stiffness S: (n_springs,) [N/m], or (n_springs, n_springs) symmetric
    """
    S = np.diag(stiffness) if stiffness.ndim == 1 else stiffness
    RV, PV = model.residual @ directions, model.phi.T @ directions
    W = np.linalg.solve(np.eye(len(S)) + S @ (directions.T @ RV), S)
    W = (W + W.T) / 2
    residual = model.residual - RV @ W @ RV.T
    omega_squared, X = graded_eigh(np.diag(model.omega_squared) + PV @ W @ PV.T)
    return replace(
        model,
        omega_squared=omega_squared,
        phi=(model.phi - RV @ W @ PV.T) @ X,
        residual=(residual + residual.T) / 2,
        hysteretic=X.T @ model.hysteretic @ X,
        viscous=X.T @ model.viscous @ X,
        basis=X,
    )


def stuck_on(model: LinearModel, stiffness: Floats) -> LinearModel:
    """The model with every relative displacement on a spring: (n_relative,) [N/m]."""
    return add_springs(model, np.eye(model.n_rows, model.n_relative), stiffness)


def from_matrices(
    M: Floats, C: Floats, K: Floats, relative: Floats, points: dict[str, Floats] | None = None
) -> LinearModel:
    """A model given by its matrices, without residual flexibility.

    M, C, K: (n, n), M and K symmetric; C too where a resonance is to be followed; lists will do
    relative: (n_relative, n) rows that pick the relative displacements; points: name -> (n,) row

    raises: ValueError naming a matrix of another shape, one that is complex or not finite, M or K where it is not
        symmetric, M where it is not positive definite, a point without any motion; TypeError naming what is no array
        of numbers, or points that are no dict. Of a C that feeds a motion there is a warning
    """
    M, C, K = (_as_floats(name, matrix) for name, matrix in (("M", M), ("C", C), ("K", K)))
    n = M.shape[0] if M.ndim else 1
    for name, matrix in (("M", M), ("C", C), ("K", K)):
        _refuse_matrix(name, matrix, (n, n), symmetric=name != "C")
    relative = _as_floats("relative", relative)
    _refuse_matrix("relative", relative, (relative.shape[0] if relative.ndim else 1, n), symmetric=False)
    shapes = _as_shapes(points, n)
    _warn_of_negative_damping(C)
    try:
        omega_squared, X = scipy.linalg.eigh(K, M)
    except np.linalg.LinAlgError:
        raise ValueError(f"M is not positive definite: {_without_mass(np.asarray(M))}") from None
    rows = np.vstack([relative, *shapes.values()])
    return LinearModel(
        omega_squared=omega_squared,
        phi=rows @ X,
        residual=np.zeros((len(rows), len(rows))),
        hysteretic=np.zeros_like(K),
        viscous=X.T @ C @ X,
        n_relative=len(relative),
        points=tuple(shapes),
    )


def _without_mass(M: Floats) -> str:
    """Which motion has no mass, or a negative one: by the diagonal, else the coordinate with the largest share."""
    at = int(np.argmin(np.diag(M)))
    if M[at, at] <= 0:
        return f"M[{at}, {at}] = {M[at, at]:g}; every degree of freedom needs a mass, or is condensed into the others"
    values, vectors = np.linalg.eigh(M)
    at = int(np.argmax(np.abs(vectors[:, 0])))
    return (
        f"a motion with the largest share in degree of freedom {at}, counted from 0, has the mass {values[0]:.3g}; "
        "every motion needs a positive one"
    )


def _as_floats(name: str, given: Any) -> Floats:
    """raises: TypeError where these are no numbers, ValueError where rows differ in length or one is complex"""
    if hasattr(given, "toarray"):
        raise TypeError(f"{name} is sparse; a dense array is needed: give {name}.toarray()")
    try:
        array = np.asarray(given)
    except ValueError:
        raise ValueError(
            f"{name} = {reprlib.repr(given)}: its rows are of different lengths, or no rows of numbers"
        ) from None
    if np.iscomplexobj(array):
        raise ValueError(
            f"{name} is complex; a real one is needed. Structural damping of loss factor eta is given to the model: "
            "replace(model, hysteretic=eta * np.diag(model.omega_squared))"
        )
    if not (np.issubdtype(array.dtype, np.number) or array.dtype == bool):
        raise TypeError(f"{name} = {reprlib.repr(given)}: an array of numbers is needed, or lists of them")
    return array.astype(np.float64)


def _as_shapes(points: Any, n: int) -> dict[str, Floats]:
    """Rows of the points by their names. raises: as `from_matrices`"""
    if points is None or (isinstance(points, list | tuple) and not points):
        return {}
    if not hasattr(points, "items"):
        raise TypeError(
            f"points = {reprlib.repr(points)}: a dict is needed, name -> row of {n} numbers, such as {{'tip': row}}"
        )
    shapes = {name: _as_floats(f"point '{name}'", row) for name, row in points.items()}
    for name, row in shapes.items():
        _refuse_matrix(f"point '{name}'", row, (n,), symmetric=False)
        if not np.any(row):
            raise ValueError(f"point '{name}' is a row of zeros: it sees no motion; give the coordinates' shares")
    return shapes


def _warn_of_negative_damping(C: Floats) -> None:
    """Where C feeds a motion, beyond what round-off leaves (`is_symmetric`). No error: it may be meant so."""
    lowest = float(np.linalg.eigvalsh((C + C.T) / 2)[0])
    if lowest < -np.sqrt(np.finfo(float).eps) * np.abs(C).max():
        at = int(np.argmax(np.abs(np.linalg.eigh((C + C.T) / 2)[1][:, 0])))
        warnings.warn(
            f"C has negative damping, {lowest:.4g}, of a motion with the largest share in degree of freedom {at}, "
            "counted from 0: a branch may then be unstable. Where it is not meant so, look for a wrong sign in C",
            stacklevel=3,
        )


def is_symmetric(matrix: Floats) -> bool:
    """But for round-off"""
    return bool(np.abs(matrix - matrix.T).max() <= np.sqrt(np.finfo(float).eps) * np.abs(matrix).max())


def _refuse_matrix(name: str, matrix: Floats, shape: tuple[int, ...], symmetric: bool) -> None:
    """Of a matrix that is not symmetric half would be taken for the whole; what round-off leaves is less than half of
    the digits."""
    if matrix.shape != shape or not matrix.shape[-1]:
        raise ValueError(f"{name} has shape {matrix.shape}: {shape if all(shape[-1:]) else '(1, 1) or more'} is needed")
    if not np.isfinite(matrix).all():
        raise ValueError(f"{name} has entries that are not finite")
    if symmetric and not is_symmetric(matrix):
        raise ValueError(f"{name} is not symmetric")
