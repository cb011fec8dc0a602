"""Response curves that look like those of a rig with a softening damper, without solving anything."""

import numpy as np

from updamp.hbm.continuation.response_curve import ResponseCurve
from updamp.hbm.harmonics import Harmonics

POINTS = (
    "blade_left.tip.x",
    "blade_right.tip.x",
    "damper.corner_left.x",
    "damper.corner_left.y",
    "damper.corner_right.x",
    "damper.corner_right.y",
)
# Damper in the modes: it translates along x, or it rolls (bottom corners in antiphase).
SHAPES = {"OOP": (-1.0, 1.0, 0.3, 0.05, 0.3, -0.05), "IP": (1.0, 1.0, 0.1, 0.2, 0.1, -0.2)}


def softening_curve(
    mode: str = "IP",
    force: float = 1.0,
    softening: float = 0.0,
    centre: float = 420.0,
    n: int = 201,
    n_contacts: int = 4,
    stopped: str = "",
) -> ResponseCurve:
    """Resonance of width 1 Hz and peak 1e-5 m/N whose frequency falls by `softening` [Hz] up to the peak.

    Parametrised by the phase: a = A sin(theta), f = centre - softening sin^2(theta) - cot(theta) / 2.
    """
    orders = (0, 1, 2, 3)
    harmonics = Harmonics(orders)
    theta = np.linspace(0.06, np.pi - 0.06, n)
    amplitude = 1e-5 * force * np.sin(theta) * np.exp(-1j * theta)
    response = np.zeros((n, len(POINTS), harmonics.n_coefficients))
    for i, share in enumerate(SHAPES[mode]):
        harmonics.set_amplitude(response[:, i], 1, share * amplitude)
        harmonics.set_amplitude(response[:, i], 3, 0.05 * share * amplitude)
    displacement = np.random.default_rng(1).normal(size=(n, 3 * n_contacts, harmonics.n_coefficients)) * 1e-8
    work = np.pi * force * 1e-5 * force * np.sin(theta) ** 2
    return ResponseCurve(
        mode, force, orders, POINTS, centre - softening * np.sin(theta) ** 2 - 0.5 / np.tan(theta),
        displacement, response, work, 0.75 * work, 0.25 * work, np.full(n, 3), np.full(n, 1e-12),
        np.zeros(n, dtype=int), np.zeros(n, dtype=bool), not stopped, stopped, 12.0,
    )  # fmt: skip
