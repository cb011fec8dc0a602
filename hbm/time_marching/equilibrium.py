"""Where the contacts come to stand at the end of a step: x = x* - A f(x), by Newton's method.

A is the same in all steps, and from one to the next few contacts change between stick, slip and open. So the inverse of
1 + A T is kept for the tangents T of some earlier step, and only elements that differ enter a system to be solved
(Woodbury). It is made anew once these solutions have cost as much as that would ("rent or buy": never more than twice
the work of the best choice; Karlin et al. 1988, Algorithmica 3, 79-119). Friction and unilateral springs are piecewise
linear, so that the iteration ends exactly.
"""

from collections.abc import Sequence
from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray

from updamp.hbm.time_marching.contacts import Contacts
from updamp.hbm.time_marching.laws import LawStep

Floats = NDArray[np.float64]
Integers = NDArray[np.int64]

EXACT = 1e-11  # of the displacement: what a step may be off
ITERATIONS = 60
SHORTEST = 1 / 64  # part of a Newton step


class MarchError(Exception):
    """A step that has no solution that is found; says how far off it is."""


@dataclass(eq=False)
class Equilibrium:
    """compliance A: (n, n) of all rows within a step [m/N]; small: length that counts as nothing [m]

    The inverse that is kept is for speed alone: the residual is that of A.
    """

    contacts: Contacts
    compliance: Floats
    small: float
    tangents: list[Floats] = field(default_factory=list)
    inverse: Floats = field(default_factory=lambda: np.zeros((0, 0)))  # (1 + A T)^-1
    flexibility: Floats = field(default_factory=lambda: np.zeros((0, 0)))  # (1 + A T)^-1 A
    spent: float = 0.0  # on systems to be solved, since the inverse was made [operations]

    def solve(self, x_star: Floats, x: Floats, sliders: Sequence[Floats]) -> tuple[Floats, Floats, tuple[LawStep, ...]]:
        """x, the forces (n,) and what the laws give there. x: to start from

        raises: MarchError
        """
        r, force, steps = self._residual(x_star, x, sliders)
        size = np.abs(r).max()
        for _ in range(ITERATIONS):
            if size <= self.small + EXACT * np.abs(x).max():
                return x, force, steps
            move, part = self._newton_step(r, steps), 1.0
            ahead = self._residual(x_star, x + move, sliders)
            while np.linalg.norm(ahead[0]) > np.linalg.norm(r) and part > SHORTEST:
                part /= 2
                ahead = self._residual(x_star, x + part * move, sliders)
            x, (r, force, steps) = x + part * move, ahead
            size = np.abs(r).max()
        raise MarchError(f"no equilibrium of the contacts within a step, {size:.1e} m left")

    def _residual(
        self, x_star: Floats, x: Floats, sliders: Sequence[Floats]
    ) -> tuple[Floats, Floats, tuple[LawStep, ...]]:
        force, steps = self.contacts.step(x, sliders)
        return x - x_star + self.compliance @ force, force, steps

    def _newton_step(self, r: Floats, steps: Sequence[LawStep]) -> Floats:
        if not self.tangents or self.spent > 4 * len(r) ** 3:
            self._keep(steps)
        move = -self.inverse @ r
        changes = [step.tangent - kept for step, kept in zip(steps, self.tangents, strict=True)]
        active = [np.flatnonzero(change.any(axis=(1, 2))) for change in changes]
        n_active = sum(change.shape[1] * len(some) for change, some in zip(changes, active, strict=True))
        if not n_active:
            return move
        self.spent += 2 * n_active**3 / 3 + 2 * n_active**2 + 8 * len(r) * n_active
        picked = [(self.contacts.rows[g][some], changes[g][some]) for g, some in enumerate(active) if len(some)]
        rows = np.concatenate([one.ravel() for one, _ in picked])
        columns = np.hstack([times_blocks(self.flexibility, *one) for one in picked])
        return move - columns @ np.linalg.solve(np.eye(len(rows)) + columns[rows], move[rows])

    def _keep(self, steps: Sequence[LawStep]) -> None:
        self.tangents, self.spent = [step.tangent for step in steps], 0.0
        system = np.eye(len(self.compliance))
        for rows, tangent in zip(self.contacts.rows, self.tangents, strict=True):
            system[:, rows.ravel()] += times_blocks(self.compliance, rows, tangent)
        self.inverse = np.asarray(np.linalg.inv(system), dtype=np.float64)
        self.flexibility = self.inverse @ self.compliance


def times_blocks(matrix: Floats, rows: Integers, blocks: Floats) -> Floats:
    """(r, n d): columns of `matrix` at rows (n, d), times the block diagonal matrix of blocks (n, d, d)."""
    n, d = rows.shape
    picked = matrix[:, rows.ravel()]
    if d == 1:
        return np.asarray(picked * blocks.ravel())
    return np.asarray((picked.reshape(-1, n, d).transpose(1, 0, 2) @ blocks).transpose(1, 0, 2).reshape(-1, n * d))
