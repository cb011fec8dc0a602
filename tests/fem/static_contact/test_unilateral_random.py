"""Random elastic bodies on rough planes: whatever friction can hold is solved, and nothing else."""

import numpy as np
import pytest
from scipy.optimize import linprog

from updamp.fem.static_contact.contact_problem import ContactOptions, ContactProblem, ContactStatus
from updamp.fem.static_contact.unilateral_contact import solve_unilateral_contact


def random_body(rng: np.random.Generator) -> tuple[ContactProblem, np.ndarray]:
    """Contacts strewn over a square, 1/r-like flexibility plus a random coupling of all directions, six motions."""
    n = int(rng.integers(4, 40))
    at = rng.uniform(-1, 1, (n, 2))
    distance = np.linalg.norm(at[:, None] - at[None], axis=-1)
    mixing = rng.standard_normal((3 * n, 3 * n + 5))
    C = np.kron(1 / np.sqrt(distance**2 + 0.01), np.eye(3)) + rng.uniform(0, 0.3) * mixing @ mixing.T / n
    R = np.zeros((3 * n, 6))
    for direction in range(3):
        R[direction::3, direction] = 1
    R[2::3, 3:5] = at
    R[0::3, 5], R[1::3, 5] = -at[:, 1], at[:, 0]
    gap = rng.choice([0, 1]) * rng.uniform(0, 1) * np.sum(at**2, axis=1)
    load = np.concatenate([rng.uniform(-0.15, 0.15, 2), [1], rng.uniform(-0.2, 0.2, 2), [0]])
    return ContactProblem(C, R, gap, np.full(n, rng.choice([0.2, 0.6, 1.0, 1.5]))), load


def can_be_carried(problem: ContactProblem, load: np.ndarray) -> bool:
    """Is there any set of forces inside the cones in equilibrium with the load? By linear programming."""
    n = len(problem.gap)
    cone = np.zeros((4 * n, 3 * n))
    for side, (direction, sense) in enumerate([(0, 1), (0, -1), (1, 1), (1, -1)]):
        rows = np.arange(side * n, (side + 1) * n)
        cone[rows, direction + 3 * np.arange(n)] = sense
        cone[rows, 2 + 3 * np.arange(n)] = -problem.friction
    bounds = [(None, None), (None, None), (0, None)] * n
    carried = linprog(np.zeros(3 * n), cone, np.zeros(4 * n), problem.rigid_modes.T, load, bounds)
    return carried.status == 0


@pytest.mark.parametrize("seed", range(8))
def test_random_bodies_are_solved_if_the_contacts_can_carry_the_load(seed: int) -> None:
    rng = np.random.default_rng(seed)
    solved = 0
    for _ in range(10):
        problem, load = random_body(rng)
        loads = np.linspace(0.1, 1, 10)[:, None] * load
        solution = solve_unilateral_contact(problem, loads, options=ContactOptions(max_iterations=300))
        assert (solution.status is ContactStatus.CONVERGED) == can_be_carried(problem, load)
        if solution.status is not ContactStatus.CONVERGED:
            continue
        solved += 1
        assert solution.residuals.max() < 1e-11
        for state in solution.value:
            limit = problem.friction * state.force[:, 2]
            assert np.all(np.abs(state.force[:, :2]) <= limit[:, None] + 1e-11)
            slipping = state.slip != 0
            expected = (state.slip * limit[:, None])[slipping]
            assert state.force[:, :2][slipping] == pytest.approx(expected, abs=1e-12)
    assert solved >= 6
