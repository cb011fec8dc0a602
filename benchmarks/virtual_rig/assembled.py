"""The bench as equations: bodies side by side, the patches' springs added exactly, attachments added at each frequency.

Rows: relative displacement at the patches (damper minus platform; t1, t2, n), then of the point elements, then points.
"""

from collections.abc import Mapping
from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np
import scipy.linalg
from numpy.typing import NDArray

from updamp.benchmarks.virtual_rig.bench import BODIES, Bench
from updamp.benchmarks.virtual_rig.bodies import Bodies

Floats = NDArray[np.float64]
Complex = NDArray[np.complex128]


@dataclass(frozen=True, eq=False)
class Modal:
    """y = phi q + residual f with M q'' + K q = phi^T f; damping is kept per body, as its loss factor may vary.

    stiffness, mass: (m, m), the latter 1 but for a turning clamp; elastic: body -> (m, m) its share of the stiffness
    """

    stiffness: Floats
    mass: Floats
    elastic: Mapping[str, Floats]
    phi: Floats
    residual: Floats

    def sprung(self, rows: int, stiffness: Floats) -> "Modal":
        """With a spring on each of the first rows: y = phi q + R (f - S y) solved for y."""
        R = self.residual[:, :rows]
        W = np.linalg.solve(np.eye(rows) + stiffness[:, None] * R[:rows], np.diag(stiffness))
        W = (W + W.T) / 2
        shapes = self.phi[:rows]
        return replace(
            self,
            stiffness=self.stiffness + shapes.T @ W @ shapes,
            phi=self.phi - R @ (W @ shapes),
            residual=self.residual - R @ W @ R.T,
        )


@dataclass(frozen=True, eq=False)
class Assembled:
    """bench: as it stands; stuck: with every patch on its springs"""

    bench: Bench
    points: tuple[str, ...]
    free: Modal

    @property
    def n_patches(self) -> int:
        return len(self.bench.bodies.area)

    @property
    def n_rows(self) -> int:
        """Rows with a nonlinear force."""
        return 3 * self.n_patches + len(self.bench.elements)

    def row(self, point: str) -> int:
        return self.n_rows + self.points.index(point)

    @cached_property
    def springs(self) -> Floats:
        """(3 n,) of the patches while they stick and stay closed [N/m]"""
        return self.bench.patches.at_rest.ravel()

    @cached_property
    def stuck(self) -> Modal:
        return self.free.sprung(len(self.springs), self.springs)

    @cached_property
    def attached(self) -> Floats:
        """(n_attachments, rows) directions"""
        return np.stack([self.direction(a.direction) for a in self.bench.attachments])

    def direction(self, weights: Mapping[str, float]) -> Floats:
        found = np.zeros(len(self.free.phi))
        for point, weight in weights.items():
            found[self.row(point)] += weight
        return found

    @cached_property
    def mean_compliance(self) -> Floats:
        """(n_rows, n_rows) mean motion that the contacts see by mean force beyond the springs [m/N].

        Seeing a share c of the motion is being c times as compliant, for the structure, not for the contacts.
        """
        share, n = self.bench.mean_share, self.n_rows
        softer = replace(self.free, stiffness=self.free.stiffness / share, residual=self.free.residual * share)
        modal = softer.sprung(len(self.springs), self.springs)
        static = np.array([a.dynamic_stiffness(0.0).real / share for a in self.bench.attachments])
        compliance = modal.phi @ np.linalg.solve(modal.stiffness, modal.phi.T) + modal.residual
        V = self.attached.T[:, static != 0]
        motion = compliance @ V
        motion = motion @ np.linalg.solve(np.diag(1 / static[static != 0]) + V.T @ motion, motion.T)
        return (compliance - motion)[:n, :n]

    def stuck_frequencies(self, count: int = 3) -> Floats:
        """(count,) [Hz] with all attachments as they are at rest, undamped."""
        static = np.array([a.dynamic_stiffness(0.0).real for a in self.bench.attachments])
        V = self.attached[static != 0].T
        W = np.linalg.inv(np.diag(1 / static[static != 0]) + V.T @ self.stuck.residual @ V)
        shapes = V.T @ self.stuck.phi
        squared = scipy.linalg.eigh(self.stuck.stiffness + shapes.T @ W @ shapes, self.stuck.mass, eigvals_only=True)
        return np.sqrt(squared[:count]) / (2 * np.pi)


def assembled(bench: Bench) -> Assembled:
    bodies, n = bench.bodies, len(bench.bodies.area)
    points = tuple(f"{name}.{p}" for name in BODIES for p in _points(bodies, name))
    parts = {name: _body(bench, name) for name in BODIES}
    size = 3 * n + len(bench.elements) + len(points)
    phi, residual, elastic = [], np.zeros((size, size)), {}
    start, first = 3 * n + len(bench.elements), 0
    total = sum(len(part.stiffness) for part in parts.values())
    for name, part in parts.items():
        rows, sign = _patch_rows(bodies, name)
        own = _points(bodies, name)
        where = np.concatenate([rows, start + np.arange(len(own))])
        signs = np.concatenate([np.full(len(rows), sign), np.ones(len(own))])
        start += len(own)
        here = np.zeros((size, part.phi.shape[1]))
        here[where] = signs[:, None] * part.phi
        phi.append(here)
        residual[np.ix_(where, where)] += signs[:, None] * part.residual * signs
        share = np.zeros((total, total))
        span = slice(first, first + len(part.stiffness))
        share[span, span] = part.elastic[name]
        elastic[name], first = share, span.stop
    modal = Modal(
        scipy.linalg.block_diag(*(p.stiffness for p in parts.values())),
        scipy.linalg.block_diag(*(p.mass for p in parts.values())),
        elastic, np.hstack(phi), residual,
    )  # fmt: skip
    return _with_element_rows(Assembled(bench, points, modal))


def _with_element_rows(plain: Assembled) -> Assembled:
    modal, first = plain.free, 3 * plain.n_patches
    read = np.eye(len(modal.phi))
    for i, element in enumerate(plain.bench.elements):
        read[first + i] = plain.direction(element.direction)
    return replace(plain, free=replace(modal, phi=read @ modal.phi, residual=read @ modal.residual @ read.T))


def _points(bodies: Bodies, name: str) -> list[str]:
    return [str(p) for p in (bodies.damper_points if name == "damper" else bodies.blade_points)]


def _patch_rows(bodies: Bodies, name: str) -> tuple[NDArray[np.int64], float]:
    dofs = np.arange(3 * len(bodies.area)).reshape(-1, 3)
    if name == "damper":
        return dofs.ravel(), 1.0
    return dofs[bodies.face == (name == "blade_right")].ravel(), -1.0


def _body(bench: Bench, name: str) -> Modal:
    bodies, factor = bench.bodies, (bench.tuning or {}).get(name, 1.0)
    if name == "damper":
        omega, phi, residual = bodies.damper_omega, bodies.damper_phi, bodies.damper_residual
    else:
        omega, phi, residual = bodies.blade_omega, bodies.blade_phi, bodies.blade_residual
    stiffness, mass = np.diag((factor * omega) ** 2), np.eye(len(omega))
    plain = Modal(stiffness, mass, {name: stiffness}, phi, residual / factor**2)
    if name != "damper" and bench.clamp_compliance > 0:
        plain = _turning(plain, bench, name)
    if name == "blade_left":
        mirrored = bodies.mirrored(bodies.mirrored(plain.residual).T).T
        return replace(plain, phi=bodies.mirrored(plain.phi), residual=mirrored)
    return plain


def _turning(blade: Modal, bench: Bench, name: str) -> Modal:
    """The blade on a root that turns about z: one more coordinate, coupled to the modes by the inertia alone."""
    bodies, spring = bench.bodies, 1 / bench.clamp_compliance
    L = bodies.participation[:, None]
    # In units in which the turning's own mass is 1, as that of the modes.
    scale = 1 / np.sqrt(float(bodies.inertia))
    mass = np.block([[blade.mass, L * scale], [L.T * scale, np.ones((1, 1))]])
    pad = ((0, 1), (0, 1))
    elastic = np.pad(blade.stiffness, pad)
    stiffness = elastic.copy()
    stiffness[-1, -1] = spring * scale**2
    phi = np.column_stack([blade.phi, bodies.turning * scale])
    return Modal(stiffness, mass, {name: elastic}, phi, blade.residual)
