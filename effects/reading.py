"""What is read of a motion: where the measurement is at fault, something else than the motion.

    y = (1 + gain) exp(-i (lag + 2 pi f delay)) exp(trend s) exp(-compression |x|^2) x + background F
    at the frequency f exp(drift s)

x the displacement at the frequency f, F the force, s from 0 at the start of a sweep to 1 at its end.
"""

from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

Floats = NDArray[np.float64]
Complex = NDArray[np.complex128]


@dataclass(frozen=True, eq=False)
class SweepPlace:
    """Where in a sweep a motion is met. share: (...) of the sweep that is done; angular: (...) frequency [rad/s]"""

    share: Floats
    angular: Floats


@dataclass(frozen=True)
class Reading:
    """Of all sensors alike. factor: on the displacement; trend: of the logarithm of the amplitude over a sweep;
    delay: by which it lags [s]
    background: proportional to the force [m/N]; compression: of it by the square of the amplitude [1/m^2]
    drift: of the logarithm of the frequency at which a motion is met, over a sweep
    """

    factor: complex = 1.0 + 0j
    trend: float = 0.0
    delay: float = 0.0
    background: complex = 0j
    compression: float = 0.0
    drift: float = 0.0

    def turned(self, factor: complex) -> "Reading":
        """With a further factor on what it reads of the displacement."""
        return replace(self, factor=self.factor * factor)

    def of(self, displacement: Complex, at: SweepPlace, force: float) -> Complex:
        """(..., n_sensors) from displacements like it [m]; force [N]"""
        return self.compressed(displacement) * self.by_displacement(at) + self.background * force

    def compressed(self, displacement: Complex) -> Complex:
        """(..., n_sensors)"""
        return np.asarray(displacement * np.exp(-self.compression * np.abs(displacement) ** 2))

    def compressed_change(self, displacement: Complex, change: Complex) -> Complex:
        """(..., n_sensors) to first order, of changes of the displacement."""
        grown = 2 * np.real(np.conj(displacement) * change)
        share = np.exp(-self.compression * np.abs(displacement) ** 2)
        return np.asarray(share * (change - self.compression * displacement * grown))

    def difference(self, other: "Reading", displacement: Complex, at: SweepPlace, force: float) -> Complex:
        """(..., n_sensors) from what this one reads to what another one nearby does, to first order: a lag has none in
        the amplitude."""
        logarithm = np.log(other.factor / self.factor) + (other.trend - self.trend) * at.share
        logarithm = logarithm - 1j * (other.delay - self.delay) * at.angular
        further = (other.compression - self.compression) * np.abs(displacement) ** 2
        read = self.compressed(displacement) * self.by_displacement(at) * (np.asarray(logarithm)[..., None] - further)
        return np.asarray(read + (other.background - self.background) * force)

    def by_displacement(self, at: SweepPlace) -> Complex:
        """(..., 1)"""
        return np.asarray(self.factor * np.exp(self.trend * at.share - 1j * self.delay * at.angular))[..., None]

    def by_log_frequency(self, at: SweepPlace, share_by_log_f: float) -> Complex:
        """(..., 1) derivative of that factor's logarithm by the logarithm of the frequency."""
        return np.asarray(self.trend * share_by_log_f - 1j * self.delay * at.angular)[..., None]
