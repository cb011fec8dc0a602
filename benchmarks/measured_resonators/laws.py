"""What a resonator's motion meets besides its linear spring, mass and loss, as complex stiffness.

Written from the literature, without updamp's laws. All take amplitudes a (n,) [m] and an angular frequency w [rad/s] of
x = a cos(w t) and return F / x of the force's first harmonic [N/m]: nothing else is seen where a resonance is narrow.
"""

from collections.abc import Callable
from dataclasses import dataclass
from functools import partial

import numpy as np
from numpy.typing import NDArray

Floats = NDArray[np.float64]
Complex = NDArray[np.complex128]
Law = Callable[[Floats, float], Complex]
# Places of a period at which forces without a closed form are taken.
_PLACES = 800


def cubic(k3: float, a: Floats, _w: float) -> Complex:
    """F = k3 x^3"""
    return np.asarray(0.75 * k3 * a**2, dtype=complex)


def quintic(k5: float, a: Floats, _w: float) -> Complex:
    """F = k5 x^5"""
    return np.asarray(0.625 * k5 * a**4, dtype=complex)


def square(k2: float, a: Floats, _w: float) -> Complex:
    """F = k2 |x| x"""
    return np.asarray(8 / (3 * np.pi) * k2 * a, dtype=complex)


def clearance(k: float, gap: float, a: Floats, _w: float) -> Complex:
    """F = k (x - gap) beyond the gap, k (x + gap) beyond it the other way"""
    t = np.arccos(np.minimum(1.0, gap / a))
    return np.asarray(2 / np.pi * k * (t - np.sin(t) * np.cos(t)), dtype=complex)


def saturating(k: float, reach: float, a: Floats, _w: float) -> Complex:
    """F = k (reach tanh(x / reach) - x): a spring that holds only so much, less its stiffness at rest"""
    x = a[:, None] * np.cos(np.pi * (np.arange(_PLACES) + 0.5) / _PLACES)
    force = k * (reach * np.tanh(x / reach) - x)
    return np.asarray(2 * np.mean(force * x, axis=1) / a**2, dtype=complex)


def quadratic_damping(c: float, a: Floats, w: float) -> Complex:
    """F = c |v| v"""
    return 1j * w * 8 / (3 * np.pi) * c * a * w


def coulomb(force: float, a: Floats, _w: float) -> Complex:
    """F = force sign(v)"""
    return 1j * 4 * force / (np.pi * a)


def fading_dashpot(c: float, at: float, a: Floats, w: float) -> Complex:
    """A dashpot whose equivalent value falls with the velocity's amplitude: c / (1 + (a w / at)^2)"""
    return 1j * w * c / (1 + (a * w / at) ** 2)


def threshold(c: float, beyond: float, a: Floats, w: float) -> Complex:
    """F = c v max(0, 1 - beyond / |x|)"""
    phase = 2 * np.pi * (np.arange(_PLACES) + 0.5) / _PLACES
    x, v = a[:, None] * np.cos(phase), -w * a[:, None] * np.sin(phase)
    force = c * v * np.maximum(0.0, 1 - beyond / np.abs(x))
    return -2j * np.mean(force * np.sin(phase), axis=1) / a


def microslip(r: float, chi: float, a: Floats, _w: float) -> Complex:
    """Masing's loop of the backbone -r x^(2 + chi) / ((1 + chi) (2 + chi)), which is Iwan's model with a density
    r x^chi of slip displacements (D. J. Segalman, J. Appl. Mech. 72 (2005) 752), less its stiffness at rest."""
    phase = np.pi * (np.arange(_PLACES) + 0.5) / _PLACES
    x = a[:, None] * np.cos(phase)

    def backbone(u: Floats) -> Floats:
        return -r * u ** (2 + chi) / ((1 + chi) * (2 + chi))

    force = backbone(a)[:, None] - 2 * backbone((a[:, None] - x) / 2)  # from a to -a; the way back mirrors it
    return 2 * np.mean(force * np.exp(-1j * phase), axis=1) / a


@dataclass(frozen=True)
class Scale:
    """What a law is sized by. width: stiffness times loss factor [N/m]; w: of the resonance [rad/s]; amplitude: the
    largest of the test [m]; least: its lowest force [N]"""

    width: float
    w: float
    amplitude: float
    least: float


# Draws a law: at the largest amplitude it shifts the resonance by some widths, or adds a share to the loss.
Drawn = Callable[[np.random.Generator, Scale], Law]


def _sign(rng: np.random.Generator) -> float:
    return float(rng.choice([-1.0, 1.0]))


def _widths(rng: np.random.Generator) -> float:
    return float(np.exp(rng.uniform(np.log(0.4), np.log(3.0))))


def _share(rng: np.random.Generator) -> float:
    return float(np.exp(rng.uniform(np.log(0.25), np.log(1.2))))


def draw_cubic(rng: np.random.Generator, s: Scale) -> Law:
    return partial(cubic, _sign(rng) * _widths(rng) * s.width / (0.75 * s.amplitude**2))


def draw_quintic(rng: np.random.Generator, s: Scale) -> Law:
    return partial(quintic, _sign(rng) * _widths(rng) * s.width / (0.625 * s.amplitude**4))


def draw_square(rng: np.random.Generator, s: Scale) -> Law:
    return partial(square, _sign(rng) * _widths(rng) * s.width / (8 / (3 * np.pi) * s.amplitude))


def draw_clearance(rng: np.random.Generator, s: Scale) -> Law:
    """Met, or opening, from a third to two thirds of the largest amplitude on."""
    gap = float(rng.uniform(0.33, 0.67)) * s.amplitude
    unit = clearance(1.0, gap, np.array([s.amplitude]), s.w)[0].real
    return partial(clearance, _sign(rng) * _widths(rng) * s.width / float(unit), gap)


def draw_saturating(rng: np.random.Generator, s: Scale) -> Law:
    reach = float(rng.uniform(0.3, 1.0)) * s.amplitude
    unit = -saturating(1.0, reach, np.array([s.amplitude]), s.w)[0].real
    return partial(saturating, _widths(rng) * s.width / float(unit), reach)


def draw_quadratic(rng: np.random.Generator, s: Scale) -> Law:
    return partial(quadratic_damping, _share(rng) * s.width / s.w**2 / (8 / (3 * np.pi)) / s.amplitude)


def draw_microslip(rng: np.random.Generator, s: Scale) -> Law:
    chi = float(rng.uniform(-0.8, -0.1))
    unit = microslip(1.0, chi, np.array([s.amplitude]), s.w)[0]
    return partial(microslip, _share(rng) * s.width / float(unit.imag), chi)


def draw_coulomb(rng: np.random.Generator, s: Scale) -> Law:
    """It takes a share of the lowest force."""
    return partial(coulomb, float(rng.uniform(0.1, 0.5)) * s.least * np.pi / 4)


def draw_fading(rng: np.random.Generator, s: Scale) -> Law:
    return partial(fading_dashpot, _share(rng) * s.width / s.w, float(rng.uniform(0.2, 0.6)) * s.amplitude * s.w)


def draw_threshold(rng: np.random.Generator, s: Scale) -> Law:
    return partial(threshold, 2 * _share(rng) * s.width / s.w, float(rng.uniform(0.25, 0.6)) * s.amplitude)


@dataclass(frozen=True)
class Kind:
    """called: in the catalogue, "" where it has no name for it"""

    draw: Drawn
    called: str


LAWS: dict[str, Kind] = {
    "cubic": Kind(draw_cubic, "joint_cubic"),
    "quadratic": Kind(draw_quadratic, "joint_quadratic"),
    "microslip": Kind(draw_microslip, "joint_microslip"),
    "coulomb": Kind(draw_coulomb, "joint_friction"),
    "fading": Kind(draw_fading, ""),
    "threshold": Kind(draw_threshold, ""),
    "quintic": Kind(draw_quintic, "joint_quintic"),
    "clearance": Kind(draw_clearance, "joint_clearance"),
    "square": Kind(draw_square, "joint_square"),
    "saturating": Kind(draw_saturating, ""),
}
