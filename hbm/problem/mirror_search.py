"""The mirror image of a problem whose user has not stated one, found from what its excitation moves.

Solved as a whole, a symmetric problem passes places where motions begin that break its symmetry, and whether its curve
is followed across them depends on round-off (hbm/problem/mirror.py). A force that is its own mirror image moves
symmetric modes alone. So the modes that it does not move tell the antisymmetric ones, and with them each displacement
its image: the one that moves as it in the driven modes and against it in the others, or with the opposite sign.

Modes of the same frequency, as of a ring of equal parts, come out turned by any angle, all of them driven. Turned so
that one of them is driven alone, the others tell as well.
"""

from collections.abc import Callable, Sequence
from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from updamp.hbm.problem.elements import ElementGroup
from updamp.hbm.problem.linear_model import LinearModel
from updamp.hbm.problem.mirror import AGREEMENT, Mirror

Floats = NDArray[np.float64]
Integers = NDArray[np.int64]

# Of motions that laws are tried at: where a contact slips or a gap closes is not known, nor the unit of length.
SIZES = 10.0 ** np.arange(-12, 13)
SEED = 20261127
# Squares of frequencies that differ by less, relative, are the same but for round-off: half of the digits.
_SAME = float(np.sqrt(np.finfo(float).eps))


def driven_alone(free: LinearModel, row: int) -> LinearModel:
    """The same structure with modes of the same frequency turned so that a force on the row moves one of them alone;
    the model itself where no two are of the same."""
    order = np.argsort(free.omega_squared)
    ascending = free.omega_squared[order]
    apart = np.diff(ascending) > _SAME * ascending[1:] + np.finfo(float).eps * ascending[-1]
    omega_squared, turned = free.omega_squared.copy(), np.eye(len(order))
    for same in np.split(order, np.flatnonzero(apart) + 1):
        omega_squared[same] = omega_squared[same].mean()
        turned[np.ix_(same, same)] = np.linalg.qr(free.phi[row, same][:, None], mode="complete")[0]
    if apart.all():
        return free
    hysteretic, viscous = (turned.T @ damping @ turned for damping in (free.hysteretic, free.viscous))
    return replace(
        free, omega_squared=omega_squared, phi=free.phi @ turned, hysteretic=hysteretic, viscous=viscous,
        basis=None if free.basis is None else free.basis @ turned,
    )  # fmt: skip


def mirror_driven_at(free: LinearModel, groups: Sequence[ElementGroup], row: int) -> Mirror | None:
    """What the symmetry of a structure and its elements is, if a force on this row is symmetric; whether it is one is
    left to be asked (`is_own_image`).

    returns: None where all modes are driven, or where elements have no images
    """
    drive = np.abs(free.phi[row])
    driven = drive > AGREEMENT * drive.max()
    relative = free.phi[: free.n_relative]
    size = np.linalg.norm(relative, axis=0)
    moving = size > AGREEMENT**2 * size.max(initial=0.0)  # of what others leave there by round-off, no direction
    if not moving[~driven].any():
        return None
    modes = relative[:, moving] / size[moving]
    parity = np.where(driven[moving], 1.0, -1.0)
    image, sign = np.zeros(len(modes), dtype=np.int64), np.ones(len(modes))
    for group in groups:
        found = _images(modes[group.rows], modes[group.rows] * parity)
        if found is None:
            return None
        element, signs = found
        image[group.rows], sign[group.rows] = group.rows[element], signs
    return Mirror(image, sign)


def laws_are_mirrored(force: Callable[[Floats], Floats], mirror: Mirror, n_coefficients: int) -> bool:
    """Whether the image of a motion has the image of its forces, of random motions of all sizes. Where a displacement
    changes its sign in the image a law must be odd in it, which no parameter tells.

    force: of a motion (n_relative, n_coefficients)
    """
    if (mirror.sign > 0).all():
        return True
    motion = np.random.default_rng(SEED).standard_normal((len(mirror.sign), n_coefficients))
    with np.errstate(all="ignore"):  # of a law at a size that is beyond what it is for
        pairs = [(mirror.of(force(size * motion)), force(size * mirror.of(motion))) for size in SIZES]
    return all(_agree(*pair) for pair in pairs if np.isfinite(pair).all())


def _agree(expected: Floats, found: Floats) -> bool:
    return bool(np.abs(found - expected).max() <= AGREEMENT * np.abs(expected).max())


def _images(motions: Floats, reflected: Floats) -> tuple[Integers, Floats] | None:
    """The element that moves as the image of each, (n,), and the signs of its displacements, (n, d). Of several that
    move alike, as two sliders at one place, the first is the image of the first.

    motions, reflected: (n, d, m) in the modes, and with those turned round that are not driven
    """
    least = AGREEMENT * (motions**2).sum(axis=(1, 2)).max()
    apart, signs = _apart(motions, reflected)
    alike, images = _apart(motions, motions)[0] <= least, apart <= least
    element, alone = np.empty(len(motions), dtype=np.int64), np.arange(len(motions))
    for i in alone:
        there, here = np.flatnonzero(images[:, i]), np.flatnonzero(alike[:, i])
        if len(there) != len(here):
            return None
        element[i] = there[np.searchsorted(here, i)]
    if not np.array_equal(element[element], alone):
        return None
    return element, signs[element, alone]


def _apart(motions: Floats, others: Floats) -> tuple[Floats, Floats]:
    """Squares of distances (n, n) of each from each other, with the signs (n, n, d) by which they are closest."""
    n, d, _ = motions.shape
    apart, signs = np.zeros((n, n)), np.empty((n, n, d))
    for i in range(d):
        own, other = motions[:, i], others[:, i]
        squares = (own**2).sum(axis=1)[:, None] + (other**2).sum(axis=1)
        product = own @ other.T  # [image, element]
        signs[:, :, i] = np.where(product < 0, -1.0, 1.0)
        apart += squares - 2 * np.abs(product)
    return apart, signs
