"""Which combination of the modes of a changed component is which of its modes before.

Modes of either are known up to their signs, those of equal frequency (a free damper's rigid motions) up to a rotation,
and modes that pass each other on the way change their order. A blend of both needs them side by side.

Rayleigh's quotients of stiffness and mass say how far a mode can turn. Where a change multiplies the quotient of every
motion by something between exp(a) and exp(b), it couples two modes by (b - a) / 2 at most, and turns them by an angle
of tan(2 angle) <= (b - a) / ln(lambda_j / lambda_i). The changes of the frequencies themselves tell a and b. So modes
are combined with those that they may turn towards by more than `_LEAST_TURN`, where what is linear in the shapes is
off, and with no others, however alike they look at the interface, which is all that is known of their shapes. Among
them the rotation is the one that takes their shapes nearest to those before (orthogonal Procrustes problem;
Schoenemann, Psychometrika 31, 1966).
"""

from collections.abc import Iterator, Sequence

import numpy as np
import scipy.linalg
from numpy.typing import NDArray
from scipy.sparse import coo_array
from scipy.sparse.csgraph import connected_components

from updamp.hbm.problem.linear_model import LinearModel

Floats = NDArray[np.float64]
Integers = NDArray[np.int64]

# Shapes that have less in common are of different symmetry: what round-off leaves is less than half of the digits.
_NOTHING_IN_COMMON = float(np.sqrt(np.finfo(float).eps))
# [rad] Shapes that turn by less are off by less than 1 % half-way where they are taken as linear (an eighth of its
# square). Modes 2 % apart that turned by 34 degrees made an effect 7 % too large.
_LEAST_TURN = np.arctan(0.5) / 2


class ModesDifferError(ValueError):
    """A mode of the changed component has none before that it could have come from."""


def alignment(before: LinearModel, after: LinearModel, owner: Sequence[str]) -> Floats:
    """(m, m) orthogonal Q: the columns of after.phi @ Q are where those of before.phi have gone; owner: (m,)

    raises: ModesDifferError where a mode is nearer to a right angle to all there were than to one of them
    """
    Q = np.zeros((len(owner), len(owner)))
    for name in dict.fromkeys(owner):
        modes = np.flatnonzero(np.array(owner) == name)
        for together in _that_may_mix(before.omega_squared[modes], after.omega_squared[modes]):
            for old, new in _of_one_symmetry(before.phi, after.phi, modes[together]):
                Q[np.ix_(new, old)] = _nearest(before.phi[:, old], after.phi[:, new], name)
    return Q


def _that_may_mix(before: Floats, after: Floats) -> Iterator[Integers]:
    """Numbers of modes, group by group. before, after: (m,) squared frequencies of one component, ascending"""
    rigid = before <= 0
    if not np.array_equal(rigid, after <= 0):
        raise ModesDifferError(f"of {rigid.sum()} rigid-body modes {np.sum(after <= 0)} are left")
    if rigid.any():
        yield np.flatnonzero(rigid)
    elastic = np.flatnonzero(~rigid)
    growth = np.log(after[elastic] / before[elastic])
    most_coupled = (growth.max(initial=0.0) - growth.min(initial=0.0)) / np.tan(2 * _LEAST_TURN)
    apart = np.diff(np.log(before[elastic])) > most_coupled
    yield from np.split(elastic, np.flatnonzero(apart) + 1)


def _of_one_symmetry(before: Floats, after: Floats, modes: Integers) -> Iterator[tuple[Integers, Integers]]:
    """Modes of a group before and after, apart by what their shapes (n_rows, m) have in common: those that are their
    own mirror image pass through those that are its opposite, and are not combined with them."""
    one, other = (shape[:, modes] / np.linalg.norm(shape[:, modes], axis=0) for shape in (before, after))
    old, new = np.nonzero(np.abs(one.T @ other) > _NOTHING_IN_COMMON)
    n = len(modes)
    _, label = connected_components(
        coo_array((np.ones(len(old)), (old, n + new)), shape=(2 * n, 2 * n)), directed=False
    )
    for part in np.unique(label):
        own = modes[label[:n] == part], modes[label[n:] == part]
        if len(own[0]) != len(own[1]):
            raise ModesDifferError("a mode has left those that are kept, and one of another symmetry has come in")
        yield own


def _nearest(before: Floats, after: Floats, name: str) -> Floats:
    """(k, k) rotation of the shapes after (n_rows, k) to those before."""
    Q, _ = scipy.linalg.orthogonal_procrustes(after, before)
    turned = after @ Q
    cosine = np.sum(turned * before, axis=0) / np.linalg.norm(turned, axis=0) / np.linalg.norm(before, axis=0)
    if cosine.min() < np.cos(np.pi / 4):
        raise ModesDifferError(f"a mode of {name} turns by {np.degrees(np.arccos(cosine.min())):.0f} degrees")
    return np.asarray(Q)
