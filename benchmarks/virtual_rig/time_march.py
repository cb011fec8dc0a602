"""The bench marched in time: a check on the frequency-domain solver, with no Fourier series in it.

    q'' + C q' + omega^2 q = phi_e^T p(t) - phi^T f,   y = phi q + R_e p(t) - R f,   f = law(y, sliders) or k y

Newmark's average acceleration for the modes; the residual flexibility is massless and answers at once, so that a step
ends where y = y* - A f, solved with the law by Newton's method. The step is longer by (w h)^2 / 12 ("prewarped"), so
that linear motion at w is exact. Damping has to be viscous (Bench.viscous_at), the mean position free
(Bench.mean_share = 1), attachments springs, the clamps rigid.
"""

from dataclasses import dataclass

import numpy as np
from numba import njit
from numpy.typing import NDArray

from updamp.benchmarks.virtual_rig.assembled import Assembled
from updamp.benchmarks.virtual_rig.periodic import Motion

Floats = NDArray[np.float64]


@dataclass(frozen=True, eq=False)
class Marched:
    """first_harmonic: of the point observed [m], in each period; largest: opening and slip seen in the last period, as
    shares of the patches"""

    first_harmonic: NDArray[np.complex128]
    open_share: float
    slip_share: float


def march(rig: Assembled, motion: Motion, observed: str, periods: int, steps: int, sliders: int = 10) -> Marched:
    """From the state of a harmonic motion on, under its force."""
    bench, w = rig.bench, motion.w
    assert bench.viscous_at is not None
    assert bench.mean_share == 1
    assert not bench.elements
    modal, n, V = rig.free, rig.n_rows, rig.attached.T
    stiffness = np.array([a.dynamic_stiffness(0.0).real for a in bench.attachments])
    read = np.vstack([np.eye(n, len(modal.phi)), V.T])  # patches, then attachments
    phi, R = read @ modal.phi, read @ modal.residual @ read.T
    excited, row = rig.row(bench.excitation), rig.row(observed)
    h = 2 / w * np.tan(np.pi / steps)
    C = _damping(rig)
    q, v, a = _state(rig, motion, phi, stiffness)
    p = bench.patches
    shares = np.ones(1) if p.spread == 0 else 1 + p.spread * ((2 * np.arange(sliders) + 1) / sliders - 1)
    one = np.eye(len(q))
    S = np.linalg.inv(4 / h**2 * one + 2 / h * C + modal.stiffness)
    series, opened, slipped = _march(
        q, v, a, S, 4 / h**2 * one + 2 / h * C, 4 / h * one + C, h, phi, phi @ S @ phi.T + R,
        modal.phi[excited], read @ modal.residual[:, excited], modal.phi[row], modal.residual[row] @ read.T,
        modal.residual[row, excited], motion.force, stiffness, p.mu, p.kt, p.kn, p.n0, p.gap, p.viscosity,
        p.speed_drop, p.speed_scale, shares, periods, steps,
    )  # fmt: skip
    turn = np.exp(-2j * np.pi * np.arange(1, steps + 1) / steps)
    return Marched(2 / steps * series.reshape(periods, steps) @ turn, opened / len(p.kt), slipped / len(p.kt))


def _damping(rig: Assembled) -> Floats:
    """(m, m) viscous"""
    loss = rig.bench.loss_factors
    return np.asarray(sum(loss[body] * rig.free.elastic[body] for body in loss) / (rig.bench.viscous_at or 1.0))


def _state(rig: Assembled, motion: Motion, phi: Floats, stiffness: Floats) -> tuple[Floats, Floats, Floats]:
    """Modal displacement, velocity and acceleration at t = 0 of the harmonic motion."""
    basis, n = motion.receptance.basis, rig.n_rows
    patches = motion.departure.copy()
    patches[: len(rig.springs)] += rig.springs[:, None] * motion.x[: len(rig.springs)]
    # The attachments' forces follow from their displacement, which needs every force: solved for.
    q, v, a = (np.zeros(phi.shape[1]) for _ in range(3))
    size, excited = len(rig.free.phi), rig.row(rig.bench.excitation)
    V = rig.attached.T
    for k in range(basis.harmonics + 1):
        f = patches[:, 2 * k - 2] + 1j * patches[:, 2 * k - 1] if k else patches[:, -1].astype(complex)
        load = np.zeros(size, complex)
        load[:n] = -f
        load[excited] += motion.force if k == 1 else 0.0
        w = k * motion.w
        D = rig.free.stiffness + 1j * w * _damping(rig) - w**2 * np.eye(len(q))
        shapes = V.T @ rig.free.phi
        D = D + shapes.T @ np.linalg.solve(np.diag(1 / stiffness) + V.T @ rig.free.residual @ V, shapes)
        static = V.T @ (rig.free.residual @ load)
        pull = np.linalg.solve(np.diag(1 / stiffness) + V.T @ rig.free.residual @ V, static)
        modal = np.linalg.solve(D, rig.free.phi.T @ load - shapes.T @ pull)
        q, v, a = q + modal.real, v + (1j * w * modal).real, a - (w**2 * modal).real
    return q, v, a


@njit(cache=True)
def _march(
    q, v, a, S, by_q, by_v, h, phi, A, phi_e, R_e, phi_s, R_s, R_se, load, springs, mu, kt, kn, n0, gap, c, drop, scale,
    shares, periods, steps,
):  # fmt: skip
    n, m, rows = len(kt), len(shares), len(A)
    sliders, moved = np.zeros((n, 2, m)), np.zeros((n, 2, m))
    x, before = np.zeros(rows), np.zeros(rows)
    series = np.empty(periods * steps)
    opened, slipped = np.zeros(n), np.zeros(n)
    first = True
    for i in range(periods * steps):
        p = load * np.cos(2 * np.pi * (i + 1) / steps)
        free = S @ (by_q @ q + by_v @ v + a + phi_e * p)
        start = phi @ free + R_e * p
        for _ in range(60):
            f, T = np.zeros(rows), np.zeros((rows, rows))
            for j in range(rows - 3 * n):
                f[3 * n + j], T[3 * n + j, 3 * n + j] = springs[j] * x[3 * n + j], springs[j]
            for j in range(n):
                _law(j, x, before, h, first, sliders, moved, mu, kt, kn, n0, gap, c, drop, scale, shares, f, T)
            r = x - start + A @ f
            if np.abs(r).max() <= 1e-12 * np.abs(x).max() + 1e-18:
                break
            x = x - np.linalg.solve(np.eye(rows) + A @ T, r)
        if i >= (periods - 1) * steps:
            for j in range(n):
                if n0[j] + kn[j] * (x[3 * j + 2] - gap[j]) <= 0:
                    opened[j] = 1.0
                elif np.abs(moved[j] - sliders[j]).max() > 1e-9 * np.abs(x[: 3 * n]).max():
                    slipped[j] = 1.0
        sliders[:] = moved
        before, first = x.copy(), False
        new = free - S @ (phi.T @ f)
        a_new = 4 / h**2 * (new - q) - 4 / h * v - a
        v = v + h / 2 * (a + a_new)
        q, a = new, a_new
        series[i] = phi_s @ q + R_se * p - R_s @ f
    return series, opened.sum(), slipped.sum()


@njit(cache=True)
def _law(j, x, before, h, first, sliders, moved, mu, kt, kn, n0, gap, c, drop, scale, shares, f, T):
    r, m = 3 * j, len(shares)
    normal = max(n0[j] + kn[j] * (x[r + 2] - gap[j]), 0.0)
    closed = normal > 0
    f[r + 2], T[r + 2, r + 2] = normal - max(n0[j] - kn[j] * gap[j], 0.0), kn[j] if closed else 0.0
    friction = mu[j]
    if drop != 0 and not first:
        speed = np.sqrt((x[r] - before[r]) ** 2 + (x[r + 1] - before[r + 1]) ** 2) / h
        friction = mu[j] * (1 - drop * speed / (speed + scale))
    for d in range(2):
        for s in range(m):
            limit, trial = shares[s] * friction * normal / m, kt[j] / m * (x[r + d] - sliders[j, d, s])
            if abs(trial) <= limit:
                force = trial
                T[r + d, r + d] += kt[j] / m
            else:
                side = 1.0 if trial > 0 else -1.0
                force = side * limit
                T[r + d, r + 2] += side * shares[s] * friction * kn[j] / m if closed else 0.0
            moved[j, d, s] = x[r + d] - force / (kt[j] / m)
            f[r + d] += force
    if c[j] != 0 and closed and not first:
        for d in range(3):
            f[r + d] += c[j] * (x[r + d] - before[r + d]) / h
            T[r + d, r + d] += c[j] / h
