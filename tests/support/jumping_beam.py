"""Sweeps of a beam with jumps, by its describing function: first harmonic alone, no code of updamp.

The joint's force at the drive point is k(A) x + i d(A) x at the amplitude A = |x|. Of a cubic spring c u^3 k is
3/4 c A^2, of quadratic damping c |v| v d is 8/(3 pi) c w^2 A (A. H. Nayfeh and D. T. Mook, Nonlinear Oscillations,
1979, ch. 4); of micro-slip that obeys Masing's rule both grow with A^(1+chi) (D. J. Segalman, J. Appl. Mech. 72 (2005)
752).
"""

from collections.abc import Callable
from dataclasses import dataclass
from functools import lru_cache
from types import SimpleNamespace

import numpy as np
from numpy.typing import NDArray
from scipy.interpolate import CubicSpline

from updamp.comparison.prediction.predicted_branch import PredictedBranch
from updamp.comparison.prediction.run_condition import RunCondition
from updamp.hbm.continuation.sweeps import sweep
from updamp.measurement.measurement import Channel, MeasuredRun, Measurement

Floats = NDArray[np.float64]
Complex = NDArray[np.complex128]
POINT = "beam.drive.x"
# At which the stiffness lost is stated [m].
_REFERENCE = 1e-4
_AMPLITUDES = 3000


@dataclass(frozen=True)
class Joint:
    """cubic [N/m^3], quadratic [N s^2/m^2], stiffness lost at 0.1 mm [N/m] with its exponent chi"""

    cubic: float = 0.0
    quadratic: float = 0.0
    lost: float = 0.0
    exponent: float = -0.4

    def stiffness(self, w: float | Floats, size: Floats) -> Complex:
        """(n,) complex, at amplitudes (n,)"""
        slip = self.lost * (size / _REFERENCE) ** (1 + self.exponent) * _of_slip(self.exponent)
        smooth = 0.75 * self.cubic * size**2 + 1j * 8 / (3 * np.pi) * self.quadratic * w**2 * size
        return np.asarray(smooth + slip)


@lru_cache(maxsize=4000)
def _of_slip(exponent: float) -> complex:
    """First harmonic of Masing's loop with the backbone -u^(2+chi), at amplitude 1."""
    angle = (np.arange(4000) + 0.5) * np.pi / 4000
    force = -1 + 2 * ((1 - np.cos(angle)) / 2) ** (2 + exponent)  # on the way back from 1
    return complex(2 * np.mean(force * np.cos(angle)), -2 * np.mean(force * np.sin(angle)))


@dataclass(frozen=True)
class Mode:
    """frequency [Hz], loss factor, modal mass of an oscillator that moves as the drive point does [kg]"""

    frequency: float
    loss_factor: float
    mass: float

    def receptance(self, w: float) -> complex:
        return 1 / (self.mass * ((2 * np.pi * self.frequency) ** 2 * (1 + 1j * self.loss_factor) - w**2))


def swept(modes: tuple[Mode, ...], joint: Joint, frequency: Floats, force: float) -> Complex:
    """(n,) displacement [m] of a slow sweep in the order of the frequencies: it stays on its solution as long as there
    is one near, and jumps to the one that is left."""
    sizes, before = np.geomspace(1e-4, 1.0, _AMPLITUDES) * _largest(modes, force), 0.0
    found = np.empty(len(frequency), dtype=complex)
    for i, f in enumerate(frequency):
        w = 2 * np.pi * f
        dynamic = 1 / sum(mode.receptance(w) for mode in modes)
        size = _nearest_root(lambda a, w=w, z=dynamic: np.abs(z + joint.stiffness(w, a)) * a - force, sizes, before)
        found[i] = force / (dynamic + joint.stiffness(w, np.array([size]))[0])
        before = size
    return found


def _largest(modes: tuple[Mode, ...], force: float) -> float:
    """More than any solution has: that of a tenth of the linear damping."""
    stiff = min(m.mass * (2 * np.pi * m.frequency) ** 2 * m.loss_factor for m in modes)
    return 10 * force / stiff


def _nearest_root(excess, sizes: Floats, before: float) -> float:
    """The stable solution (excess grows there) whose amplitude is nearest to the one before; the smallest at first."""
    values = excess(sizes)
    below = np.flatnonzero((values[:-1] < 0) & (values[1:] >= 0))
    place = below[0] if before == 0 else below[np.argmin(np.abs(np.log(sizes[below] / before)))]
    low, high = sizes[place], sizes[place + 1]
    for _ in range(40):
        middle = (low + high) / 2
        low, high = (middle, high) if excess(np.array([middle]))[0] < 0 else (low, middle)
    return float((low + high) / 2)


def measured(
    modes: tuple[Mode, ...],
    joint: Joint,
    window: tuple[float, float],
    forces: tuple[float, ...],
    upwards: bool,
    points: int,
    noise: float,
    seed: int,
) -> Measurement:
    """One assembly, noise as repeatability."""
    rng, runs = np.random.default_rng(seed), []
    f = np.linspace(*window, points)
    f = f if upwards else f[::-1]
    for force in forces:
        x = swept(modes, joint, f, force)
        x = x * np.exp(noise * (rng.standard_normal(points) + 1j * rng.standard_normal(points)))
        level = np.full(points, force + 0j)
        runs.append(
            MeasuredRun(f"{force:g} N", "first", upwards, "force", force, 1, ("a",), (1,), f, level, x[None, None])
        )
    return Measurement("jumping beam", 0.0, POINT, (Channel("a", POINT),), tuple(runs), repeatability=noise)


def branch(mode: Mode, joint: Joint, condition: RunCondition, u: Floats, places: int) -> PredictedBranch:
    """The whole branch of one mode in closed form, along the phase: what a traced one is compared with, and ten times
    as quick. Without derivatives by the parameters.

    A (K eta + d(A)) = F sin(phase), M w^2 = K + k(A) - F cos(phase) / A
    """
    low, high = (2 * np.pi * f for f in condition.wider)
    stiffness = mode.mass * (2 * np.pi * mode.frequency) ** 2
    phase = np.linspace(0.004, np.pi - 0.004, places)
    w = np.full(places, 2 * np.pi * mode.frequency)
    for _ in range(4):  # the loss depends on the frequency a little
        size = _sizes(lambda a, w=w: a * (stiffness * mode.loss_factor + joint.stiffness(w, a).imag), phase, condition)
        squared = stiffness + joint.stiffness(w, size).real - condition.force * np.cos(phase) / size
        w = np.sqrt(np.maximum(squared, 1.0) / mode.mass)
    inside = np.flatnonzero((w > low) & (w < high))
    kept = slice(max(inside[0] - 1, 0), inside[-1] + 2)
    x = size * np.exp(-1j * phase)
    state = np.column_stack([np.log(w / (2 * np.pi)), x.real, x.imag])[kept]
    state = state if condition.upwards else state[::-1]
    return _as_branch(condition, state, u)


def _sizes(force: Callable[[Floats], Floats], phase: Floats, condition: RunCondition) -> Floats:
    """(n,) at which force(A) is F sin(phase), which grows with A; by bisection."""
    low, high = np.full(len(phase), 1e-9), np.full(len(phase), 1.0)
    for _ in range(45):
        middle = np.sqrt(low * high)
        below = force(middle) < condition.force * np.sin(phase)
        low, high = np.where(below, middle, low), np.where(below, high, middle)
    return np.asarray(low)


def _as_branch(condition: RunCondition, state: Floats, u: Floats) -> PredictedBranch:
    scale = np.hypot(state[:, 1], state[:, 2])[:, None]
    chord = np.hypot(np.diff(state[:, 0]) * 1e3, np.linalg.norm(np.diff(state[:, 1:], axis=0), axis=1) / scale[1:, 0])
    place = np.concatenate([[0.0], np.cumsum(chord)])
    along = CubicSpline(place, state)(place, 1)
    visited = np.zeros(len(state), dtype=bool)
    visited[sweep(np.exp(state[:, 0]), condition.upwards).visited] = True
    points = tuple(SimpleNamespace(after_gap=False) for _ in state)
    slopes = np.zeros((len(state), len(u) + 1, 3))
    nothing = np.zeros((len(state), 0))
    return PredictedBranch(condition, u, points, place, state, along, slopes, (), nothing, visited, "", False)
