"""Fourier conventions, defined once.

x(t) = X0 + sum_k Xc_k cos(k w t) + Xs_k sin(k w t), coefficients ordered [0, c1, s1, c2, s2, ...] along the last
axis, for the harmonics in use only; complex amplitude X_k = Xc_k - i Xs_k.
"""

from collections.abc import Callable
from dataclasses import dataclass
from functools import cached_property
from typing import Any

import numpy as np
from numpy.typing import NDArray

Floats = NDArray[np.float64]
Complex = NDArray[np.complex128]


def whole_number(value: Any) -> int | None:
    """As which a number is meant, 64.0 as 64; None where it is no whole number"""
    whole = isinstance(value, int | np.integer) or (isinstance(value, float | np.floating) and value.is_integer())
    return int(value) if whole else None


@dataclass(frozen=True)
class Harmonics:
    """The harmonics kept, ascending, such as (0, 1, 2, 3); any sequence of whole numbers becomes a tuple of integers.

    raises: ValueError where orders are not ascending non-negative integers with the first harmonic among them
    """

    orders: tuple[int, ...]

    def __post_init__(self) -> None:
        given = list(self.orders) if np.iterable(self.orders) else [self.orders]
        orders = tuple(k for each in given if (k := whole_number(each)) is not None)
        ascending = list(orders) == sorted(set(orders)) and np.iterable(self.orders)
        if len(orders) < len(given) or not ascending or min(orders, default=-1) < 0 or 1 not in orders:
            raise ValueError(
                f"harmonics = {given}: give ascending non-negative integers with 1 among them, such as [0, 1, 2, 3]"
            )
        object.__setattr__(self, "orders", orders)

    @cached_property
    def n_coefficients(self) -> int:
        return sum(1 if k == 0 else 2 for k in self.orders)

    @cached_property
    def slices(self) -> dict[int, slice]:
        """Where each harmonic's coefficients stand: one place for 0, (cos, sin) for the others."""
        places, start = {}, 0
        for k in self.orders:
            width = 1 if k == 0 else 2
            places[k] = slice(start, start + width)
            start += width
        return places

    def among(self, wider: "Harmonics", values: Floats) -> Floats:
        """(..., n_coefficients) of these harmonics as those of wider ones, which have all of them: nothing of the
        others."""
        found = np.zeros((*values.shape[:-1], wider.n_coefficients))
        for k, place in self.slices.items():
            found[..., wider.slices[k]] = values[..., place]
        return found

    def phase(self, n_time: int) -> Floats:
        """(n_time,) equidistant w t over one period, starting at 0."""
        return 2 * np.pi * np.arange(n_time) / n_time

    def synthesis(self, n_time: int) -> Floats:
        """(n_time, n_coefficients): samples = synthesis @ coefficients."""
        return self._basis(n_time, lambda k, p: (np.cos(k * p), np.sin(k * p)))

    def synthesis_rate(self, n_time: int) -> Floats:
        """(n_time, n_coefficients): d/d(w t) of the samples; times w it gives the velocity."""
        return self._basis(n_time, lambda k, p: (-k * np.sin(k * p), k * np.cos(k * p)))

    def analysis(self, n_time: int) -> Floats:
        """(n_coefficients, n_time): coefficients = analysis @ samples (discrete Fourier transform).

        raises: ValueError where n_time cannot resolve the highest harmonic
        """
        self.refuse_too_few(n_time)
        transform = 2.0 / n_time * self.synthesis(n_time).T
        if 0 in self.orders:
            transform[0] /= 2
        return transform

    def refuse_too_few(self, n_time: int) -> None:
        """raises: ValueError where n_time samples cannot resolve the highest harmonic"""
        if n_time <= 2 * self.orders[-1]:
            raise ValueError(
                f"time_samples = {n_time}: harmonic {self.orders[-1]} needs more than {2 * self.orders[-1]}"
            )

    def _basis(self, n_time: int, cos_and_sin: Callable[[int, Floats], tuple[Floats, Floats]]) -> Floats:
        phase = self.phase(n_time)
        basis = np.zeros((n_time, self.n_coefficients))
        for k, place in self.slices.items():
            pair = cos_and_sin(k, phase)
            basis[:, place] = np.stack(pair if k else pair[:1], axis=1)
        return basis

    def amplitude(self, coefficients: Floats, k: int) -> Complex:
        """Complex amplitude X_k = Xc_k - i Xs_k; (..., n_coefficients) -> (...)."""
        part = coefficients[..., self.slices[k]]
        cosine = part[..., 0].astype(np.complex128)
        return cosine if k == 0 else cosine - 1j * part[..., 1]

    def set_amplitude(self, coefficients: Floats, k: int, amplitude: Complex) -> None:
        """Write X_k into `coefficients` in place; the imaginary part of harmonic 0 is not representable."""
        part = coefficients[..., self.slices[k]]
        part[..., 0] = amplitude.real
        if k:
            part[..., 1] = -amplitude.imag

    def change_to(self, other: "Harmonics", coefficients: Floats) -> Floats:
        """The same motion in other harmonics: missing ones are dropped, new ones are zero."""
        changed = np.zeros((*coefficients.shape[:-1], other.n_coefficients))
        for k in set(self.orders) & set(other.orders):
            changed[..., other.slices[k]] = coefficients[..., self.slices[k]]
        return changed
