"""Forces of all patches over a settled period, marched sample by sample, with exact derivatives.

Each patch: a unilateral normal spring with preload, and in t1 and t2 a Jenkins element (or a bundle of them) whose
limit is mu N of the moment. The sliders start at rest and are marched through two periods; the second counts. A slider
stands where it last slipped, so its derivatives are those of that sample, and nothing else has to be remembered.

What is returned is the departure from the springs (kt, kt, kn), zero for a patch that sticks and stays closed.
"""

import numpy as np
from numba import njit
from numpy.typing import NDArray
from virtual_rig.bench import Patches

Floats = NDArray[np.float64]
# Equal Jenkins elements in a patch whose slip limits are spread.
BUNDLE = 10


def departures(x: Floats, w: float, basis: "Basis", p: Patches) -> tuple[Floats, Floats]:
    """x: (n, 3, n_c) coefficients of the relative displacement [m]

    returns: coefficients of force less spring (n, 3, n_c) [N], and derivatives (n, 3 n_c, 3 n_c) [N/m]
    """
    n, _, n_c = x.shape
    value, tangent = np.zeros((n, 3, n_c)), np.zeros((n, 3 * n_c, 3 * n_c))
    limits = np.ones(1) if p.spread == 0 else 1 + p.spread * ((2 * np.arange(BUNDLE) + 1) / BUNDLE - 1)
    _all(
        x, w, basis.values, basis.rates, basis.analysis, p.mu, p.kt, p.kn, p.n0, p.gap, p.viscosity,
        p.speed_drop, p.speed_scale, limits, value, tangent,
    )  # fmt: skip
    return value, tangent


class Basis:
    """Harmonics on a period's samples: x(t_i) = sum_c values[i, c] x_c, the coefficients being Re X_k and Im X_k of
    Re sum_k X_k exp(i k w t), those of all k but 0 first, and the mean last where it is among them.

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
        return self.values.shape[1]


@njit(cache=True)
def _all(x, w, b, rate, a, mu, kt, kn, n0, gap, viscosity, drop, scale, limits, value, tangent):  # type: ignore[no-untyped-def]
    n, _, n_c = x.shape
    n_time = len(b)
    u, v = np.empty((3, n_time)), np.zeros((3, n_time))
    force, normal, friction = np.empty(n_time), np.empty(n_time), np.empty(n_time)
    friction_by_v = np.zeros((2, n_time))
    moving = drop != 0.0
    for i in range(n):
        fast = moving or viscosity[i] != 0.0
        for d in range(3):
            u[d] = b @ x[i, d]
            if fast:
                v[d] = w * (rate @ x[i, d])
        closed, loosest = True, np.inf
        for t in range(n_time):
            normal[t] = n0[i] + kn[i] * (u[2, t] - gap[i])
            if normal[t] <= 0.0:
                normal[t], closed = 0.0, False
            friction[t] = mu[i]
            if moving:
                speed = np.sqrt(v[0, t] ** 2 + v[1, t] ** 2)
                friction[t] = mu[i] * (1.0 - drop * speed / (speed + scale))
                by_speed = -mu[i] * drop * scale / (speed + scale) ** 2 / max(speed, 1e-30)
                friction_by_v[0, t], friction_by_v[1, t] = by_speed * v[0, t], by_speed * v[1, t]
            loosest = min(loosest, friction[t] * normal[t])
        rest = max(n0[i] - kn[i] * gap[i], 0.0)
        if not closed or rest == 0.0:
            _opens(i, n_c, kn[i], rest, u[2], normal, b, a, force, value, tangent)
        for d in range(2):
            most = 0.0
            for t in range(n_time):
                most = max(most, abs(u[d, t]))
            if kt[i] * most > limits[0] * loosest:
                for m in range(len(limits)):
                    _slides(
                        i, d, n_c, kt[i] / len(limits), limits[m] / len(limits), kn[i], u[d], normal, friction,
                        friction_by_v, moving, w, b, rate, a, force, value, tangent,
                    )  # fmt: skip
        if viscosity[i] != 0.0:
            _film(i, n_c, viscosity[i], v, normal, w, rate, a, value, tangent)


@njit(cache=True)
def _opens(i, n_c, kn, rest, u, normal, b, a, force, value, tangent):  # type: ignore[no-untyped-def]
    """Normal force: where it is open, minus the spring."""
    for t in range(len(u)):
        force[t] = normal[t] - rest - kn * u[t]
        if normal[t] == 0.0:
            for c in range(n_c):
                for e in range(n_c):
                    tangent[i, 2 * n_c + c, 2 * n_c + e] -= kn * a[c, t] * b[t, e]
    value[i, 2] += a @ force


@njit(cache=True)
def _slides(i, d, n_c, kt, share, kn, u, normal, friction, by_v, moving, w, b, rate, a, force, value, tangent):  # type: ignore[no-untyped-def]
    """One Jenkins element in direction d, of stiffness kt and limit share * friction * normal."""
    n_time, slider, last, side = len(u), 0.0, -1, 0.0
    for t in range(n_time):
        limit, trial = share * friction[t] * normal[t], kt * (u[t] - slider)
        if abs(trial) > limit:
            side = 1.0 if trial > 0 else -1.0
            slider, last = u[t] - side * limit / kt, t
    stuck_since = np.zeros(n_c)
    for t in range(n_time):
        limit, trial = share * friction[t] * normal[t], kt * (u[t] - slider)
        if abs(trial) > limit:
            if last >= 0:
                _stood(i, d, n_c, kt, share, kn, last, side, stuck_since, normal, friction, by_v, moving, w, b, rate, tangent)
            side = 1.0 if trial > 0 else -1.0
            slider, last = u[t] - side * limit / kt, t
            force[t] = side * limit - kt * u[t]
            stuck_since[:] = 0.0
            _limited(i, d, n_c, share, kn, t, side, a[:, t], normal, friction, by_v, moving, w, b, rate, tangent)
            for c in range(n_c):
                for e in range(n_c):
                    tangent[i, d * n_c + c, d * n_c + e] -= kt * a[c, t] * b[t, e]
        else:
            force[t] = -kt * slider
            stuck_since += a[:, t]
    if last >= 0:
        _stood(i, d, n_c, kt, share, kn, last, side, stuck_since, normal, friction, by_v, moving, w, b, rate, tangent)
    value[i, d] += a @ force


@njit(cache=True)
def _stood(i, d, n_c, kt, share, kn, t, side, weight, normal, friction, by_v, moving, w, b, rate, tangent):  # type: ignore[no-untyped-def]
    """The samples with `weight` stuck where the slider was left at sample t."""
    for c in range(n_c):
        for e in range(n_c):
            tangent[i, d * n_c + c, d * n_c + e] -= kt * weight[c] * b[t, e]
    _limited(i, d, n_c, share, kn, t, side, weight, normal, friction, by_v, moving, w, b, rate, tangent)


@njit(cache=True)
def _limited(i, d, n_c, share, kn, t, side, weight, normal, friction, by_v, moving, w, b, rate, tangent):  # type: ignore[no-untyped-def]
    """The limit of sample t, felt with `weight`."""
    if normal[t] == 0.0:
        return
    by_normal = side * share * friction[t] * kn
    for c in range(n_c):
        for e in range(n_c):
            tangent[i, d * n_c + c, 2 * n_c + e] += by_normal * weight[c] * b[t, e]
    if moving:
        for s in range(2):
            by_speed = side * share * normal[t] * by_v[s, t] * w
            for c in range(n_c):
                for e in range(n_c):
                    tangent[i, d * n_c + c, s * n_c + e] += by_speed * weight[c] * rate[t, e]


@njit(cache=True)
def _film(i, n_c, viscosity, v, normal, w, rate, a, value, tangent):  # type: ignore[no-untyped-def]
    for t in range(len(normal)):
        if normal[t] > 0.0:
            for d in range(3):
                for c in range(n_c):
                    value[i, d, c] += viscosity * a[c, t] * v[d, t]
                    for e in range(n_c):
                        tangent[i, d * n_c + c, d * n_c + e] += viscosity * w * a[c, t] * rate[t, e]
