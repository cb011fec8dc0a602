"""The linear equations of unilateral contact for one active set, and which of its contacts break their conditions."""

import warnings
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.linalg import LinAlgError, LinAlgWarning, lu_factor, lu_solve

from updamp.fem.static_contact.contact_problem import ContactProblem, StaticContactState

Floats = NDArray[np.float64]
Integers = NDArray[np.int64]
Bools = NDArray[np.bool_]


@dataclass(frozen=True, eq=False)
class ActiveSet:
    """closed: (n,); slip: (n, 2) sense of slip of both directions, 0 where stuck or without friction."""

    closed: Bools
    slip: Integers


@dataclass(frozen=True, eq=False)
class FrictionLimit:
    """Largest tangential force slope * N + constant, each (n,): Coulomb's law is (mu, 0), Tresca's (0, limit)."""

    slope: Floats
    constant: Floats

    def of(self, normal: Floats) -> Floats:
        return self.slope * np.maximum(normal, 0.0) + self.constant

    def grips(self, closed: Bools) -> Bools:
        """(n,) contacts that take tangential force; Tresca's law knows nothing of opening."""
        return (closed & (self.slope > 0)) | (self.constant > 0)


class ContactEquations:
    """The linear equations of one load step for any active set, and the conditions their solution must keep."""

    def __init__(
        self, problem: ContactProblem, load: Floats, free: Floats, anchor: Floats, limit: FrictionLimit
    ) -> None:
        self.problem, self.free, self.anchor, self.limit = problem, free, anchor, limit
        # Bodies' modes may be mass-normalised: scaled to unit largest entry, so that one rank tolerance fits all.
        scale = np.abs(problem.rigid_modes).max(axis=0, initial=0.0)
        self.mode_scale = np.where(scale > 0, scale, 1.0)
        self.rigid = problem.rigid_modes / self.mode_scale
        self.load = load / self.mode_scale
        self.unit_flexibility = float(np.mean(np.diag(problem.flexibility)))
        if not self.unit_flexibility > 0:
            raise ValueError("flexibility has no positive diagonal: it must be positive definite")
        self.target = np.column_stack([anchor, problem.gap]).ravel()

    def solve(self, active: ActiveSet) -> StaticContactState:
        """Forces, displacements and rigid amplitudes of this set. raises: LinAlgError if it is singular."""
        rows, spread, fixed = self._unknowns(active)
        held, loose = self._rigid_motions(rows)
        R = self.rigid @ held
        k, m = len(rows), held.shape[1]
        A = np.zeros((k + m, k + m))
        A[:k, :k] = -(self.problem.flexibility[rows] @ spread) / self.unit_flexibility
        A[:k, k:] = R[rows]
        A[k:, :k] = R.T @ spread
        known = self.target - self.free + self.problem.flexibility @ fixed
        right = np.concatenate([known[rows] / self.unit_flexibility, held.T @ self.load - R.T @ fixed])
        solved = _solve_refined(A, right)
        force = spread @ solved[:k] + fixed
        amplitudes = held @ solved[k:] * self.unit_flexibility + self._push(loose, force)
        displacement = self.free - self.problem.flexibility @ force + self.rigid @ amplitudes
        d = displacement.reshape(-1, 3)
        opening = np.where(active.closed, 0.0, self.problem.gap - d[:, 2])
        rigid = amplitudes / self.mode_scale
        return StaticContactState(force.reshape(-1, 3), d, opening, rigid, active.closed, active.slip)

    def _unknowns(self, active: ActiveSet) -> tuple[Integers, Floats, Floats]:
        """Rows that are equations, the map (3 n, k) from their unknowns to all forces, and the forces known."""
        n = len(active.closed)
        grips = self.limit.grips(active.closed)
        unknown = np.column_stack([(active.slip == 0) & grips[:, None], active.closed])
        rows = np.flatnonzero(unknown)
        spread = np.zeros((3 * n, len(rows)))
        spread[rows, np.arange(len(rows))] = 1.0
        is_normal = np.flatnonzero(rows % 3 == 2)
        contact = rows[is_normal] // 3
        fixed = np.zeros((n, 3))
        for direction in range(2):
            sense = active.slip[:, direction]
            spread[3 * contact + direction, is_normal] += (sense * self.limit.slope)[contact]
            fixed[:, direction] = sense * self.limit.constant
        return rows, spread, fixed.ravel()

    def _rigid_motions(self, rows: Integers) -> tuple[Floats, Floats]:
        """(m, r) and (m, m - r): orthonormal rigid motions that the equations resist, and the others."""
        _, values, directions = np.linalg.svd(np.linalg.qr(self.rigid[rows], mode="r"))
        rank = int(np.sum(values > 1e-9 * max(1.0, float(values.max(initial=0.0)))))
        return directions[:rank].T, directions[rank:].T

    def _push(self, loose: Floats, force: Floats) -> Floats:
        """(m,) motion along what is unbalanced and nothing resists, far enough to find the contact that does."""
        unbalanced = loose @ (loose.T @ (self.load - self.rigid.T @ force))
        largest = float(np.abs(self.load).max(initial=0.0))
        size = float(np.abs(unbalanced).max(initial=0.0))
        if size <= 1e-9 * largest:
            return np.zeros(len(self.load))
        lengths = (self.problem.gap, self.free, self.anchor, self.problem.flexibility @ force)
        far = sum(float(np.abs(length).max(initial=0.0)) for length in lengths) + self.unit_flexibility * largest
        return 10.0 * far / size * unbalanced

    def wanted(self, state: StaticContactState, active: ActiveSet, tolerance: float) -> tuple[ActiveSet, Bools]:
        """The set that the state asks for, and the entries (n, 3) in which it differs: the violations."""
        n_scale, d_scale = self._scales(state)
        normal, tangential = state.force[:, 2], state.force[:, :2]
        stays = active.closed & (normal >= -tolerance * n_scale)
        closes = ~active.closed & (state.opening < -tolerance * d_scale)
        closed = stays | closes
        limit = self.limit.of(normal)[:, None]
        stuck = active.slip == 0
        increment = state.displacement[:, :2] - self.anchor
        # A contact that is opening says nothing about its slip, and one that closes starts stuck.
        grips = self.limit.grips(stays)[:, None]
        starts = stuck & (np.abs(tangential) > limit + tolerance * n_scale)
        keeps = ~stuck & (active.slip * increment >= -tolerance * d_scale)
        slip = np.where(starts, np.sign(tangential).astype(np.int64), np.where(keeps, active.slip, 0))
        slip = np.where(grips, slip, 0)
        violated = np.column_stack([(slip != active.slip) & grips, closed != active.closed])
        return ActiveSet(closed, slip), violated

    def change(self, active: ActiveSet, wanted: ActiveSet, entries: Bools) -> ActiveSet:
        """The active set with the entries (n, 3) (t1, t2, n) taken over from the wanted one."""
        closed = np.where(entries[:, 2], wanted.closed, active.closed)
        slip = np.where(entries[:, :2], wanted.slip, active.slip)
        return ActiveSet(closed, np.where(self.limit.grips(closed)[:, None], slip, 0))

    def imbalance(self, state: StaticContactState) -> float:
        """Largest unbalanced rigid-body load, relative to the largest load or, without load, force."""
        if len(self.load) == 0:
            return 0.0
        scale = max(float(np.abs(self.load).max()), float(np.abs(state.force).max()))
        error = np.abs(self.rigid.T @ state.force.ravel() - self.load).max()
        return float(error) / scale if scale > 0 else 0.0

    def violation(self, state: StaticContactState, active: ActiveSet) -> float:
        """Largest violation of any condition, relative."""
        n_scale, d_scale = self._scales(state)
        increment = state.displacement[:, :2] - self.anchor
        limit = self.limit.of(state.force[:, 2])[:, None]
        normal_error = np.where(active.closed, state.displacement[:, 2] - self.problem.gap, 0.0)
        found = [
            self.imbalance(state),
            np.max(-state.force[:, 2], initial=0.0) / n_scale,
            np.max(-state.opening, initial=0.0) / d_scale,
            np.max(np.abs(normal_error), initial=0.0) / d_scale,
            np.max(np.abs(state.force[:, :2]) - limit, initial=0.0) / n_scale,
            np.max(-active.slip * increment, initial=0.0) / d_scale,
        ]
        return float(max(found))

    def _scales(self, state: StaticContactState) -> tuple[float, float]:
        """Units of force [N] and of displacement [m]."""
        force = float(np.abs(state.force).max(initial=0.0))
        elastic = float(np.abs(self.problem.flexibility @ state.force.ravel()).max(initial=0.0))
        others = (self.problem.gap, self.free, state.displacement)
        size = max(elastic, *(float(np.abs(lengths).max(initial=0.0)) for lengths in others))
        return (force or 1.0), (size or 1.0)


def _solve_refined(A: Floats, right: Floats) -> Floats:
    """LU with one step of iterative refinement, so that the residual is round-off."""
    with warnings.catch_warnings():
        warnings.simplefilter("error", LinAlgWarning)
        try:
            factors = lu_factor(A)
        except LinAlgWarning as warning:
            raise LinAlgError(str(warning)) from warning
    solved = lu_solve(factors, right)
    solved = solved + lu_solve(factors, right - A @ solved)
    if not np.all(np.isfinite(solved)):
        raise LinAlgError("the equations of the closed contacts are singular")
    return solved
