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


class MarchError(RuntimeError):
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
        rows = np.concatenate([of[some].ravel() for of, some in zip(self.contacts.rows, active, strict=True)])
        if not len(rows):
            return move
        picked = [change[some] for change, some in zip(changes, active, strict=True)]
        self.spent += 2 * len(rows) ** 3 / 3 + 2 * len(rows) ** 2 + 2 * len(r) ** 2
        system = times_blocks(self.flexibility[np.ix_(rows, rows)], picked)
        system.flat[:: len(rows) + 1] += 1.0
        there = np.linalg.solve(system, move[rows])
        pull = np.zeros_like(r)
        pull[rows] = times_blocks(there[None], [block.transpose(0, 2, 1) for block in picked])[0]
        return move - self.flexibility @ pull

    def _keep(self, steps: Sequence[LawStep]) -> None:
        self.tangents, self.spent = [step.tangent for step in steps], 0.0
        system = np.eye(len(self.compliance))
        rows = np.concatenate([of.ravel() for of in self.contacts.rows])
        system[:, rows] += times_blocks(self.compliance[:, rows], self.tangents)
        self.inverse = np.asarray(np.linalg.inv(system), dtype=np.float64)
        self.flexibility = self.inverse @ self.compliance


def times_blocks(matrix: Floats, blocks: Sequence[Floats]) -> Floats:
    """(r, c), times a block diagonal matrix: of each group (n, d, d), its n d rows after those of the group before."""
    done, start = np.zeros_like(matrix), 0
    for block in blocks:
        n, d = block.shape[:2]
        for i, j in np.argwhere(block.any(axis=0)):  # few of them are not zero throughout
            done[:, start + j : start + n * d : d] += matrix[:, start + i : start + n * d : d] * block[:, i, j]
        start += n * d
    return done
