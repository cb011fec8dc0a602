"""The reduced model in time: modes, residual flexibility without mass, contact laws with their sliders as states.

    q'' + C q' + omega^2 q = phi_e^T p(t) - phi_x^T f,   x = phi_x q + R_xe p(t) - R_xx f,   f = law(x, sliders)

Average acceleration (Newmark 1959, J. Eng. Mech. Div. ASCE 85, 67-94: gamma = 1/2, beta = 1/4) for the modes, stable at
any step and without damping of its own; the residual flexibility answers at once. Both give x = x* - A f at the end of
a step (equilibrium.py). Beside the linear model's arrays it shares nothing with the harmonic balance.
"""

from dataclasses import dataclass, replace
from functools import cached_property
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from updamp.hbm.problem.linear_model import LinearModel
from updamp.hbm.problem.system import Excitation, NonlinearSystem
from updamp.hbm.time_marching.contacts import Contacts
from updamp.hbm.time_marching.equilibrium import Equilibrium
from updamp.hbm.time_marching.laws import LawStep

Floats = NDArray[np.float64]

SAMPLES = 512  # of a motion of the harmonic balance, along which sliders are taken


class State(NamedTuple):
    """q, v, a: (m,) of the modes; sliders: of each group (n, s); x: (n_relative,) [m]; dx: what it moved by in the step
    before. The last two are no states, but where Newton's method starts from."""

    q: Floats
    v: Floats
    a: Floats
    sliders: tuple[Floats, ...]
    x: Floats
    dx: Floats


class Period(NamedTuple):
    """state: at its end; samples: (steps,) of the observed row [m]"""

    state: State
    samples: Floats

    @property
    def amplitude(self) -> complex:
        return complex(first_harmonic(self.samples))


def first_harmonic(samples: Floats) -> NDArray[np.complex128]:
    """Complex amplitude (...) of samples (n, ...) over a period, as in hbm/harmonics.py."""
    n = len(samples)
    return np.asarray(2 / n * np.exp(-2j * np.pi * np.arange(n) / n) @ samples)


@dataclass(frozen=True, eq=False)
class March:
    """Under load cos(w t) on one row of the model, another one `observed`, in `steps` equal steps a period.

    model: with viscous damping alone (`viscous_at`); w [rad/s]
    """

    model: LinearModel
    contacts: Contacts
    excitation: Excitation
    observed: int
    w: float
    steps: int

    @staticmethod
    def of(system: NonlinearSystem, excitation: Excitation, observed: int, w: float, steps: int) -> "March":
        """raises: ValueError where a law cannot be marched, with the reason"""
        return March(viscous_at(system.free, w), Contacts.of(system.groups), excitation, observed, w, steps)

    @property
    def h(self) -> float:
        """The period over the steps [s], longer by (w h)^2 / 12 ("prewarped"): so the rule is exact for linear motion
        at w, and a resonance as narrow as 0.4 Hz is not shifted; higher harmonics keep their error of (k w h)^2 / 12.
        """
        return float(2 / self.w * np.tan(np.pi / self.steps))

    @cached_property
    def step_matrices(self) -> tuple[Floats, Floats, Floats, Floats]:
        """What q, v, a and the load at the end give to q at the end of a step, if no contact presses."""
        one, C, h = np.eye(len(self.model.omega_squared)), self.model.viscous, self.h
        S: Floats = np.asarray(
            np.linalg.inv(4 / h**2 * one + 2 / h * C + np.diag(self.model.omega_squared)), np.float64
        )
        load = self.excitation.force * (S @ self.model.phi[self.excitation.row])
        return S @ (4 / h**2 * one + 2 / h * C), S @ (4 / h * one + C), S, load

    @cached_property
    def phi(self) -> Floats:
        """(n_relative, m)"""
        return self.model.phi[: self.model.n_relative]

    @cached_property
    def compliance(self) -> Floats:
        """A: (n_relative, n_relative) of the contacts within a step [m/N]"""
        n = self.model.n_relative
        return np.asarray(self.phi @ self.step_matrices[2] @ self.phi.T + self.model.residual[:n, :n])

    @cached_property
    def equilibrium(self) -> Equilibrium:
        """Its inverse goes with the steps that are taken; what they give does not depend on it."""
        static = abs(self.excitation.force) * np.abs(self.model.residual[:, self.excitation.row]).max()
        moved = abs(self.excitation.force) * np.abs(self.model.phi @ self.step_matrices[3]).max()
        return Equilibrium(self.contacts, self.compliance, 1e-12 * float(max(static, moved)))

    def period(self, state: State) -> Period:
        """raises: MarchError"""
        samples = np.empty(self.steps)
        for i in range(1, self.steps + 1):
            cosine = float(np.cos(2 * np.pi * i / self.steps))
            state, force, _ = self.step(state, cosine)
            samples[i % self.steps] = self.seen(state, force, cosine)
        return Period(state, samples)

    def seen(self, state: State, force: Floats, cosine: float) -> float:
        """Displacement of the observed row [m]"""
        residual, excitation = self.model.residual[self.observed], self.excitation
        static = residual[excitation.row] * excitation.force * cosine - residual[: self.model.n_relative] @ force
        return float(self.model.phi[self.observed] @ state.q + static)

    def step(self, old: State, cosine: float) -> tuple[State, Floats, tuple[LawStep, ...]]:
        """The state at its end, the contacts' forces (n_relative,) [N] and what their laws give there.

        cosine: of w t at its end
        raises: MarchError
        """
        by_q, by_v, by_a, by_load = self.step_matrices
        free = by_q @ old.q + by_v @ old.v + by_a @ old.a + cosine * by_load
        load = cosine * self.excitation.force
        x_star = self.phi @ free + load * self.model.residual[: self.model.n_relative, self.excitation.row]
        x, force, laws = self.equilibrium.solve(x_star, old.x + old.dx, old.sliders)
        q = free - by_a @ (self.phi.T @ force)
        v, a = self.rates(old, q)
        return State(q, v, a, tuple(law.slider for law in laws), x, x - old.x), force, laws

    def rates(self, old: State, q: Floats) -> tuple[Floats, Floats]:
        """Velocity and acceleration at the end of a step that leads to q."""
        a = 4 / self.h**2 * (q - old.q) - 4 / self.h * old.v - old.a
        return old.v + self.h / 2 * (old.a + a), a

    def start(self, system: NonlinearSystem, x: Floats) -> State:
        """The harmonic balance's motion at t = 0; sliders where that motion leaves them that start from rest.

        x: (n_relative, n_coefficients) [m], a solution of `system` at w and the excitation
        """
        harmonics, w, modal = system.harmonics, self.w, self.modal(system, x)
        now, rate = harmonics.synthesis(self.steps)[[0, -1]], w * harmonics.synthesis_rate(self.steps)[0]
        squared = np.repeat(harmonics.orders, [2 if k else 1 for k in harmonics.orders]) ** 2
        sliders = self.contacts.along(harmonics.synthesis(SAMPLES) @ x.T)
        acceleration = -modal @ (w**2 * squared * now[0])
        return State(modal @ now[0], modal @ rate, acceleration, sliders, x @ now[0], x @ (now[0] - now[1]))

    def modal(self, system: NonlinearSystem, x: Floats) -> Floats:
        """(m, n_coefficients) of the modes in a motion of the harmonic balance, as in `start`"""
        harmonics = system.harmonics
        modal = -self.phi.T @ system.element_forces(x, self.w)
        excited = self.excitation.force * self.model.phi[self.excitation.row]
        for k in harmonics.orders:
            load = harmonics.amplitude(modal, k) + excited * (k == 1)
            amplitude = np.linalg.solve(self.model.modal_dynamic_stiffness(k * self.w), load)
            harmonics.set_amplitude(modal, k, amplitude.astype(np.complex128))
        return modal

    def kinetic_energy(self, system: NonlinearSystem, x: Floats) -> float:
        """Largest over a period of that motion [J]"""
        velocity = self.w * self.modal(system, x) @ system.harmonics.synthesis_rate(self.steps).T
        return float((velocity**2).sum(axis=0).max() / 2)


def viscous_at(model: LinearModel, w: float) -> LinearModel:
    """Structural damping as the viscous one that equals it at w: a march knows no other."""
    return replace(model, hysteretic=0 * model.hysteretic, viscous=model.viscous + model.hysteretic / w)
