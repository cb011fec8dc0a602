"""Tangents of the elements that may depart from stuck, to a perturbation e^(s t) p(t): block diagonal by element."""

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import Any

import numpy as np
from numpy.typing import NDArray

from updamp.hbm.contact.compiled.at_rest import ELASTIC
from updamp.hbm.harmonics import Harmonics
from updamp.hbm.newton.tangent import NEGLIGIBLE
from updamp.hbm.problem.elements import ElementGroup, compiled_hysteresis, over_period
from updamp.hbm.problem.system import NonlinearSystem
from updamp.hbm.stability.perturbed_forces import perturbed_tangent

Floats = NDArray[np.float64]
Complex = NDArray[np.complex128]
Integers = NDArray[np.int64]


@dataclass(frozen=True, eq=False)
class LooseElements:
    """Elements of a group that may slip or separate in a motion.

    numbers: (n,) in the group; elastic: (n, directions) whose force follows the reference springs all the same;
    displacement: (n_elements, directions, n_coefficients) of the group [m]
    """

    group: ElementGroup
    numbers: Integers
    elastic: NDArray[np.bool_]
    displacement: Floats

    @cached_property
    def rows(self) -> Integers:
        """(n, directions)"""
        return np.asarray(self.group.rows[self.numbers])


def loose_elements(
    system: NonlinearSystem, x: Floats, w: float, harmonics: Harmonics, n_time: int
) -> tuple[LooseElements, ...]:
    """x: (n_relative, n_coefficients) [m] in `harmonics`"""
    found = []
    for group in system.groups:
        numbers = group.may_slip_or_separate(x[group.rows], harmonics, n_time)
        found.append(LooseElements(group, numbers, _elastic(group, x, w, harmonics, n_time)[numbers], x[group.rows]))
    return tuple(found)


def _elastic(group: ElementGroup, x: Floats, w: float, harmonics: Harmonics, n_time: int) -> NDArray[np.bool_]:
    """As `_follow_springs`; none where the law is compiled, which knows it of each of its sliders (`at_rest.py`), nor
    of a law without sliders, whose tangent at rest is what it is."""
    if compiled_hysteresis(group.law, harmonics, n_time) is not None or not hasattr(group.law, "cycles"):
        return np.zeros(group.rows.shape, dtype=bool)
    return _follow_springs(group, x, w, harmonics, n_time)


def _follow_springs(group: ElementGroup, x: Floats, w: float, harmonics: Harmonics, n_time: int) -> NDArray[np.bool_]:
    """(n_elements, directions) whose force follows the reference springs about a mean over the whole period. Not told
    of a direction without motion and force: whether a circle's other direction slips shows when it is pushed alone."""
    motion, force = over_period(group, group.law.force, x[group.rows], w, harmonics, n_time)
    stiffness = group.stiffness_of_one
    beyond = force - stiffness[:, None, :] * motion
    size = stiffness * np.ptp(motion, axis=1) + np.abs(force).max(axis=1)
    elastic: NDArray[np.bool_] = (np.ptp(beyond, axis=1) <= ELASTIC * size) & (size > 0)
    return elastic


@dataclass(frozen=True, eq=False)
class ContactTangent:
    """blocks: for each group of loose elements (n, d, n_coefficients, d, n_coefficients), departure of the tangent from
    the reference springs [N/m]
    """

    loose: Sequence[LooseElements]
    blocks: tuple[Complex, ...]
    n_relative: int

    @staticmethod
    def at(
        loose: Sequence[LooseElements], n_relative: int, w: float, s: complex, harmonics: Harmonics, n_time: int
    ) -> "ContactTangent":
        """For perturbations that grow with s [1/s] about a motion at w [rad/s]."""
        blocks = []
        for some in loose:
            group = some.group
            tangent = perturbed_tangent(group, some.displacement, w, s, harmonics, n_time, some.numbers)
            stiffness = group.stiffness_of_one[some.numbers]
            for d in range(tangent.shape[1]):
                diagonal = np.einsum("ecc->ec", tangent[:, d, :, d, :])
                diagonal -= stiffness[:, d, None]
            size = np.abs(tangent).max(axis=(2, 3, 4), initial=0.0)
            still = some.elastic | (size <= NEGLIGIBLE * np.maximum(stiffness, np.finfo(float).tiny))
            tangent[still] = 0.0
            blocks.append(group.of_all_copies(tangent, some.numbers))
        return ContactTangent(loose, tuple(blocks), n_relative)

    @cached_property
    def rows(self) -> Integers:
        """Ascending relative rows on which a force departs from its reference spring."""
        active = np.zeros(self.n_relative, dtype=bool)
        for some, block in zip(self.loose, self.blocks, strict=True):
            active[some.rows] = (block != 0).any(axis=(2, 3, 4))
        return np.flatnonzero(active)

    def apply(self, motion: Floats | Complex) -> Complex:
        """(n_relative, n_coefficients, p) [m] -> [N]"""
        forces = np.zeros(motion.shape, dtype=np.complex128)
        for some, block in zip(self.loose, self.blocks, strict=True):
            n, d, c = block.shape[:3]
            product = block.reshape(n, d * c, d * c) @ motion[some.rows].reshape(n, d * c, motion.shape[2])
            forces[some.rows] = product.reshape(n, d, c, motion.shape[2])
        return forces

    def mean(self) -> Floats:
        """(n_relative, n_relative) of the force's mean by the motion's mean [N/m]"""
        matrix = np.zeros((self.n_relative, self.n_relative))
        for some, block in zip(self.loose, self.blocks, strict=True):
            matrix[some.rows[:, :, None], some.rows[:, None, :]] = block[:, :, 0, :, 0].real
        return matrix

    def onto(self, flexibility: Floats, kind: type[np.generic]) -> NDArray[Any]:
        """T R on the active rows: (n_active c, n_active c), ordered by row, then coefficient.

        kind: of numbers, such as np.complex64; real ones where T is
        """
        rows, number = self.rows, np.full(self.n_relative, -1)
        number[rows] = np.arange(len(rows))
        c = self.blocks[0].shape[2]
        matrix = np.zeros((len(rows), c, len(rows), c), dtype=kind)
        for some, block in zip(self.loose, self.blocks, strict=True):
            n, d = block.shape[:2]
            wanted = number[some.rows] >= 0
            T = (block if np.issubdtype(kind, np.complexfloating) else block.real).astype(kind)
            R = flexibility[np.ix_(some.rows.ravel(), rows)].reshape(n, d, len(rows)).astype(kind)
            for b in range(c):
                product = (T[..., b].reshape(n, d * c, d) @ R).reshape(n, d, c, len(rows))
                matrix[number[some.rows[wanted]], :, :, b] = product[wanted]
        return matrix.reshape(len(rows) * c, len(rows) * c)
