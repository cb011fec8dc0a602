"""Forces of all patches over a settled period, marched sample by sample, with exact derivatives.

Each patch: a unilateral normal spring with preload, and in t1 and t2 a Jenkins element (or a bundle of them) whose
limit is mu N of the moment. The sliders start at rest and are marched through two periods; the second counts. A slider
stands where it last slipped, so its derivatives are those of that sample, and nothing else has to be remembered.

With an exponent m both stiffnesses grow with the momentary normal force as (N / N_m)^m: integrated, N^(1 - m) is linear
in the displacement; tangentially the force is the momentary stiffness times the extension of the spring.

What is returned is the departure from the springs at rest, zero for a patch (m = 0) that sticks and stays closed.
"""

import numpy as np
from numba import njit
from numpy.typing import NDArray

from updamp.benchmarks.virtual_rig.bench import Patches

# Harmonics on the samples of a period.


class Basis:
    """x(t_i) = sum_c values[i, c] x_c, the coefficients being Re X_k and Im X_k of Re sum_k X_k exp(i k w t): those of
    k = 1, 2, ... and last, where it is among them, the mean.

    values, rates: (n_time, n_c), rates to be multiplied by w; analysis: (n_c, n_time)
    """

    def __init__(self, harmonics: int, mean: bool, n_time: int) -> None:
        orders = np.arange(1, harmonics + 1)
        angle = 2 * np.pi * np.arange(n_time)[:, None] * orders / n_time
        values, rates = np.empty((n_time, 2 * harmonics + mean)), np.zeros((n_time, 2 * harmonics + mean))
        values[:, 0 : 2 * harmonics : 2], values[:, 1 : 2 * harmonics : 2] = np.cos(angle), -np.sin(angle)
        rates[:, 0 : 2 * harmonics : 2] = -orders * np.sin(angle)
        rates[:, 1 : 2 * harmonics : 2] = -orders * np.cos(angle)
        weight = np.full(2 * harmonics + mean, 2.0 / n_time)
        if mean:
            values[:, -1], weight[-1] = 1.0, 1.0 / n_time
        self.harmonics, self.mean, self.n_time = harmonics, mean, n_time
        self.values, self.rates = values, rates
        self.analysis = np.ascontiguousarray(weight[:, None] * values.T)

    @property
    def size(self) -> int:
        return int(self.values.shape[1])


Floats = NDArray[np.float64]
# Equal Jenkins elements in a patch whose slip limits are spread.
BUNDLE = 10


def departures(x: Floats, w: float, basis: Basis, p: Patches) -> tuple[Floats, Floats]:
    """x: (n, 3, n_c) coefficients of the relative displacement [m]

    returns: coefficients of force less spring (n, 3, n_c) [N], and derivatives (n, 3 n_c, 3 n_c) [N/m]
    """
    n, _, n_c = x.shape
    value, tangent = np.zeros((n, 3, n_c)), np.zeros((n, 3 * n_c, 3 * n_c))
    limits = np.ones(1) if p.spread == 0 else 1 + p.spread * ((2 * np.arange(BUNDLE) + 1) / BUNDLE - 1)
    law = (p.mu, p.kt, p.kn, p.n0, p.gap, p.viscosity, p.at_rest, p.n0 if p.stated_at is None else p.stated_at)
    _all(
        np.ascontiguousarray(x), w, basis.values, basis.rates, basis.analysis, *law,
        p.exponent, p.speed_drop, p.speed_scale, limits, value, tangent,
    )  # fmt: skip
    return value, tangent


@njit(cache=True)
def _all(x, w, b, rate, a, mu, kt, kn, n0, gap, viscosity, rest_k, stated_at, m, drop, scale, limits, value, tangent):
    n, _, n_c = x.shape
    n_time = len(b)
    u, v = np.empty((3, n_time)), np.zeros((3, n_time))
    force, friction = np.empty(n_time), np.empty(n_time)
    normal, normal_by_u, stiff, stiff_by_u = np.empty(n_time), np.empty(n_time), np.empty(n_time), np.zeros(n_time)
    friction_by_v = np.zeros((2, n_time))
    moving = drop != 0.0
    for i in range(n):
        for d in range(3):
            u[d] = b @ x[i, d]
            if moving or viscosity[i] != 0.0:
                v[d] = w * (rate @ x[i, d])
        rest = _springs(n0[i], kt[i], kn[i], gap[i], m, stated_at[i], u[2], normal, normal_by_u, stiff, stiff_by_u)
        closed, loosest = True, np.inf
        for t in range(n_time):
            friction[t] = mu[i]
            if moving:
                speed = np.sqrt(v[0, t] ** 2 + v[1, t] ** 2)
                friction[t] = mu[i] * (1.0 - drop * speed / (speed + scale))
                by_speed = -mu[i] * drop * scale / (speed + scale) ** 2 / max(speed, 1e-30)
                friction_by_v[0, t], friction_by_v[1, t] = by_speed * v[0, t], by_speed * v[1, t]
            closed = closed and normal[t] > 0.0
            loosest = min(loosest, friction[t] * normal[t])
        if m != 0.0 or not closed or rest == 0.0:
            _normal(i, n_c, rest_k[i, 2], rest, u[2], normal, normal_by_u, b, a, force, value, tangent)
        for d in range(2):
            most = 0.0
            for t in range(n_time):
                most = max(most, abs(u[d, t]))
            for s in range(len(limits)):
                if m != 0.0 or kt[i] * most > limits[s] * loosest:
                    _slides(
                        i, d, n_c, 1.0 / len(limits), limits[s], rest_k[i, d], u[d], normal, normal_by_u, stiff,
                        stiff_by_u, friction, friction_by_v, moving, w, b, rate, a, force, value, tangent,
                    )  # fmt: skip
        if viscosity[i] != 0.0:
            _film(i, n_c, viscosity[i], v, normal, w, rate, a, value, tangent)


@njit(cache=True)
def _springs(n0, kt, kn, gap, m, stated_at, u, normal, normal_by_u, stiff, stiff_by_u):
    """Normal force and tangential stiffness at every sample with derivatives; returns the normal force at rest."""
    if m == 0.0:
        for t in range(len(u)):
            normal[t] = max(n0 + kn * (u[t] - gap), 0.0)
            normal_by_u[t] = kn if normal[t] > 0.0 else 0.0
            stiff[t], stiff_by_u[t] = kt, 0.0
        return max(n0 - kn * gap, 0.0)
    straight, slope = n0 ** (1 - m), (1 - m) * kn * stated_at**-m
    for t in range(len(u)):
        root = max(straight + slope * (u[t] - gap), 0.0)
        normal[t] = root ** (1 / (1 - m))
        share = (normal[t] / stated_at) ** m
        normal_by_u[t] = kn * share
        stiff[t] = kt * share
        stiff_by_u[t] = m * kt * kn * share * share / normal[t] if normal[t] > 0.0 else 0.0
    return max(straight - slope * gap, 0.0) ** (1 / (1 - m))


@njit(cache=True)
def _normal(i, n_c, k, rest, u, normal, by_u, b, a, force, value, tangent):
    rows = np.empty((len(u), n_c))  # derivatives of the force at each sample
    for t in range(len(u)):
        force[t] = normal[t] - rest - k * u[t]
        for c in range(n_c):
            rows[t, c] = (by_u[t] - k) * b[t, c]
    value[i, 2] += a @ force
    tangent[i, 2 * n_c :, 2 * n_c :] += a @ rows


@njit(cache=True)
def _slides(
    i, d, n_c, share, limit, k, u, normal, normal_by_u, stiff, stiff_by_u, friction, by_v, moving, w, b, rate, a,
    force, value, tangent,
):  # fmt: skip
    """A Jenkins element in direction d with `share` of the stiffness and `limit` times the mean limit: all of these
    have the same reach mu N / kt but for that factor. k: stiffness at rest, of all of them.

    The slider stands at u - side * reach of the sample where it last slipped: the force is differentiated there too.
    """
    n_time, slider, last, side = len(u), 0.0, -1, 0.0
    by_own, by_normal = np.empty((n_time, n_c)), np.empty((n_time, n_c))  # derivatives of the force at each sample
    by_speed = np.zeros((2, n_time if moving else 1, n_c))
    for passing in range(2):
        for t in range(n_time):
            reach = limit * friction[t] * normal[t] / stiff[t] if normal[t] > 0.0 else 0.0
            if abs(u[t] - slider) > reach:
                side = 1.0 if u[t] > slider else -1.0
                slider, last = u[t] - side * reach, t
                reach_by_n = 0.0
                if normal[t] > 0.0:
                    by_n = normal_by_u[t] - normal[t] * stiff_by_u[t] / stiff[t]
                    reach_by_n = limit * friction[t] * by_n / stiff[t]
            if passing:
                force[t] = share * (stiff[t] * (u[t] - slider) - k * u[t])
                by_u, by_n = share * (stiff[t] - k), share * stiff_by_u[t] * (u[t] - slider)
                by_place = share * stiff[t]
                for c in range(n_c):
                    by_own[t, c], by_normal[t, c] = by_u * b[t, c], by_n * b[t, c]
                if last >= 0:
                    by_reach = by_place * side * reach_by_n
                    for c in range(n_c):
                        by_own[t, c] -= by_place * b[last, c]
                        by_normal[t, c] += by_reach * b[last, c]
                    if moving and normal[last] > 0.0:
                        for s in range(2):
                            change = by_place * side * limit * normal[last] / stiff[last] * by_v[s, last] * w
                            for c in range(n_c):
                                by_speed[s, t, c] = change * rate[last, c]
    value[i, d] += a @ force
    own = slice(d * n_c, (d + 1) * n_c)
    tangent[i, own, own] += a @ by_own
    tangent[i, own, 2 * n_c :] += a @ by_normal
    if moving:
        for s in range(2):
            tangent[i, own, s * n_c : (s + 1) * n_c] += a @ by_speed[s]


@njit(cache=True)
def _film(i, n_c, viscosity, v, normal, w, rate, a, value, tangent):
    rows = np.empty((len(normal), n_c))
    for t in range(len(normal)):
        for c in range(n_c):
            rows[t, c] = viscosity * w * rate[t, c] if normal[t] > 0.0 else 0.0
    by_rate = a @ rows
    for d in range(3):
        own = slice(d * n_c, (d + 1) * n_c)
        value[i, d] += a @ (np.where(normal > 0.0, viscosity, 0.0) * v[d])
        tangent[i, own, own] += by_rate
