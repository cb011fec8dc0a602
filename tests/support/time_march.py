"""A periodic solution by marching in time, sharing no code with the harmonic balance: a check on it.

Newmark's average acceleration; the contact law is written out a second time, with the slider as a state.
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


def march(M, C, K, Q, p, load, w, q, v, slider, periods, steps):
    """Newmark for M q'' + C q' + K q + Q^T f(Q q) = load cos(w t): samples of q over the last period."""
    h = 2 * np.pi / (w * steps)
    n = Q.shape[0] // 3
    force, _, _ = box_step((Q @ q).reshape(n, 3), slider, p)
    a = np.linalg.solve(M, load - C @ v - K @ q - Q.T @ force.ravel())
    history = np.zeros((steps, len(q)))
    for i in range(periods * steps):
        history[i % steps] = q
        t = (i + 1) * h
        q_new = q + h * v + h**2 / 2 * a
        for _ in range(30):
            a_new = 4 / h**2 * (q_new - q - h * v) - a
            v_new = v + h / 2 * (a + a_new)
            force, next_slider, tangent = box_step((Q @ q_new).reshape(n, 3), slider, p)
            r = M @ a_new + C @ v_new + K @ q_new + Q.T @ force.ravel() - load * np.cos(w * t)
            if np.abs(r).max() < 1e-9 * np.abs(load).max():
                break
            blocks = Q.reshape(n, 3, -1)
            S = 4 / h**2 * M + 2 / h * C + K + np.einsum("iam,iab,ibn->mn", blocks, tangent, blocks)
            q_new = q_new - np.linalg.solve(S, r)
        else:
            raise AssertionError(f"step {i}: no equilibrium, residual {np.abs(r).max():.1e}")
        q, v, a, slider = q_new, v_new, a_new, next_slider
    return history
