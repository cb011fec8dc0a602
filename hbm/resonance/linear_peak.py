"""Where following a resonance begins: at the peak of the response at forces so small that nothing slips or opens."""

from collections.abc import Callable

import numpy as np
from numpy.typing import NDArray
from scipy.optimize import minimize_scalar

from updamp.hbm.problem.linear_model import LinearModel, is_symmetric
from updamp.hbm.problem.mirror import AGREEMENT
from updamp.hbm.problem.small_amplitude import SmallAmplitude, element_stiffness, modes_on, response_on
from updamp.hbm.resonance.resonance import ResonanceProblem, ResonanceState

Complex = NDArray[np.complex128]

# Places within a half-power width at which a maximum is looked for: one place from its top a peak is 0.8 % lower.
_A_WIDTH = 16


def linear_peak(
    problem: ResonanceProblem, window: tuple[float, float], log_force: float, mode_frequency: float | None = None
) -> ResonanceState:
    """The linear response at its resonance in `window` [Hz]. Contacts that are open at rest stay so at small forces.
    Of several maxima around the mode, as of two that overlap, one inside the window is taken, if there is one.

    mode_frequency: [Hz], the mode next to it is taken, at the maximum next to that; by default the one that responds
        most, at the largest
    raises: ValueError where no mode that is driven and seen lies in the window, the mode is not damped, or damping is
        not symmetric
    """
    _refuse_gyroscopic(problem.system.free)
    system, n = problem.system, problem.system.free.n_relative
    near = float(np.mean(window))
    stiffness = element_stiffness(system.groups, n, near)
    modes = modes_on(system.free, stiffness, 2 * np.pi * near)
    asked_for = _modes_asked_for(problem, modes, window, mode_frequency)

    def response(w: float) -> Complex:
        return response_on(system.free, stiffness, w, problem.excited)

    def size(w: float) -> float:
        return float(abs(response(w)[problem.observed]))

    mode = max(asked_for, key=lambda i: size(2 * np.pi * float(modes.frequencies[i])))
    middle = 2 * np.pi * float(modes.frequencies[mode])
    width = middle * max(modes.loss_factor(mode), 1e-6)  # between the half-power points
    bounds = (middle - 2 * width, middle + 2 * width)
    low, high = (2 * np.pi * float(end) for end in window)
    tops = _maxima(size, (max(bounds[0], low), min(bounds[1], high)), width / _A_WIDTH, middle)
    if not tops:
        w = _largest(size, bounds, middle)
    elif mode_frequency is None:
        w = max(tops, key=size)
    else:
        w = min(tops, key=lambda top: abs(top - middle))
    at_peak = response(w)
    z = np.zeros((n, system.harmonics.n_coefficients))
    system.harmonics.set_amplitude(z, 1, at_peak[:n])
    return ResonanceState(z, w, log_force, float(np.angle(at_peak[problem.observed])))


def _largest(size: Callable[[float], float], bounds: tuple[float, float], middle: float) -> float:
    """[rad/s]"""
    return float(minimize_scalar(lambda w: -size(w), bounds=bounds, options={"xatol": 1e-9 * middle}).x)


def _maxima(size: Callable[[float], float], bounds: tuple[float, float], apart: float, middle: float) -> list[float]:
    """All between two smaller ones, their places refined; none where it only rises or falls towards an end. All of them
    [rad/s]."""
    places = np.linspace(*bounds, max(3, 1 + int(np.ceil((bounds[1] - bounds[0]) / apart))))
    sizes = np.array([size(float(w)) for w in places])
    tops = 1 + np.flatnonzero((sizes[1:-1] > sizes[:-2]) & (sizes[1:-1] >= sizes[2:]))
    return [_largest(size, (float(places[top - 1]), float(places[top + 1])), middle) for top in tops]


def _refuse_gyroscopic(free: LinearModel) -> None:
    """What is followed rests on an undamped motion that all parts go through in phase, and that symmetric damping alone
    hardly changes."""
    if not (is_symmetric(free.viscous) and is_symmetric(free.hysteretic)):
        raise ValueError(
            "the damping matrix is not symmetric (gyroscopic terms): a resonance cannot be followed in the force; "
            "trace the response curve at each force, which can be"
        )


def _modes_asked_for(
    problem: ResonanceProblem, modes: SmallAmplitude, window: tuple[float, float], mode_frequency: float | None
) -> list[int]:
    """Numbers of the modes in the window that the force drives and the point shows, or of the one next to a frequency
    [Hz]."""
    there = _moves(modes, problem.excited) & _moves(modes, problem.observed)
    inside = np.flatnonzero(there & _within(modes, window)).tolist()
    if not inside:
        raise ValueError(_no_mode(problem, modes, window))
    if mode_frequency is not None:
        inside = [min(inside, key=lambda i: abs(modes.frequencies[i] - mode_frequency))]
    for undamped in (i for i in inside if not modes.loss_factor(i) > np.finfo(float).eps):
        raise ValueError(
            f"the mode at {modes.frequencies[undamped]:.6g} Hz has no damping at forces so small that nothing slips or "
            "opens: its resonance has no height to begin at; give the structure some"
        )
    return inside


def _within(modes: SmallAmplitude, window: tuple[float, float]) -> NDArray[np.bool_]:
    return np.asarray((window[0] <= modes.frequencies) & (modes.frequencies <= window[1]))


def _moves(modes: SmallAmplitude, row: int) -> NDArray[np.bool_]:
    """(k,) whether each mode moves a row, but for what mirror images differ by."""
    size = np.abs(modes.shapes[row])
    return np.asarray(size > AGREEMENT * size.max())


def _no_mode(problem: ResonanceProblem, modes: SmallAmplitude, window: tuple[float, float]) -> str:
    """Which modes lie in the window and why none of them resonates; that there are none; which ones do."""
    said = f"between {window[0]:g} and {window[1]:g} Hz at forces so small that nothing slips or opens"
    seen = modes.frequencies[_moves(modes, problem.excited) & _moves(modes, problem.observed)]
    lowest = f"the lowest that are driven and seen are at {', '.join(f'{f:.4g}' for f in seen[:6])} Hz"
    every, further = _of_the_whole(problem, modes, float(np.mean(window)))
    driven, inside = _moves(every, problem.excited + further), _within(every, window)
    still = (
        ("not driven from where the force acts", every.frequencies[inside & ~driven]),
        ("driven and not seen at the point that is followed", every.frequencies[inside & driven]),
    )
    found = [f"{', '.join(f'{f:.4g}' for f in at)} Hz {why}" for why, at in still if len(at)]
    if not found:
        return f"no mode {said}: widen the window, or give another; {lowest}"
    return (
        f"no mode that is driven and seen {said}; there are modes at {', and at '.join(found)} (in a mode that is "
        "antisymmetric about the middle the middle stands still): choose another point, or another window; "
        f"{lowest}"
    )


def _of_the_whole(problem: ResonanceProblem, modes: SmallAmplitude, near: float) -> tuple[SmallAmplitude, int]:
    """Modes of all motions, not only those that the force drives, and how many rows further on their points are."""
    if problem.whole is None:
        return modes, 0
    free = problem.whole.free
    stiffness = element_stiffness(problem.whole.groups, free.n_relative, near)
    return modes_on(free, stiffness, 2 * np.pi * near), free.n_relative - problem.system.free.n_relative
