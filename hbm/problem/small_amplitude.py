"""The linear structure at forces so small that no contact slips or opens further: what a low-force sweep shows.

Every element answers a displacement of a picometre with its complex stiffness K(w): closed contacts with their springs,
open ones with nothing, a film with its dashpot too. As Woodbury's formula has it (linear_model.add_springs), the modes
are those of omega^2 + i (hysteretic + w viscous) + phi^T W phi with W = (1 + K R)^-1 K, found at their own frequency.
"""

from dataclasses import dataclass
from typing import Any

import numpy as np
import scipy.linalg
from numpy.typing import NDArray

from updamp.hbm.harmonics import Harmonics
from updamp.hbm.problem.elements import ElementGroup, element_forces, force_only
from updamp.hbm.problem.linear_model import LinearModel
from updamp.hbm.problem.system import NonlinearSystem

Floats = NDArray[np.float64]
Complex = NDArray[np.complex128]

_SMALL = 1e-12  # m
_FIRST, _SAMPLES = Harmonics((1,)), 16
_ROUND_OFF = 1e-9  # of an element's stiffness


@dataclass(frozen=True, eq=False)
class SmallAmplitude:
    """Complex modes at one frequency.

    squared: (k,) of the angular frequency, rising real part, imaginary part from damping [rad^2/s^2]
    coordinates: (k, k) of each in the modes of the linear model, squares adding up to 1
    shapes: (n_rows, k) of the linear model's rows [kg^-1/2]
    """

    free: LinearModel
    squared: Complex
    coordinates: Complex
    shapes: Complex

    @property
    def frequencies(self) -> Floats:
        """(k,) where the displacement peaks [Hz]"""
        return np.sqrt(np.maximum(self.squared.real, 0.0)) / (2 * np.pi)

    def loss_factor(self, mode: int) -> float:
        return float(self.squared[mode].imag / self.squared[mode].real)

    def at(self, point: str, mode: int) -> complex:
        """Displacement of a named point in the mode."""
        return complex(self.shapes[self.free.row(point), mode])

    def motion(self, mode: int, excited: int, w: float) -> Complex:
        """(n_rows,) displacement of the mode alone under a unit force on one row [m/N]; w: [rad/s]"""
        return np.asarray(self.shapes[:, mode] * self.shapes[excited, mode] / (self.squared[mode] - w**2))

    def peak(self, point: str, excitation: str, mode: int) -> float:
        """Receptance at the mode's resonance, of the mode alone [m/N]"""
        return abs(self.at(point, mode) * self.at(excitation, mode)) / float(self.squared[mode].imag)


def modes_on(free: LinearModel, K: Complex, w: float) -> SmallAmplitude:
    """The modes of a structure on elements of a stiffness (n, n), as `element_stiffness` gives it; w: [rad/s]"""
    acting = np.flatnonzero(np.abs(K).sum(axis=0))
    S: NDArray[Any] = K[np.ix_(acting, acting)]
    S = S if np.any(S.imag) else S.real
    P, R = free.phi[acting], free.residual[:, acting]
    WP = np.linalg.solve(np.eye(len(acting)) + S @ R[acting], S @ P)
    A = np.diag(free.omega_squared) + 1j * (free.hysteretic + w * free.viscous) + P.T @ WP
    squared, X = scipy.linalg.eig((A + A.T) / 2)
    order = np.argsort(squared.real)
    squared, X = squared[order], X[:, order]
    X = X / np.sqrt(np.einsum("ik,ik->k", X, X))
    return SmallAmplitude(free, squared, X, (free.phi - R @ WP) @ X)


def response_on(free: LinearModel, K: Complex, w: float, excited: int) -> Complex:
    """(n_rows,) displacement under a unit force on one row, on elements of a stiffness (n, n) [m/N]; w: [rad/s]"""
    acting = np.flatnonzero(np.abs(K).sum(axis=0))
    G = free.receptance(w, slice(free.n_rows), np.append(acting, excited))
    on, direct, S = G[:, :-1], G[:, -1], K[np.ix_(acting, acting)]
    force = S @ np.linalg.solve(np.eye(len(acting)) + on[acting] @ S, direct[acting])
    return np.asarray(direct - on @ force)


def element_stiffness(groups: tuple[ElementGroup, ...], n: int, near: float) -> Complex:
    """(n, n) complex, force over displacement of the relative rows at a vanishing amplitude [N/m]; near [Hz]"""
    K = np.zeros((n, n), complex)
    for group in groups:
        directions = group.rows.shape[1]
        for d in range(directions):
            x = np.zeros((*group.rows.shape, _FIRST.n_coefficients))
            _FIRST.set_amplitude(x[:, d], 1, np.full(len(group.rows), _SMALL, complex))
            force = force_only(group, x, 2 * np.pi * near, _FIRST, _SAMPLES)
            for i in range(directions):
                K[group.rows[:, i], group.rows[:, d]] = _FIRST.amplitude(force[:, i], 1) / _SMALL
    least = _ROUND_OFF * np.abs(K).max(initial=0.0)
    K = np.where(np.abs(K.real) > least, K.real, 0.0) + 1j * np.where(np.abs(K.imag) > least, K.imag, 0.0)
    return np.asarray((K + K.T) / 2)


def stiffness_about(system: NonlinearSystem, x: Floats, w: float) -> Complex:
    """(n, n) complex, as `element_stiffness`, of a small vibration on top of a motion with its frequency: the part of
    the tangents' first harmonic that turns with the phase. What the vibration's phase against the motion's adds is left
    out: of a cubic spring half as much to either side.

    x: (n_relative, n_coefficients) of the motion [m]; w [rad/s]
    """
    harmonics, n = system.harmonics, system.free.n_relative
    first, K = harmonics.slices[1], np.zeros((n, n), complex)
    for group in system.groups:
        tangent = element_forces(group, x[group.rows], w, harmonics, system.time_samples).tangent
        (cc, cs), (sc, ss) = np.moveaxis(tangent[:, :, first, :, first], (2, 4), (0, 1))
        of_each = (cc + ss) / 2 + 1j * (cs - sc) / 2
        np.add.at(K, (group.rows[:, :, None], group.rows[:, None, :]), of_each)
    return np.asarray((K + K.T) / 2)
