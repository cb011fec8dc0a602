"""Unilateral contact with Coulomb friction between elastic bodies given by their flexibility: the core solver.

It knows nothing of rigs or finite elements: any body enters by its flexibility at the contacts and its rigid-body
modes. With the relative displacement d (closing positive), the contact forces f and the rigid-body amplitudes q,

    d = d_free - C f + R q,     R^T f = load,
    normal:      N >= 0,  gap - d_n >= 0,  N (gap - d_n) = 0,
    tangential:  |T_i| <= mu N for each of the two directions; T_i = +-mu N while d_i increases or decreases.

The friction cone is a box, as in the contact law of Pesaresi et al. 2017. Friction depends on the path, so loads are
a sequence; each step is implicit (backward Euler) in the tangential displacement.
"""

from collections.abc import Callable
from functools import partial

import numpy as np
from numpy.typing import NDArray
from scipy.linalg import LinAlgError

from updamp.fem.static_contact.contact_equations import ActiveSet, ContactEquations, FrictionLimit
from updamp.fem.static_contact.contact_problem import (
    ContactOptions,
    ContactProblem,
    ContactSolution,
    ContactStatus,
    StaticContactState,
)

Floats = NDArray[np.float64]
Bools = NDArray[np.bool_]

DEFAULT_OPTIONS = ContactOptions()
SETTLED = 1e-6  # relative change of the friction limits after which a load they cannot hold is called so


def solve_unilateral_contact(
    problem: ContactProblem,
    loads: Floats,
    free_displacements: Floats | None = None,
    options: ContactOptions = DEFAULT_OPTIONS,
) -> ContactSolution:
    """States along a load path, by block principal pivoting (an active-set, or semismooth Newton, method).

    In each iteration the linear equations of the present set of closed, stuck and slipping contacts are solved
    exactly and every contact that breaks its condition changes its state; when that stops lowering the number of
    violations, only one contact changes at a time, which ends the cycles (Judice and Pires 1994). That is proved
    to end for symmetric problems: no friction, or friction with given limits. Where Coulomb friction cycles, its
    limits mu N are found by iteration over problems with given limits (Panagiotopoulos 1975), until the active set
    is Coulomb's. The state returned solves Coulomb's linear equations of its final set, so complementarity holds to
    round-off. Rigid-body motions that no closed contact resists, such as sliding without friction, are left at zero
    amplitude (minimum norm); a load along them is `NO_EQUILIBRIUM`.

    loads: (k, m) generalised forces on the rigid-body modes, one row a step, from the unloaded state
    free_displacements: (k, 3 n) [m] relative displacement by the loads alone, without contact; None for zero
    raises: ValueError for shapes that do not fit. Anything else is reported by the status, with the states of the
        steps before the failure.
    """
    loads, free = _steps(problem, loads, free_displacements)
    n = len(problem.gap)
    active = ActiveSet(np.ones(n, dtype=bool), np.zeros((n, 2), dtype=np.int64))
    anchor = np.zeros((n, 2))
    states: list[StaticContactState] = []
    iterations: list[int] = []
    residuals: list[float] = []
    status = ContactStatus.CONVERGED
    for load, displacement in zip(loads, free, strict=True):
        equations = partial(ContactEquations, problem, load, displacement, anchor)
        active, state, status, count = _solve_step(equations, problem.friction, active, options)
        iterations.append(count)
        residuals.append(equations(_coulomb(problem.friction)).violation(state, active))
        if status is not ContactStatus.CONVERGED:
            break
        states.append(state)
        anchor = state.displacement[:, :2]
    return ContactSolution(tuple(states), status, np.asarray(iterations), np.asarray(residuals))


def _steps(problem: ContactProblem, loads: Floats, free_displacements: Floats | None) -> tuple[Floats, Floats]:
    """Loads and displacements, a row a step. raises: ValueError for shapes that do not fit"""
    loads = np.atleast_2d(np.asarray(loads, dtype=float))
    n, modes = len(problem.gap), problem.rigid_modes.shape[1]
    free = np.zeros((len(loads), 3 * n)) if free_displacements is None else np.atleast_2d(free_displacements)
    if loads.shape[1] != modes or free.shape != (len(loads), 3 * n):
        raise ValueError(
            f"loads {loads.shape} and free_displacements {free.shape} must be (k, {modes}) and (k, {3 * n})"
        )
    return loads, free


Equations = Callable[[FrictionLimit], ContactEquations]
Outcome = tuple[ActiveSet, StaticContactState, ContactStatus, int]


def _coulomb(friction: Floats) -> FrictionLimit:
    return FrictionLimit(friction, np.zeros(len(friction)))


def _solve_step(equations: Equations, friction: Floats, active: ActiveSet, options: ContactOptions) -> Outcome:
    """Coulomb's problem directly, and if that cycles by friction limits that follow the normal forces."""
    coulomb = equations(_coulomb(friction))
    symmetric = not np.any(friction > 0)
    outcome = _pivot(coulomb, active, options, options.max_iterations if symmetric else options.direct_iterations)
    if symmetric or outcome[2] is ContactStatus.CONVERGED:
        return outcome
    count, nothing = outcome[3], np.zeros(len(friction))
    limit, given = nothing, ActiveSet(active.closed, np.zeros_like(active.slip))
    unbalanced = False
    for _ in range(options.friction_cycles):
        law = equations(FrictionLimit(nothing, limit))
        given, state, status, more = _pivot(law, given, options, options.max_iterations)
        count += more
        unbalanced = status is ContactStatus.NO_EQUILIBRIUM
        closed = given.closed & (state.force[:, 2] > 0)
        slip = np.where((closed & (friction > 0))[:, None], given.slip, 0)
        found, solved, status, more = _pivot(coulomb, ActiveSet(closed, slip), options, options.direct_iterations)
        count += more
        if status is ContactStatus.CONVERGED:
            return found, solved, status, count
        # Half the step: on a wedge the limits act back on the normal forces with a factor of about -mu tan(alpha).
        change = (friction * np.maximum(state.force[:, 2], 0.0) - limit) / 2
        limit = limit + change
        if unbalanced and np.abs(change).max() <= SETTLED * limit.max():
            break
    status = ContactStatus.NO_EQUILIBRIUM if unbalanced else ContactStatus.CYCLING
    return outcome[0], outcome[1], status, count


def _pivot(equations: ContactEquations, active: ActiveSet, options: ContactOptions, most: int) -> Outcome:
    """Block principal pivoting with single pivots (last violated entry) as the way out of cycles."""
    fewest, trials = np.inf, options.block_trials
    state = None
    for count in range(1, most + 1):
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
        active = equations.change(active, wanted, violated)
    assert state is not None
    return active, state, ContactStatus.CYCLING, count


def _last_only(violated: Bools) -> Bools:
    flat = np.zeros(violated.size, dtype=bool)
    flat[np.flatnonzero(violated)[-1]] = True
    return flat.reshape(violated.shape)


def _empty(active: ActiveSet) -> StaticContactState:
    n = len(active.closed)
    zero = np.zeros((n, 3))
    return StaticContactState(zero, zero, np.zeros(n), np.zeros(0), active.closed, active.slip)
