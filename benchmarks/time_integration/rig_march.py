"""Periodic motion of a structure given by modes and residual flexibility, by marching in time and shooting.

A check on the harmonic balance that shares nothing with it but the linear model's arrays: the contact law is written
out again with its sliders as states, and there is no Fourier series in it.

    q'' + C q' + omega^2 q = phi_e^T p(t) - phi_x^T f,   x = phi_x q + R_xe p(t) - R_xx f,   f = law(x, sliders)

Newmark's average acceleration for the modes; the residual flexibility is massless and answers at once. Both together
give x = x* - A f at the end of a step, solved with the law by Newton's method: the law is piecewise linear, so that
this ends exactly, after a few iterations.
"""

from dataclasses import dataclass, replace
from functools import cached_property
from typing import Any, NamedTuple

import numpy as np


class Box(NamedTuple):
    """Two Jenkins elements of equal stiffness and a unilateral normal spring, (n,) each; forces less the preload n0."""

    mu: np.ndarray
    kt: np.ndarray
    kn: np.ndarray
    n0: np.ndarray

    def step(self, u, slider):
        """u (n, 3), slider (n, 2): force (n, 3), slider moved on, tangents (n, 3, 3) by u and (n, 2) by the slider."""
        normal = np.maximum(self.n0 + self.kn * u[:, 2], 0.0)
        limit, kt = (self.mu * normal)[:, None], self.kt[:, None]
        trial = kt * (u[:, :2] - slider)
        sticks, closed = np.abs(trial) <= limit, normal > 0
        force = np.where(sticks, trial, np.sign(trial) * limit)
        tangent = np.zeros((len(u), 3, 3))
        tangent[:, (0, 1), (0, 1)] = np.where(sticks, kt, 0.0)
        tangent[:, :2, 2] = np.where(sticks, 0.0, np.sign(trial) * (self.mu * self.kn * closed)[:, None])
        tangent[:, 2, 2] = self.kn * closed
        return np.column_stack([force, normal - self.n0]), u[:, :2] - force / kt, tangent, np.where(sticks, -kt, 0.0)

    def along(self, motion):
        """Sliders (n, 2) after the samples (n_time, n, 3) have been passed through twice, from zero."""
        slider = np.zeros((len(self.kt), 2))
        for u in (*motion, *motion):
            slider = self.step(u, slider)[1]
        return slider


class State(NamedTuple):
    """q, v, a: (m, ...) of the modes; slider: (n, 2, ...). Further axes are derivatives.

    x: (3 n,) relative displacements: no state, but where Newton's method starts from in the next step
    """

    q: np.ndarray
    v: np.ndarray
    a: np.ndarray
    slider: np.ndarray
    x: np.ndarray | None = None


@dataclass(frozen=True, eq=False)
class March:
    """Under load * cos(w t) on one `row` of the model, another one `observed`, in `steps` equal steps a period.

    model: omega_squared, phi, residual, viscous and n_relative of a LinearModel are used
    """

    model: Any
    law: Box
    row: int
    observed: int
    load: float
    w: float
    steps: int

    @property
    def h(self):
        """The period over the steps, longer by (w h)^2 / 12 ("prewarped"): so the rule is exact for linear motion at w,
        and a resonance as narrow as 0.4 Hz is not shifted; higher harmonics keep their error of (k w h)^2 / 12.
        """
        return 2 / self.w * np.tan(np.pi / self.steps)

    @cached_property
    def step_matrices(self):
        """What q, v, a and the load at the end give to q at the end of a step, if no contact presses."""
        one, C, h = np.eye(len(self.model.omega_squared)), self.model.viscous, self.h
        S = np.linalg.inv(4 / h**2 * one + 2 / h * C + np.diag(self.model.omega_squared))
        return S @ (4 / h**2 * one + 2 / h * C), S @ (4 / h * one + C), S, self.load * (S @ self.model.phi[self.row])

    @cached_property
    def phi(self):
        return self.model.phi[: self.model.n_relative]

    @cached_property
    def compliance(self):
        """A: of the contacts within a step. (3 n, 3 n)"""
        n = self.model.n_relative
        return self.phi @ self.step_matrices[2] @ self.phi.T + self.model.residual[:n, :n]

    @cached_property
    def stuck(self):
        """Stiffness of the contacts, and (1 + A K)^-1 and (1 + A K)^-1 A: with f = K x + g, x = B0 x* - B g."""
        stiffness = np.column_stack([self.law.kt, self.law.kt, self.law.kn]).ravel()
        B0 = np.linalg.inv(np.eye(len(stiffness)) + self.compliance * stiffness)
        return stiffness, B0, B0 @ self.compliance

    def period(self, state, derivative=None):
        """State one period later, its derivatives, displacement (steps,) of the observed row and its derivatives."""
        displacement = np.empty(self.steps)
        slopes = None if derivative is None else np.empty((self.steps, derivative.q.shape[1]))
        modes, n = self.model.phi[self.observed], self.model.n_relative
        static, by_load = self.model.residual[self.observed, :n], self.model.residual[self.observed, self.row]
        for i in range(1, self.steps + 1):
            cosine, place = np.cos(2 * np.pi * i / self.steps), i % self.steps
            state, derivative, force, by_force = self._step(state, derivative, cosine)
            displacement[place] = modes @ state.q + by_load * self.load * cosine - static @ force
            if slopes is not None:
                slopes[place] = modes @ derivative.q - static @ by_force
        return state, derivative, displacement, slopes

    def _step(self, old, derivative, cosine):
        by_q, by_v, by_a, by_load = self.step_matrices
        free = by_q @ old.q + by_v @ old.v + by_a @ old.a + cosine * by_load
        x_star = self.phi @ free + cosine * self.load * self.model.residual[: self.model.n_relative, self.row]
        x, (force, slider, tangent, by_slider) = self._contacts(x_star, old.x, old.slider)
        force = force.ravel()
        new = self._end(old, free - by_a @ (self.phi.T @ force), slider)._replace(x=x)
        if derivative is None:
            return new, None, force, None
        derivative, by_force = self._differentiated(derivative, tangent, by_slider)
        return new, derivative, force, by_force

    def _end(self, old, q, slider):
        a = 4 / self.h**2 * (q - old.q) - 4 / self.h * old.v - old.a
        return State(q, old.v + self.h / 2 * (old.a + a), a, slider)

    def _contacts(self, x_star, x, slider):
        """x = x* - A f(x) within a step, and the law there; only contacts that slip or open enter the matrix."""
        stiffness, B0, B = self.stuck
        small, start = 1e-12 * (self.law.n0 / self.law.kn).max(), B0 @ x_star

        def residual(x):
            result = self.law.step(x.reshape(-1, 3), slider)
            return x - start + B @ (result[0].ravel() - stiffness * x), result

        x = start if x is None else x
        r, result = residual(x)
        for _ in range(60):
            if np.abs(r).max() <= small + 1e-12 * np.abs(x).max():
                return x, result
            move, part = self._newton_step(r, result[2]), 1.0
            ahead, there = residual(x + move)
            while np.linalg.norm(ahead) > np.linalg.norm(r) and part > 1 / 64:
                part /= 2
                ahead, there = residual(x + part * move)
            x, r, result = x + part * move, ahead, there
        raise AssertionError(f"no equilibrium of the contacts, {np.abs(r).max():.1e} m left")

    def _newton_step(self, r, tangent):
        stiffness, _, B = self.stuck
        T = tangent.copy()
        T[:, range(3), range(3)] -= stiffness.reshape(-1, 3)
        active = np.flatnonzero(T.any(axis=(1, 2)))
        if not len(active):
            return -r
        rows = (3 * active[:, None] + np.arange(3)).ravel()
        BT = _times_blocks(B[:, rows], T[active])
        return BT @ np.linalg.solve(np.eye(len(rows)) + BT[rows], r[rows]) - r

    def _differentiated(self, d, tangent, by_slider):
        """Derivatives (..., k) of one step, and of the forces at its end."""
        n, k, (by_q, by_v, by_a, _) = len(tangent), d.q.shape[1], self.step_matrices
        free = by_q @ d.q + by_v @ d.v + by_a @ d.a
        pull = np.zeros((n, 3, k))
        pull[:, :2] = by_slider[:, :, None] * d.slider
        right = self.phi @ free - self.compliance @ pull.reshape(3 * n, k)
        x = np.linalg.solve(np.eye(3 * n) + _times_blocks(self.compliance, tangent), right).reshape(n, 3, k)
        force = tangent @ x + pull
        q = free - by_a @ (self.phi.T @ force.reshape(3 * n, k))
        slider = x[:, :2] - force[:, :2] / self.law.kt[:, None, None]
        return self._end(d, q, slider), force.reshape(3 * n, k)


def _times_blocks(matrix, blocks):
    """(r, 3 n) times the block diagonal matrix of (n, 3, 3)."""
    n = len(blocks)
    return (matrix.reshape(-1, n, 3).transpose(1, 0, 2) @ blocks).transpose(1, 0, 2).reshape(-1, 3 * n)


class Plane(NamedTuple):
    """Across a curve at its point: Re(conj(along) (X - amplitude)) / |amplitude|^2 + rate (W / w - 1) = 0 for X at W.

    With along = 0 the frequency is held.
    """

    amplitude: complex
    w: float
    along: complex = 0.0
    rate: float = 1.0

    def value(self, X, w):
        return self.slope(X - self.amplitude) + self.rate * (w / self.w - 1)

    def slope(self, dX):
        return np.real(np.conj(self.along) * dX) / np.abs(self.amplitude) ** 2


@dataclass(frozen=True, eq=False)
class Periodic:
    """state: at t = 0; w: where it was found; samples: (steps,) of the observed row over the period
    misfit: largest change of the modal state over a period, relative
    multipliers: of modes and of the sliders that move, falling size: below 1 the motion attracts
    periods: marched
    """

    state: State
    w: float
    samples: np.ndarray
    misfit: float
    multipliers: np.ndarray
    periods: int

    @property
    def amplitude(self):
        return first_harmonic(self.samples)


def first_harmonic(samples):
    n = len(samples)
    return 2 / n * np.exp(-2j * np.pi * np.arange(n) / n) @ samples


def shoot(march, start, plane, tolerance=1e-8, most=40):
    """The periodic motion on the plane, by Newton's method on the map of a period with exact derivatives.

    A slider that does not move within the period stays where it is: any place near is as periodic. Derivatives are
    renewed where they no longer serve.
    """
    state, inverse, last = start, None, np.inf
    for periods in range(1, most + 1):
        derivative = _identity(state, march.w) if inverse is None else None
        after, derivative, samples, slopes = march.period(state, derivative)
        z = _packed(state, march.w)
        change, m = _packed(after, march.w) - z, 3 * len(state.q)
        misfit = np.abs(change[:m]).max() / np.abs(z[:m]).max()
        off = plane.value(first_harmonic(samples), march.w)
        if max(misfit, abs(off)) < tolerance:
            return Periodic(state, march.w, samples, misfit, _multipliers(march, state), periods)
        if derivative is not None:
            free, inverse = _newton_matrix(march, state, after, plane, derivative, samples, slopes)
        elif max(misfit, abs(off)) > 0.5 * last:
            inverse, last = None, np.inf
            continue
        last = max(misfit, abs(off))
        move = inverse @ np.append(change[free], off)
        z[free] += move[:-1]
        z[~free] += change[~free]
        state = _unpacked(z, march.w, state)
        march = replace(march, w=march.w * (1 + move[-1]))
    raise AssertionError(f"no periodic motion in {most} periods: misfit {misfit:.1e} at {march.w / 2 / np.pi:.3f} Hz")


def _newton_matrix(march, state, after, plane, derivative, samples, slopes, small=1e-7):
    """Which entries of the state count, and the inverse for them and ln w; that by w is a difference."""
    other = replace(march, w=march.w * (1 + small))
    shifted, _, moved, _ = other.period(state)
    by_w = (_packed(shifted, march.w) - _packed(after, march.w)) / small
    X_by_w = (first_harmonic(moved) - first_harmonic(samples)) / small
    system = np.eye(len(by_w)) - _packed(derivative, march.w)
    free = np.abs(system).max(axis=1) > 1e-9
    last = -np.append(plane.slope(first_harmonic(slopes[:, free])), plane.slope(X_by_w) + plane.rate)
    matrix = np.vstack([np.column_stack([system[np.ix_(free, free)], -by_w[free]]), last])
    return free, np.linalg.inv(matrix)


def _multipliers(march, state):
    _, derivative, _, _ = march.period(state, _identity(state, march.w))
    map_ = _packed(derivative, march.w)
    free = np.abs(map_ - np.eye(len(map_))).max(axis=1) > 1e-9
    values = np.linalg.eigvals(map_[np.ix_(free, free)])
    return values[np.argsort(-np.abs(values))]


def _packed(s, w):
    """One vector (or matrix of derivatives) in which displacement, velocity and acceleration count alike."""
    return np.concatenate([s.q, s.v / w, s.a / w**2, s.slider.reshape(-1, *s.slider.shape[2:])])


def _unpacked(z, w, like):
    m = len(like.q)
    rest = z[3 * m :]
    slider = rest.reshape(len(rest) // 2, 2, *z.shape[1:])
    return State(z[:m], z[m : 2 * m] * w, z[2 * m : 3 * m] * w**2, slider, like.x)


def _identity(state, w):
    return _unpacked(np.eye(3 * len(state.q) + state.slider.size), w, state)
