"""Unilateral contact with Coulomb friction between elastic bodies given by their flexibility: the core solver.

It knows nothing of rigs or finite elements: any body enters by its flexibility at the contacts and its rigid-body
modes. With the relative displacement d (closing positive), the contact forces f and the rigid-body amplitudes q,

    d = d_free - C f + R q,     R^T f = load,
    normal:      N >= 0,  gap - d_n >= 0,  N (gap - d_n) = 0,
    tangential:  |T_i| <= mu N for each of the two directions; T_i = +-mu N while d_i increases or decreases.

The friction cone is a box, as in the contact law of Pesaresi et al. 2017. Friction depends on the path, so loads are
a sequence; each step is implicit (backward Euler) in the tangential displacement.
"""

import warnings
from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.linalg import LinAlgError, LinAlgWarning, lu_factor, lu_solve
from updamp.fem.contact_problem import ContactOptions, ContactProblem, ContactSolution, ContactState, ContactStatus

Floats = NDArray[np.float64]
Integers = NDArray[np.int64]
Bools = NDArray[np.bool_]


@dataclass(frozen=True, eq=False)
class _ActiveSet:
    """Which contacts are closed, and the sense of slip of each of their two directions."""

    closed: Bools
    slip: Integers

    def changed_at(self, wanted: "_ActiveSet", entries: Bools) -> "_ActiveSet":
        """This set with the entries (n, 3) (t1, t2, n) taken over from the wanted one."""
        closed = np.where(entries[:, 2], wanted.closed, self.closed)
        slip = np.where(entries[:, :2], wanted.slip, self.slip)
        return _ActiveSet(closed, np.where(closed[:, None], slip, 0))


def solve_unilateral_contact(
    problem: ContactProblem,
    loads: Floats,
    free_displacements: Floats | None = None,
    options: ContactOptions = ContactOptions(),
    progress: Callable[[int, int], None] | None = None,
) -> ContactSolution:
    """States along a load path, by block principal pivoting (an active-set, or semismooth Newton, method).

    In each iteration the linear equations of the present set of closed, stuck and slipping contacts are solved
    exactly and every contact that breaks its condition changes its state; when that stops lowering the number of
    violations, only one contact changes at a time, which ends the cycles (Judice and Pires 1994; proved to end
    without friction, an observation with it). The state returned solves the linear equations of its final set, so
    complementarity holds to round-off. Rigid-body motions that no closed contact resists, such as sliding without
    friction, are left at zero amplitude (minimum norm); a load along them is `NO_EQUILIBRIUM`.

    loads: (k, m) generalised forces on the rigid-body modes, one row a step, from the unloaded state
    free_displacements: (k, 3 n) [m] relative displacement by the loads alone, without contact; None for zero
    raises: ValueError for shapes that do not fit. Anything else is reported by the status, with the states of the
        steps before the failure.
    """
    loads = np.atleast_2d(np.asarray(loads, dtype=float))
    n, modes = len(problem.gap), problem.rigid_modes.shape[1]
    free = np.zeros((len(loads), 3 * n)) if free_displacements is None else np.atleast_2d(free_displacements)
    if loads.shape[1] != modes or free.shape != (len(loads), 3 * n):
        raise ValueError(
            f"loads {loads.shape} and free_displacements {free.shape} must be (k, {modes}) and (k, {3 * n})"
        )
    active = _ActiveSet(np.ones(n, dtype=bool), np.zeros((n, 2), dtype=np.int64))
    anchor = np.zeros((n, 2))
    states: list[ContactState] = []
    iterations: list[int] = []
    residuals: list[float] = []
    status = ContactStatus.CONVERGED
    for step, (load, displacement) in enumerate(zip(loads, free, strict=True)):
        equations = _Equations(problem, load, displacement, anchor)
        active, state, status, count = _pivot(equations, active, options)
        iterations.append(count)
        residuals.append(equations.violation(state, active))
        if status is not ContactStatus.CONVERGED:
            break
        states.append(state)
        anchor = state.displacement[:, :2]
        if progress is not None:
            progress(step + 1, len(loads))
    return ContactSolution(tuple(states), status, np.asarray(iterations), np.asarray(residuals))


class _Equations:
    """The linear equations of one load step for any active set, and the conditions their solution must keep."""

    def __init__(self, problem: ContactProblem, load: Floats, free: Floats, anchor: Floats) -> None:
        self.problem, self.free, self.anchor = problem, free, anchor
        # Bodies' modes may be mass-normalised: scaled to unit largest entry, so that one rank tolerance fits all.
        scale = np.abs(problem.rigid_modes).max(axis=0, initial=0.0)
        self.mode_scale = np.where(scale > 0, scale, 1.0)
        self.rigid = problem.rigid_modes / self.mode_scale
        self.load = load / self.mode_scale
        self.unit_flexibility = float(np.mean(np.diag(problem.flexibility)))
        if not self.unit_flexibility > 0:
            raise ValueError("flexibility has no positive diagonal: it must be positive definite")
        self.target = np.column_stack([anchor, problem.gap]).ravel()

    def solve(self, active: _ActiveSet) -> ContactState:
        """Forces, displacements and rigid amplitudes of this set. raises: LinAlgError if it is singular."""
        rows, spread = self._unknowns(active)
        held, loose = self._rigid_motions(rows)
        R = self.rigid @ held
        k, m = len(rows), held.shape[1]
        A = np.zeros((k + m, k + m))
        A[:k, :k] = -(self.problem.flexibility[rows] @ spread) / self.unit_flexibility
        A[:k, k:] = R[rows]
        A[k:, :k] = R.T @ spread
        right = np.concatenate([(self.target - self.free)[rows] / self.unit_flexibility, held.T @ self.load])
        solved = _solve_refined(A, right)
        force = spread @ solved[:k]
        amplitudes = held @ solved[k:] * self.unit_flexibility + self._push(loose)
        displacement = self.free - self.problem.flexibility @ force + self.rigid @ amplitudes
        d = displacement.reshape(-1, 3)
        opening = np.where(active.closed, 0.0, self.problem.gap - d[:, 2])
        rigid = amplitudes / self.mode_scale
        return ContactState(force.reshape(-1, 3), d, opening, rigid, active.closed, active.slip)

    def _unknowns(self, active: _ActiveSet) -> tuple[Integers, Floats]:
        """Rows that are equations, and the map (3 n, k) from their unknowns to all forces (T = s mu N in slip)."""
        n = len(active.closed)
        unknown = np.zeros((n, 3), dtype=bool)
        unknown[:, 2] = active.closed
        unknown[:, :2] = active.closed[:, None] & (active.slip == 0) & (self.problem.friction > 0)[:, None]
        rows = np.flatnonzero(unknown)
        spread = np.zeros((3 * n, len(rows)))
        spread[rows, np.arange(len(rows))] = 1.0
        is_normal = np.flatnonzero(rows % 3 == 2)
        contact = rows[is_normal] // 3
        for direction in range(2):
            spread[3 * contact + direction, is_normal] += (active.slip[:, direction] * self.problem.friction)[contact]
        return rows, spread

    def _rigid_motions(self, rows: Integers) -> tuple[Floats, Floats]:
        """(m, r) and (m, m - r): orthonormal rigid motions that the equations resist, and the others."""
        _, values, directions = np.linalg.svd(np.linalg.qr(self.rigid[rows], mode="r"))
        rank = int(np.sum(values > 1e-9 * max(1.0, float(values.max(initial=0.0)))))
        return directions[:rank].T, directions[rank:].T

    def _push(self, loose: Floats) -> Floats:
        """(m,) motion along a load that no closed contact resists, far enough to find the contact that does."""
        unbalanced = loose @ (loose.T @ self.load)
        largest = float(np.abs(self.load).max(initial=0.0))
        if np.abs(unbalanced).max(initial=0.0) <= 1e-9 * largest:
            return np.zeros(len(self.load))
        lengths = np.abs(self.problem.gap).max(initial=0.0) + np.abs(self.free).max(initial=0.0)
        return 10.0 * (lengths / largest + self.unit_flexibility) * unbalanced

    def wanted(self, state: ContactState, active: _ActiveSet, tolerance: float) -> tuple[_ActiveSet, Bools]:
        """The set that the state asks for, and the entries (n, 3) in which it differs: the violations."""
        n_scale, d_scale = self._scales(state)
        normal, tangential = state.force[:, 2], state.force[:, :2]
        stays = active.closed & (normal >= -tolerance * n_scale)
        closes = ~active.closed & (state.opening < -tolerance * d_scale)
        closed = stays | closes
        limit = (self.problem.friction * np.maximum(normal, 0.0))[:, None]
        stuck = active.slip == 0
        increment = state.displacement[:, :2] - self.anchor
        has_friction = (self.problem.friction > 0)[:, None]
        starts = stuck & has_friction & (np.abs(tangential) > limit + tolerance * n_scale)
        keeps = ~stuck & (active.slip * increment >= -tolerance * d_scale)
        slip = np.where(starts, np.sign(tangential).astype(np.int64), np.where(keeps, active.slip, 0))
        # A contact that is opening says nothing about its slip, and one that closes starts stuck.
        slip = np.where(stays[:, None], slip, 0)
        violated = np.column_stack([(slip != active.slip) & stays[:, None], closed != active.closed])
        return _ActiveSet(closed, slip), violated

    def imbalance(self, state: ContactState) -> float:
        """Largest unbalanced rigid-body load, relative to the largest load or, without load, force."""
        if len(self.load) == 0:
            return 0.0
        scale = max(float(np.abs(self.load).max()), float(np.abs(state.force).max()))
        error = np.abs(self.rigid.T @ state.force.ravel() - self.load).max()
        return float(error) / scale if scale > 0 else 0.0

    def violation(self, state: ContactState, active: _ActiveSet) -> float:
        """Largest violation of any condition, relative."""
        n_scale, d_scale = self._scales(state)
        increment = state.displacement[:, :2] - self.anchor
        limit = (self.problem.friction * np.maximum(state.force[:, 2], 0.0))[:, None]
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

    def _scales(self, state: ContactState) -> tuple[float, float]:
        """Units of force [N] and of displacement [m]."""
        force = float(np.abs(state.force).max(initial=0.0))
        elastic = float(np.abs(self.problem.flexibility @ state.force.ravel()).max(initial=0.0))
        size = max(elastic, float(np.abs(self.problem.gap).max(initial=0.0)), float(np.abs(self.free).max(initial=0.0)))
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


def _pivot(
    equations: _Equations, active: _ActiveSet, options: ContactOptions
) -> tuple[_ActiveSet, ContactState, ContactStatus, int]:
    """Block principal pivoting with single pivots (last violated entry) as the way out of cycles."""
    fewest, trials = np.inf, options.block_trials
    state = None
    for count in range(1, options.max_iterations + 1):
        try:
            state = equations.solve(active)
        except LinAlgError:
            return active, state or _empty(active), ContactStatus.SINGULAR, count
        wanted, violated = equations.wanted(state, active, options.tolerance)
        number = int(violated.sum())
        if number == 0:
            balanced = equations.imbalance(state) <= max(options.tolerance, 1e-10)
            return active, state, ContactStatus.CONVERGED if balanced else ContactStatus.NO_EQUILIBRIUM, count
        if number < fewest:
            fewest, trials = number, options.block_trials
        elif trials > 0:
            trials -= 1
        else:
            violated = _last_only(violated)
        active = active.changed_at(wanted, violated)
    assert state is not None
    return active, state, ContactStatus.CYCLING, count


def _last_only(violated: Bools) -> Bools:
    flat = np.zeros(violated.size, dtype=bool)
    flat[np.flatnonzero(violated)[-1]] = True
    return flat.reshape(violated.shape)


def _empty(active: _ActiveSet) -> ContactState:
    n = len(active.closed)
    zero = np.zeros((n, 3))
    return ContactState(zero, zero, np.zeros(n), np.zeros(0), active.closed, active.slip)
