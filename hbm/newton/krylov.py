"""GMRES (Saad and Schultz 1986) for a few dozen iterations on a few thousand unknowns.

The basis is orthogonalised by two passes of classical Gram-Schmidt, as products with the whole basis: at this size
scipy's vector by vector orthogonalisation takes as long as the operator itself.
"""

import math
from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

Floats = NDArray[np.float64]


@dataclass(frozen=True, eq=False)
class KrylovSolution:
    """value: (n,); iterations taken; converged: whether the residual fell below the tolerance"""

    value: Floats
    iterations: int
    converged: bool


def gmres(
    operator: Callable[[Floats], Floats], right: Floats, start: Floats | None, tolerance: float, iterations: int
) -> KrylovSolution:
    """Solve operator(x) = right, without restart.

    right: (n,); start: (n,) first guess or None; tolerance: of the residual relative to right
    """
    x = np.zeros_like(right) if start is None else start
    r = right if start is None else right - operator(start)
    size, wanted = _length(r), tolerance * _length(right)
    if size <= wanted:
        return KrylovSolution(x, 0, True)
    V = np.empty((iterations + 1, len(right)))
    R, g = np.zeros((iterations, iterations)), np.zeros(iterations + 1)
    rotations: list[tuple[float, float]] = []
    V[0], g[0], k = r / size, size, 0
    while k < iterations:
        w = operator(V[k])
        h = V[: k + 1] @ w
        w = w - h @ V[: k + 1]
        again = V[: k + 1] @ w
        w -= again @ V[: k + 1]
        below = _norm(w)
        column = [*(h + again).tolist(), below]  # numbers, not entries of an array, which take much longer one by one
        for i, (c, s) in enumerate(rotations):
            column[i], column[i + 1] = c * column[i] + s * column[i + 1], c * column[i + 1] - s * column[i]
        length = math.hypot(column[k], column[k + 1])
        if length == 0.0 or not math.isfinite(length):
            break
        c, s = column[k] / length, column[k + 1] / length
        rotations.append((c, s))
        R[:k, k], R[k, k] = column[:k], length
        g[k], g[k + 1] = c * g[k], -s * g[k]
        k += 1
        if abs(g[k]) <= wanted or below == 0.0:
            break
        V[k] = w / below
    y = np.linalg.solve(R[:k, :k], g[:k]) if k else np.zeros(0)
    return KrylovSolution(x + y @ V[:k], k, abs(float(g[k])) <= wanted)


def _norm(vector: Floats) -> float:
    return math.sqrt(float(vector @ vector))


def _length(vector: Floats) -> float:
    """However small its entries are: squares of 1e-170 are none. In units of a power of two, which rounds nothing."""
    exponent = math.frexp(float(np.abs(vector).max(initial=0.0)))[1]
    return math.ldexp(_norm(np.ldexp(vector, -exponent)), exponent)
