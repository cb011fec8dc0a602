"""Periodic solutions by marching in time, and their Floquet multipliers, sharing no code with the harmonic balance nor
with Hill's method: a check on both.

Newmark's average acceleration; the contact law is written out a second time, with the slider as a state. Many states
are marched at once.
"""

import numpy as np


def box_step(u, slider, p):
    """Force and new slider of the box law: p = (mu, kt, kn, n0) arrays; u (n, 3), slider (n, 2)."""
    mu, kt, kn, n0 = p
    normal = np.maximum(n0 + kn * u[:, 2], 0.0)
    limit = (mu * normal)[:, None]
    trial = kt[:, None] * (u[:, :2] - slider)
    force = np.minimum(np.maximum(trial, -limit), limit)
    stuck = (trial == force) & (normal > 0)[:, None]
    tangent = np.zeros((len(u), 3, 3))
    sign = np.sign(trial)
    for d in range(2):
        tangent[:, d, d] = np.where(stuck[:, d], kt, 0.0)
        tangent[:, d, 2] = np.where(~stuck[:, d] & (normal > 0), sign[:, d] * mu * kn, 0.0)
    tangent[:, 2, 2] = np.where(normal > 0, kn, 0.0)
    return np.column_stack([force, normal - n0]), u[:, :2] - force / kt[:, None], tangent


def one_period(M, C, K, Q, p, load, w, state, steps):
    """One period of M q'' + C q' + K q + Q^T f(Q q) = load cos(w t) from states (b, 2 m + 2 n): displacement, velocity,
    both sliders of n contacts; load: (m,) of all, or (b, m).

    returns: the states after it, and (b, steps, m) samples of q
    """
    b, m, n = len(state), len(M), len(Q) // 3
    every = tuple(np.tile(value, b) for value in p)
    blocks, h = Q.reshape(n, 3, m), 2 * np.pi / (w * steps)
    size = np.abs(load).max(axis=-1, keepdims=True)

    def contact(q, slider):
        force, moved, tangent = box_step((q @ Q.T).reshape(b * n, 3), slider, every)
        stiffness = np.einsum("iam,biac,icn->bmn", blocks, tangent.reshape(b, n, 3, 3), blocks)
        return force.reshape(b, 3 * n) @ Q, moved, stiffness

    q, v, slider = state[:, :m], state[:, m : 2 * m], state[:, 2 * m :].reshape(b * n, 2)
    a = np.linalg.solve(M, (load - v @ C.T - q @ K.T - contact(q, slider)[0]).T).T
    samples = np.zeros((b, steps, m))
    for i in range(steps):
        samples[:, i] = q
        start, q_new = q + h * v + h**2 / 4 * a, q + h * v + h**2 / 2 * a
        for _ in range(30):
            a_new = 4 / h**2 * (q_new - start)
            force, moved, stiffness = contact(q_new, slider)
            v_new = v + h / 2 * (a + a_new)
            r = a_new @ M.T + v_new @ C.T + q_new @ K.T + force - load * np.cos(w * (i + 1) * h)
            if (np.abs(r) < 1e-10 * size).all():
                break
            q_new = q_new - np.linalg.solve(4 / h**2 * M + 2 / h * C + K + stiffness, r[..., None])[..., 0]
        else:
            raise AssertionError(f"step {i}: no equilibrium, residual {np.abs(r).max():.1e}")
        q, v, a, slider = q_new, v_new, a_new, moved
    return np.hstack([q, v, slider.reshape(b, 2 * n)]), samples


def marched_from_rest(M, C, K, Q, p, loads, w, periods, steps):
    """(b, steps, m) samples of q over the last period, under each of the loads (b, m)."""
    state = np.zeros((len(loads), 2 * len(M) + 2 * len(Q) // 3))
    for _ in range(periods):
        state, samples = one_period(M, C, K, Q, p, loads, w, state, steps)
    return samples


def multipliers(M, C, K, Q, p, load, w, state, steps, settle, small):
    """Of the periodic motion near `state` (2 m + 2 n), by differences of size `small` in units of each state's size;
    sorted by falling modulus. Returns them and the settled state."""
    for _ in range(settle):
        state = one_period(M, C, K, Q, p, load, w, state[None], steps)[0][0]
    m, n = len(M), len(Q) // 3
    size = np.abs(state[:m]).max()
    scale = small * np.concatenate([np.full(m, size), np.full(m, w * size), np.full(2 * n, size)])
    pairs = np.concatenate([state + np.diag(scale), state - np.diag(scale)])
    after, _ = one_period(M, C, K, Q, p, load, w, pairs, steps)
    columns = (after[: len(state)] - after[len(state) :]) / (2 * scale[:, None])
    values = np.linalg.eigvals(columns.T)
    return values[np.argsort(-np.abs(values))], state
