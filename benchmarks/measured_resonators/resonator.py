"""One mode with laws of `laws.py` under a swept sine: its amplitude at every frequency, jumps included."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from updamp.benchmarks.measured_resonators.laws import Complex, Floats, Law

# Amplitudes at which the balance of forces is looked at: its roots lie between two of them.
_TRIED = 4000


@dataclass(frozen=True)
class Resonator:
    """mass [kg], frequency [Hz] and loss: factor, of small motion; laws: what it meets besides"""

    mass: float
    frequency: float
    loss: float
    laws: Sequence[Law]

    @property
    def stiffness(self) -> float:
        return self.mass * (2 * np.pi * self.frequency) ** 2

    def resisting(self, a: Floats, w: float) -> Complex:
        """(n,) F / x [N/m]"""
        linear = self.stiffness * (1 + 1j * self.loss) - self.mass * w**2
        return linear + sum((law(a, w) for law in self.laws), np.zeros(len(a), dtype=complex))

    def peak(self, force: float) -> float:
        """Frequency [Hz] of the resonance: there the loss takes all of the force."""
        w = 2 * np.pi * self.frequency
        a = self._amplitudes(force)
        resisting = self.resisting(a, w)
        top = int(np.argmin(np.abs(resisting.imag * a - force)))
        return float(np.sqrt((resisting.real[top] / self.mass) + w**2) / (2 * np.pi))

    def sweep(self, frequencies: Floats, force: float) -> Complex:
        """(n,) receptance [m/N] in the order in which the frequencies are passed; it stays on its part of the response
        as long as there is one. Of three amplitudes the middle one is unstable."""
        found, last = [], None
        for frequency in frequencies:
            w = 2 * np.pi * frequency
            roots = self._balanced(w, force)
            stable = roots[[0, -1]]
            a = stable[0] if last is None else stable[np.argmin(np.abs(np.log(stable / last)))]
            last = a
            found.append(complex(1 / self.resisting(np.array([a]), w)[0]))
        return np.array(found)

    def _amplitudes(self, force: float) -> Floats:
        largest = 1.6 * force / (self.stiffness * self.loss)
        return np.geomspace(1e-4 * largest, largest, _TRIED)

    def _balanced(self, w: float, force: float) -> Floats:
        """Amplitudes at which the force is what the resonator resists with."""
        a = self._amplitudes(force)
        left = np.abs(self.resisting(a, w)) * a - force
        i = np.flatnonzero(np.sign(left[1:]) != np.sign(left[:-1]))
        return np.asarray(a[i] - left[i] * (a[i + 1] - a[i]) / (left[i + 1] - left[i]))
