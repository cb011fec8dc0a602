"""Modes of a test at forces so small that no contact slips or opens further: what a low-force sweep shows.

Every element answers a displacement of a picometre with its complex stiffness K(w): closed contacts with their springs,
open ones with nothing, a film with its dashpot too. As Woodbury's formula has it (linear_model.add_springs), the modes
are those of omega^2 + i (hysteretic + w viscous) + phi^T W phi with W = (1 + K R)^-1 K, found at their own frequency.
"""

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np
import scipy.linalg
from numpy.typing import NDArray

from updamp.effects.rig_model import RigModel
from updamp.hbm.harmonics import Harmonics
from updamp.hbm.problem.elements import ElementGroup, force_only
from updamp.hbm.problem.linear_model import LinearModel
from updamp.hbm.problem.structural_changes import attach

Floats = NDArray[np.float64]
Complex = NDArray[np.complex128]

_SMALL = 1e-12  # m
_FIRST, _SAMPLES = Harmonics((1,)), 16
_ROUND_OFF = 1e-9  # of an element's stiffness
_ROUNDS = 2  # of the frequency that dashpots act at


@dataclass(frozen=True, eq=False)
class SmallAmplitude:
    """Complex modes at one frequency.

    squared: (k,) of the angular frequency, rising real part, imaginary part from damping [rad^2/s^2]
    shapes: (n_rows, k) of the linear model's rows, squares of the modal coordinates adding up to 1 [kg^-1/2]
    """

    free: LinearModel
    squared: Complex
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

    def peak(self, point: str, excitation: str, mode: int) -> float:
        """Receptance at the mode's resonance, of the mode alone [m/N]"""
        return abs(self.at(point, mode) * self.at(excitation, mode)) / float(self.squared[mode].imag)


def small_amplitude(model: RigModel, near: float) -> SmallAmplitude:
    """near: frequency [Hz] that dashpots and films are taken at"""
    free = model.system.free
    return _modes(free, element_stiffness(model.groups, free.n_relative, near), 2 * np.pi * near)


def settled(
    model: RigModel, choose: Mapping[str, float], place: Callable[[SmallAmplitude], Mapping[str, int]]
) -> dict[str, tuple[SmallAmplitude, int]]:
    """Each mode at its own frequency: name -> solution and number of the mode in it.

    choose: name -> frequency to begin with [Hz]; place: numbers of the modes in a solution. Springs keep their
    stiffness and dashpots grow with frequency: the elements are asked once.
    """
    free, first = model.system.free, min(choose.values())
    K = element_stiffness(model.groups, free.n_relative, first)
    found = _modes(free, K, 2 * np.pi * first)
    if not (np.any(K.imag) or np.any(free.viscous)):
        return {name: (found, i) for name, i in place(found).items() if name in choose}
    each = {}
    for name in choose:
        at = found
        for _ in range(_ROUNDS):
            f = float(at.frequencies[place(at)[name]])
            at = _modes(free, K.real + 1j * K.imag * f / first, 2 * np.pi * f)
        each[name] = at, place(at)[name]
    return each


def without_contacts(model: RigModel, component: str, number: int = 0) -> float:
    """Frequency [Hz] of one component alone, with what is attached to it and to nothing else.

    number: of its modes, 0 for the first; raises: IndexError for one beyond those kept
    """
    own = [a for a in model.attachments if all(p.startswith(f"{component}.") for p in a.points)]
    on = np.array(model.owner) == component
    c = model.components
    alone = LinearModel(
        c.omega_squared[on], c.phi[:, on], c.residual, c.hysteretic[np.ix_(on, on)], c.viscous[np.ix_(on, on)],
        c.n_relative, c.points,
    )  # fmt: skip
    return float(attach(alone, own).frequencies[number])


def linear_up_to(model: RigModel, found: SmallAmplitude, mode: int) -> float:
    """Force [N] at which the first closed contact slips or opens at the mode's resonance, by the linear response.

    Read off the inner friction law: tangential springs against mu N0 in each direction, the normal spring against N0.
    raises: ValueError where the model has no contacts
    """
    if model.contacts is None:
        raise ValueError("this model has no contacts that could slip")
    p, rows = model.contacts.parameters, np.asarray(model.contacts.rows)
    K = element_stiffness((model.contacts,), found.free.n_relative, float(found.frequencies[mode]))
    shape, drive = found.shapes[:, mode], abs(found.at(model.excitation, mode)) / float(found.squared[mode].imag)
    force = np.abs(K @ shape[: found.free.n_relative]) * drive  # per N
    closed = np.asarray(p.n0) - np.asarray(p.kn) * np.asarray(p.gap) > 0
    limit = np.stack([np.asarray(p.mu) * p.n0, np.asarray(p.mu) * p.n0, np.asarray(p.n0)], axis=1)[closed]
    return float(np.min(limit / np.maximum(force[rows[closed]], np.finfo(float).tiny)))


def _modes(free: LinearModel, K: Complex, w: float) -> SmallAmplitude:
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
    return SmallAmplitude(free, squared, (free.phi - R @ WP) @ X)


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
