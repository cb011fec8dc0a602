"""Harmonics on the samples of a period."""

import numpy as np


class Basis:
    """x(t_i) = sum_c values[i, c] x_c, the coefficients being Re X_k and Im X_k of Re sum_k X_k exp(i k w t): those of
    k = 1, 2, ... and last, where it is among them, the mean.

    values, rates: (n_time, n_c), rates to be multiplied by w; analysis: (n_c, n_time)
    """

    def __init__(self, harmonics: int, mean: bool, n_time: int) -> None:
        orders = np.arange(1, harmonics + 1)
        angle = 2 * np.pi * np.arange(n_time)[:, None] * orders / n_time
        values, rates = np.empty((n_time, 2 * harmonics + mean)), np.zeros((n_time, 2 * harmonics + mean))
        values[:, 0 : 2 * harmonics : 2], values[:, 1 : 2 * harmonics : 2] = np.cos(angle), -np.sin(angle)
        rates[:, 0 : 2 * harmonics : 2] = -orders * np.sin(angle)
        rates[:, 1 : 2 * harmonics : 2] = -orders * np.cos(angle)
        weight = np.full(2 * harmonics + mean, 2.0 / n_time)
        if mean:
            values[:, -1], weight[-1] = 1.0, 1.0 / n_time
        self.harmonics, self.mean, self.n_time = harmonics, mean, n_time
        self.values, self.rates = values, rates
        self.analysis = np.ascontiguousarray(weight[:, None] * values.T)

    @property
    def size(self) -> int:
        return int(self.values.shape[1])
