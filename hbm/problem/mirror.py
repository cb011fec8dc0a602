"""Half of a problem with a plane of symmetry: what finite element models do with a symmetric structure.

Structure, contacts and excitation that are their own mirror images have a response that is its own image too. Half of
the contacts and the symmetric modes describe it exactly: half the unknowns, an eighth of a factorisation. And the way
to it is easier: no contact changes its state within round-off of its image's, and nowhere does the Jacobian become
singular for motions from side to side that the excitation does not drive. What is left out are responses that break the
symmetry of their own accord; where the symmetric one is unstable, its exponents with the whole model tell
(hbm/stability/stability.py).
"""

from collections.abc import Iterable, Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from typing import Any

import numpy as np
from numpy.typing import NDArray

from updamp.hbm.problem.elements import ElementGroup
from updamp.hbm.problem.linear_model import LinearModel

Floats = NDArray[np.float64]
Integers = NDArray[np.int64]
Booleans = NDArray[np.bool_]

# Mirror images agree to this, relative. Those of finite elements differ by 1e-8 at most, eigenvectors of other modes
# and contacts that were changed by the order of one.
AGREEMENT = 1e-6


@dataclass(frozen=True, eq=False)
class Mirror:
    """What the mirror image of a motion is on the relative rows: displacement r of the image is sign[r] times
    displacement image[r] of the motion.

    image, sign: (n_relative,)
    """

    image: Integers
    sign: Floats

    @cached_property
    def kept(self) -> Integers:
        """Rows of which the others are images, ascending."""
        return np.flatnonzero(self.image >= np.arange(len(self.image)))

    def of(self, motion: Floats) -> Floats:
        """The image of (n_relative, ...)"""
        return self.sign.reshape(-1, *[1] * (motion.ndim - 1)) * motion[self.image]

    def keeps(self, motion: Floats) -> bool:
        """Whether a motion (n_relative, ...) is its own image."""
        return _negligible(self.of(motion) - motion, motion)

    def halved(self, motion: Floats) -> Floats:
        """(..., n_relative, n_coefficients) -> (..., n_kept, n_coefficients)"""
        return motion[..., self.kept, :]

    def whole(self, half: Floats) -> Floats:
        """(..., n_kept, n_coefficients) -> (..., n_relative, n_coefficients)"""
        number = np.empty(len(self.image), dtype=np.int64)
        number[self.kept] = np.arange(len(self.kept))
        source = np.minimum(self.image, np.arange(len(self.image)))
        sign = np.where(source == np.arange(len(self.image)), 1.0, self.sign)
        return sign[:, None] * half[..., number[source], :]


def is_own_image(free: LinearModel, groups: Sequence[ElementGroup], mirror: Mirror) -> bool:
    """Whether a structure with its elements is its own mirror image."""
    n = free.n_relative
    even, odd = (_of_parity(free, mirror, parity) for parity in (1.0, -1.0))
    residual = free.residual[:n, :n]
    image = mirror.of(mirror.of(residual).T).T
    coupled = any(not _negligible(damping[np.ix_(even, ~even)], damping) for damping in (free.hysteretic, free.viscous))
    if not (even | odd).all() or not _negligible(image - residual, residual) or coupled:
        return False
    images = [_images(group, mirror) for group in groups]
    return all(i is not None and _same_parameters(g.values, i) for g, i in zip(groups, images, strict=True))


def _of_parity(free: LinearModel, mirror: Mirror, parity: float) -> Booleans:
    """(m,) whether each mode's relative displacements are their own image (1), or its opposite (-1)"""
    relative = free.phi[: free.n_relative]
    size = np.linalg.norm(relative, axis=0)
    apart = np.linalg.norm(relative - parity * mirror.of(relative), axis=0)
    return np.asarray(apart <= AGREEMENT * size + AGREEMENT**2 * size.max())


def _modes_of(free: LinearModel, mirror: Mirror, parity: float) -> Booleans:
    """(m,) whether each is of this parity; those that move no element are of both"""
    return _of_parity(free, mirror, parity) | ~_of_parity(free, mirror, -parity)


def half_structure(free: LinearModel, mirror: Mirror, parity: float = 1.0) -> LinearModel:
    """The symmetric motions (parity 1) of a structure that is its own image, or those that are the opposite of their
    image (-1), on the kept rows.

    A force on a kept row stands for itself and its image.
    """
    n, kept = free.n_relative, mirror.kept
    rows = np.concatenate([kept, np.arange(n, free.n_rows)])
    chosen = _modes_of(free, mirror, parity)
    reflected = free.residual.copy()
    reflected[:, :n] = (free.residual[:, :n] + parity * mirror.of(free.residual[:, :n].T).T) / 2
    reflected[:n] = (reflected[:n] + parity * mirror.of(reflected[:n])) / 2
    phi = free.phi.copy()
    phi[:n] = (phi[:n] + parity * mirror.of(phi[:n])) / 2
    return replace(
        free,
        omega_squared=free.omega_squared[chosen],
        phi=phi[np.ix_(rows, chosen)],
        residual=reflected[np.ix_(rows, rows)],
        hysteretic=free.hysteretic[np.ix_(chosen, chosen)],
        viscous=free.viscous[np.ix_(chosen, chosen)],
        n_relative=len(kept),
        basis=None,
    )


def acts_symmetrically(free: LinearModel, mirror: Mirror, row: int) -> bool:
    """Whether a force on the row of a point is its own mirror image: it moves no antisymmetric mode."""
    drive = free.phi[row]
    return row >= free.n_relative and _negligible(drive[~_modes_of(free, mirror, 1.0)], drive)


def half_groups(groups: Iterable[ElementGroup], mirror: Mirror) -> tuple[ElementGroup, ...]:
    """The elements on the kept rows, each for itself and its image; of a problem that is its own image."""
    number = {int(row): i for i, row in enumerate(mirror.kept)}
    halves = []
    for group in groups:
        image = _images(group, mirror)
        assert image is not None, "asked for where each element has an image"
        kept = np.flatnonzero(image >= np.arange(len(image)))
        rows = np.vectorize(number.get, otypes=[np.int64])(group.rows[kept])
        copies = np.where(image[kept] > kept, 2.0, 1.0)
        parameters = type(group.values)(*(value[kept] for value in group.values))
        halves.append(replace(group, parameters=parameters, rows=rows, copies=copies))
    return tuple(halves)


def _images(group: ElementGroup, mirror: Mirror) -> Integers | None:
    """(n_elements,) number of each element's image; None where its rows are not those of one element."""
    element = {int(rows[0]): i for i, rows in enumerate(group.rows)}
    image = np.array([element.get(int(row), -1) for row in mirror.image[group.rows[:, 0]]])
    if (image < 0).any() or not np.array_equal(group.rows[image], mirror.image[group.rows]):
        return None
    return image


def _same_parameters(values: Any, image: Integers) -> bool:
    return all(np.allclose(value, value[image], rtol=AGREEMENT, atol=0.0) for value in values)


def _negligible(part: Floats, whole: Floats) -> bool:
    return bool(np.abs(part).max(initial=0.0) <= AGREEMENT * np.abs(whole).max(initial=0.0))
