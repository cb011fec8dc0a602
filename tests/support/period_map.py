"""Floquet multipliers by shooting: one period marched from many states at once, sharing no code with Hill's method."""

import numpy as np
from support.time_march import box_step


def one_period(M, C, K, Q, p, load, w, state, steps):
    """Newmark (average acceleration) from states (b, 2 m + 2 n): displacement, velocity, both sliders of n contacts."""
    b, m, n = len(state), len(M), len(Q) // 3
    every = tuple(np.tile(value, b) for value in p)
    blocks, h = Q.reshape(n, 3, m), 2 * np.pi / (w * steps)

    def contact(q, slider):
        force, moved, tangent = box_step((q @ Q.T).reshape(b * n, 3), slider, every)
        stiffness = np.einsum("iam,biac,icn->bmn", blocks, tangent.reshape(b, n, 3, 3), blocks)
        return force.reshape(b, 3 * n) @ Q, moved, stiffness

    q, v, slider = state[:, :m], state[:, m : 2 * m], state[:, 2 * m :].reshape(b * n, 2)
    a = np.linalg.solve(M, (load - v @ C.T - q @ K.T - contact(q, slider)[0]).T).T
    for i in range(steps):
        start, q_new = q + h * v + h**2 / 4 * a, q + h * v + h**2 / 2 * a
        for _ in range(30):
            a_new = 4 / h**2 * (q_new - start)
            force, moved, stiffness = contact(q_new, slider)
            v_new = v + h / 2 * (a + a_new)
            r = a_new @ M.T + v_new @ C.T + q_new @ K.T + force - load * np.cos(w * (i + 1) * h)
            if np.abs(r).max() < 1e-10 * np.abs(load).max():
                break
            q_new = q_new - np.linalg.solve(4 / h**2 * M + 2 / h * C + K + stiffness, r[..., None])[..., 0]
        else:
            raise AssertionError(f"step {i}: no equilibrium, residual {np.abs(r).max():.1e}")
        q, v, a, slider = q_new, v_new, a_new, moved
    return np.hstack([q, v, slider.reshape(b, 2 * n)])


def multipliers(M, C, K, Q, p, load, w, state, steps, settle, small):
    """Of the periodic motion near `state` (2 m + 2 n), by differences of size `small` in units of each state's size;
    sorted by falling modulus. Returns them and the settled state."""
    for _ in range(settle):
        state = one_period(M, C, K, Q, p, load, w, state[None], steps)[0]
    m, n = len(M), len(Q) // 3
    size = np.abs(state[:m]).max()
    scale = small * np.concatenate([np.full(m, size), np.full(m, w * size), np.full(2 * n, size)])
    pairs = np.concatenate([state + np.diag(scale), state - np.diag(scale)])
    after = one_period(M, C, K, Q, p, load, w, pairs, steps)
    columns = (after[: len(state)] - after[len(state) :]) / (2 * scale[:, None])
    values = np.linalg.eigvals(columns.T)
    return values[np.argsort(-np.abs(values))], state
