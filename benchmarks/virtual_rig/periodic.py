"""The periodic motion at one frequency and force: Newton's method with GMRES on the motion of the patches.

x = x_stuck(w) - G(w) d(x)         d: what the forces depart from those of the springs
"""

from dataclasses import dataclass
from functools import cached_property, lru_cache

import numpy as np
import scipy.linalg
from numpy.typing import NDArray

from updamp.benchmarks.virtual_rig.assembled import Assembled
from updamp.benchmarks.virtual_rig.patch_forces import Basis, departures
from updamp.benchmarks.virtual_rig.receptance import BenchReceptance, receptance

Floats = NDArray[np.float64]
Complex = NDArray[np.complex128]

TIPS = {"blade_left": "blade_left.tip.x", "blade_right": "blade_right.tip.x"}


class NotSolvedError(RuntimeError):
    """No periodic motion was found."""


@dataclass(frozen=True, eq=False)
class Motion:
    """x: (n_rows, n_c) of patches and elements [m]; receptance: at this frequency; force: amplitude on the rig [N]

    departure: (n_rows, n_c) [N]; iterations: of Newton's method
    """

    x: Floats
    w: float
    force: float
    departure: Floats
    receptance: BenchReceptance
    iterations: int

    def response(self, point: str) -> Complex:
        """(H,) of exp(i k w t) [m]"""
        rig = self.receptance.rig
        row = rig.row(point)
        y = -self.receptance.respond(self.departure, np.array([row]))[0].view(complex)
        y[0] += self.force * self.receptance.excited(rig.row(rig.bench.excitation))[row]
        return np.asarray(y)

    @property
    def tips(self) -> dict[str, float]:
        """Amplitudes of the first harmonic [m]"""
        return {body: float(abs(self.response(point)[0])) for body, point in TIPS.items()}


@dataclass(frozen=True)
class SolverOptions:
    """harmonics: 1 to this; n_time: samples a period; tolerance: of the motion, relative to its largest"""

    harmonics: int = 7
    n_time: int = 512
    tolerance: float = 1e-7
    iterations: int = 25


def motion_at(
    rig: Assembled, w: float, force: float, start: Floats | None, options: SolverOptions = SolverOptions(),
    tip_amplitude: dict[str, float] | None = None,
) -> Motion:  # fmt: skip
    """start: motion to begin from, None for the stuck one; tip_amplitude: that the loss factor is taken at

    raises: NotSolvedError
    """
    basis = _basis(options.harmonics, rig.bench.mean_share > 0, options.n_time)
    G = receptance(rig, basis, w, tip_amplitude or {})
    stuck = np.zeros((rig.n_rows, basis.size))
    stuck[:, :2] = force * G.excited(rig.row(rig.bench.excitation))[: rig.n_rows, None].view(float)
    x = stuck.copy() if start is None or start.shape != stuck.shape else start
    value, tangents = forces(rig, x, w, basis)
    r = x - stuck + G.contacts(value)
    before = [np.linalg.norm(r)]
    for iteration in range(options.iterations):
        if np.abs(r).max() <= options.tolerance * np.abs(x).max():
            return Motion(x, w, force, value, G, iteration)
        step = -_newton_step(G, tangents, r, 1e-6)
        # Where next to nothing holds the mean position a whole step may lead far away, to where nothing touches, and
        # what is left of a step's equations is large in it.
        part = min(1.0, float(np.linalg.norm(x) / max(np.linalg.norm(step), np.finfo(float).tiny)))
        while True:
            ahead = x + part * step
            value, tangents = forces(rig, ahead, w, basis)
            r = ahead - stuck + G.contacts(value)
            if np.linalg.norm(r) <= max(before[-3:]) or part < 0.05:
                break
            part /= 2
        x = ahead
        before.append(np.linalg.norm(r))
    raise NotSolvedError(f"{w / 2 / np.pi:.3f} Hz, {force:g} N: {np.abs(r).max() / np.abs(x).max():.1e} left")


@lru_cache
def _basis(harmonics: int, mean: bool, n_time: int) -> Basis:
    return Basis(harmonics, mean, n_time)


@dataclass(frozen=True, eq=False)
class Tangents:
    """Derivatives of the departures by the motion, of the patches and elements that depart.

    moving: (k,) their patches; blocks: (k, 3 n_c, 3 n_c); elements: (n_elements, n_c, n_c); first: row of the first of
    these; rows: (3 k + n_elements,) of all of them
    """

    moving: NDArray[np.int64]
    blocks: Floats
    elements: Floats
    first: int

    @cached_property
    def rows(self) -> NDArray[np.int64]:
        of_elements = self.first + np.arange(len(self.elements))
        return np.concatenate([(3 * self.moving[:, None] + np.arange(3)).ravel(), of_elements])

    def times(self, v: Floats) -> Floats:
        """(len(rows), n_c) motion of the rows -> force on them"""
        k, n_c = len(self.moving), v.shape[1]
        pushed = (self.blocks @ v[: 3 * k].reshape(k, 3 * n_c, 1))[:, :, 0]
        return np.concatenate([pushed.reshape(3 * k, n_c), (self.elements @ v[3 * k :, :, None])[:, :, 0]])


def _newton_step(G: BenchReceptance, tangents: Tangents, r: Floats, tolerance: float) -> Floats:
    """v of v + G T v = r: on the rows that T is not zero on by iteration, on the others from there."""
    rows, times = tangents.rows, tangents.times
    if not len(rows):
        return r
    among = G.between(rows, rows)
    moving = gmres(lambda v: v + among(times(v)), r[rows], tolerance)
    return r - G.between(rows, np.arange(len(r)))(times(moving))


def forces(rig: Assembled, x: Floats, w: float, basis: Basis) -> tuple[Floats, Tangents]:
    """Departures (n_rows, n_c), and their derivatives."""
    n, n_c = rig.n_patches, basis.size
    patches, tangent = departures(x[: 3 * n].reshape(n, 3, n_c), w, basis, rig.bench.patches)
    moving = np.flatnonzero(tangent.any(axis=(1, 2)))
    value, own = [patches.reshape(3 * n, n_c)], [np.zeros((0, n_c, n_c))]
    for element, coefficients in zip(rig.bench.elements, x[3 * n :], strict=True):
        f, by_u, by_v = element.force(basis.values @ coefficients, w * (basis.rates @ coefficients))
        value.append((basis.analysis @ f)[None])
        own.append((basis.analysis @ (by_u[:, None] * basis.values + w * by_v[:, None] * basis.rates))[None])
    tangents = Tangents(moving, np.ascontiguousarray(tangent[moving]), np.concatenate(own), 3 * n)
    return np.concatenate(value), tangents


def gmres(product, right, tolerance, most=200):
    """Solve product(v) = right to the relative tolerance (Saad and Schultz 1986), orthogonalised twice; the small least
    squares problem by Givens rotations, as in their section 3.2."""
    size = np.linalg.norm(right)
    if size == 0:
        return right
    basis = np.empty((most + 1, right.size))
    R, goal = np.zeros((most, most)), np.zeros(most + 1)
    turns = np.zeros((most, 2))
    basis[0], goal[0] = right.ravel() / size, size
    for j in range(most):
        v = product(basis[j].reshape(right.shape)).ravel()
        h = np.zeros(j + 1)
        for _ in range(2):
            c = basis[: j + 1] @ v
            v = v - c @ basis[: j + 1]
            h += c
        below = float(np.linalg.norm(v))
        column = h.tolist()
        for i, (cos, sin) in enumerate(turns[:j].tolist()):
            column[i], column[i + 1] = cos * column[i] + sin * column[i + 1], cos * column[i + 1] - sin * column[i]
        length = float(np.hypot(column[j], below))
        cos, sin = turns[j] = column[j] / length, below / length
        column[j] = length
        R[: j + 1, j] = column
        goal[j], goal[j + 1] = cos * goal[j], -sin * goal[j]
        if abs(goal[j + 1]) <= tolerance * size or below == 0 or j == most - 1:
            y = scipy.linalg.solve_triangular(R[: j + 1, : j + 1], goal[: j + 1])
            return (y @ basis[: j + 1]).reshape(right.shape)
        basis[j + 1] = v / below
    raise AssertionError
