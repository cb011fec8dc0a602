"""Periodic motion of a marched rig, by shooting with exact derivatives: of one group of box contacts.

A check on the harmonic balance: `hbm/time_marching` shares nothing with it but the linear model's arrays.
"""

from dataclasses import dataclass, replace
from typing import NamedTuple

import numpy as np

from updamp.hbm.time_marching.equilibrium import times_blocks
from updamp.hbm.time_marching.march import State, first_harmonic


class Derivative(NamedTuple):
    """Of a state. q, v, a: (m, k); slider: (n, 2, k)"""

    q: np.ndarray
    v: np.ndarray
    a: np.ndarray
    slider: np.ndarray


def differentiated_period(march, state, derivative):
    """State one period later, its derivatives, displacement (steps,) of the observed row, and its (steps, k)."""
    samples, slopes = np.empty(march.steps), np.empty((march.steps, derivative.q.shape[1]))
    modes, static = march.model.phi[march.observed], march.model.residual[march.observed, : march.model.n_relative]
    for i in range(1, march.steps + 1):
        cosine, place = np.cos(2 * np.pi * i / march.steps), i % march.steps
        state, force, (law,) = march.step(state, cosine)
        derivative, by_force = _differentiated(march, derivative, law)
        samples[place] = march.seen(state, force, cosine)
        slopes[place] = modes @ derivative.q - static @ by_force
    return state, derivative, samples, slopes


def _differentiated(march, d, law):
    """Derivatives (..., k) of one step, and of the forces at its end."""
    (contacts,), (rows,) = march.contacts.laws, march.contacts.rows
    n, k, (by_q, by_v, by_a, _) = len(rows), d.q.shape[1], march.step_matrices
    assert np.array_equal(rows.ravel(), np.arange(3 * n))
    free = by_q @ d.q + by_v @ d.v + by_a @ d.a
    pull = np.zeros((n, 3, k))
    pull[:, :2] = -law.tangent[:, (0, 1), (0, 1), None] * d.slider
    right = march.phi @ free - march.compliance @ pull.reshape(3 * n, k)
    x = np.linalg.solve(np.eye(3 * n) + times_blocks(march.compliance, [law.tangent]), right).reshape(n, 3, k)
    force = law.tangent @ x + pull
    q = free - by_a @ (march.phi.T @ force.reshape(3 * n, k))
    slider = x[:, :2] - force[:, :2] / contacts.kt[:, None, None]
    return Derivative(q, *march.rates(d, q), slider), force.reshape(3 * n, k)


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


def shoot(march, start, plane, tolerance=1e-8, most=40):
    """The periodic motion on the plane, by Newton's method on the map of a period with exact derivatives.

    A slider that does not move within the period stays where it is: any place near is as periodic. Derivatives are
    renewed where they no longer serve.
    """
    state, inverse, last = start, None, np.inf
    for periods in range(1, most + 1):
        derivative = _identity(state, march.w) if inverse is None else None
        if derivative is None:
            (after, samples), slopes = march.period(state), None
        else:
            after, derivative, samples, slopes = differentiated_period(march, state, derivative)
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
    shifted, moved = other.period(state)
    by_w = (_packed(shifted, march.w) - _packed(after, march.w)) / small
    X_by_w = (first_harmonic(moved) - first_harmonic(samples)) / small
    system = np.eye(len(by_w)) - _packed(derivative, march.w)
    free = np.abs(system).max(axis=1) > 1e-9
    last = -np.append(plane.slope(first_harmonic(slopes[:, free])), plane.slope(X_by_w) + plane.rate)
    matrix = np.vstack([np.column_stack([system[np.ix_(free, free)], -by_w[free]]), last])
    return free, np.linalg.inv(matrix)


def _multipliers(march, state):
    _, derivative, _, _ = differentiated_period(march, state, _identity(state, march.w))
    map_ = _packed(derivative, march.w)
    free = np.abs(map_ - np.eye(len(map_))).max(axis=1) > 1e-9
    values = np.linalg.eigvals(map_[np.ix_(free, free)])
    return values[np.argsort(-np.abs(values))]


def _packed(s, w):
    """One vector (or matrix of derivatives) in which displacement, velocity and acceleration count alike."""
    slider = s.slider if isinstance(s, Derivative) else s.sliders[0]
    return np.concatenate([s.q, s.v / w, s.a / w**2, slider.reshape(-1, *slider.shape[2:])])


def _unpacked(z, w, like):
    m = len(like.q)
    rest = z[3 * m :]
    slider = rest.reshape(len(rest) // 2, 2, *z.shape[1:])
    return State(z[:m], z[m : 2 * m] * w, z[2 * m : 3 * m] * w**2, (slider,), like.x, like.dx)


def _identity(state, w):
    one = _unpacked(np.eye(3 * len(state.q) + state.sliders[0].size), w, state)
    return Derivative(one.q, one.v, one.a, one.sliders[0])
