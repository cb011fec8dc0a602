"""A measured point expanded through the reduced model: the motion that fits it, and the force that it asks for.

The first harmonics q of the resonant stuck mode, and of those neighbours that the sensors tell from it, are held at
what the sensors show. Everything else follows from the model: the other modes r, and the contacts' relative motion x
with all harmonics. With h the modes held, and the forces p that have to act on them:

    x = phi_x V q + x_ext - G g(x),    V = (1, -Z_rr^-1 Z_rh),    G, x_ext: receptance of the others (Z_rr^-1)
    p = Z_h (q, q_r) - phi_h^T (f_ext - g(x)).

With the resonant mode held nothing is left that resonates or turns back, so Newton's method settles whatever branch
the model itself would be on. q is found along with x by Gauss-Newton on the logarithms of the sensors' amplitudes. If
the model were right, p would be zero. A spring k and a dashpot c on the displacement y at the channel c put the force
-phi_cm (k + i w c) y on the resonant mode m, so that k + i w c = -p_m / (phi_cm y) is what the model lacks.
"""

from dataclasses import dataclass
from functools import cached_property

import numpy as np
import scipy.linalg
from numpy.typing import NDArray

from updamp.diagnosis.missing_force.resonant_mode import ResonantMode
from updamp.hbm.newton.jacobian import factorise
from updamp.hbm.newton.tangent import apply_tangent
from updamp.hbm.problem.modal_algebra import ModalResponse
from updamp.hbm.problem.receptance import Receptance
from updamp.hbm.problem.system import Excitation, NonlinearSystem

Floats = NDArray[np.float64]
Complex = NDArray[np.complex128]
Integers = NDArray[np.int64]

_ITERATIONS = 40
_SETTLED = 1e-8  # relative change of motion
_FARTHEST = 0.3  # relative change of q in a step


@dataclass(frozen=True, eq=False)
class HeldModes(Receptance):
    """The receptance with the first harmonics of some stuck modes held. numbers: of the modes"""

    numbers: tuple[int, ...]

    @cached_property
    def stiffness(self) -> Complex:
        """(m, m) of the stuck modes, at the excitation frequency"""
        return self.system.stuck.modal_dynamic_stiffness(self.w)

    @cached_property
    def of_others(self) -> Complex:
        """(m, m) inverse of the others' stiffness, 0 for those that are held"""
        others = np.delete(np.arange(len(self.stiffness)), self.numbers)
        inverse = np.zeros_like(self.stiffness)
        inverse[np.ix_(others, others)] = scipy.linalg.inv(self.stiffness[np.ix_(others, others)])
        return inverse

    @cached_property
    def moving(self) -> ModalResponse:
        stuck, orders = self.system.stuck, self.moving_orders
        rate = np.asarray(1j * stuck.viscous - 2 * self.w * np.eye(len(self.stiffness)), dtype=np.complex128)
        return _FirstHarmonicHeld(stuck.modal_inverse.at(self.w, orders), orders.index(1), self.of_others, rate)

    @cached_property
    def shapes(self) -> Complex:
        """(m, h) V: modes that move with a unit of each held one, which damping couples them to"""
        shapes = -self.of_others @ self.stiffness[:, self.numbers]
        shapes[self.numbers, np.arange(len(self.numbers))] = 1.0
        return shapes

    def moved(self, rows: slice | Integers, q: Complex) -> Floats:
        """(n_rows, n_coefficients) [m] by the held modes (h,) and what moves with them"""
        motion = self.system.stuck.phi[rows] @ (self.shapes @ q)
        coefficients = np.zeros((len(motion), self.system.harmonics.n_coefficients))
        self.system.harmonics.set_amplitude(coefficients, 1, motion)
        return coefficients

    def force(self, q: Complex, g: Floats, excitation: Excitation | None) -> complex:
        """p [N kg^-1/2] on the first held mode, for the departure g (n_relative, n_coefficients) of the elements;
        linear in everything"""
        stuck, first = self.system.stuck, self.numbers[0]
        loads = -stuck.phi[: stuck.n_relative].T @ self.system.harmonics.amplitude(g, 1)
        if excitation is not None:
            loads = loads + excitation.force * stuck.phi[excitation.row]
        row = self.stiffness[first]
        return complex(row @ (self.shapes @ q) + row @ (self.of_others @ loads) - loads[first])


@dataclass(frozen=True, eq=False)
class _FirstHarmonicHeld:
    """Of the stuck modes, some of whose first harmonics do not answer to loads.

    free: with none held; first: number of the first harmonic; held: (m, m) inverse in its place; stiffness_rate:
    (m, m) derivative by the frequency of what it is the inverse of
    """

    free: ModalResponse
    first: int
    held: Complex
    stiffness_rate: Complex

    def times(self, loads: Complex) -> Complex:
        response = self.free.times(loads)
        response[:, self.first] = np.tensordot(self.held, loads[:, self.first], axes=1)
        return response

    def rate_times(self, loads: Complex) -> Complex:
        response, rate = self.free.rate_times(loads), -self.held @ self.stiffness_rate @ self.held
        response[:, self.first] = np.tensordot(rate, loads[:, self.first], axes=1)
        return response

    def matrix(self, number: int) -> Complex:
        return self.held if number == self.first else self.free.matrix(number)


@dataclass(frozen=True, eq=False)
class Expansion:
    """w: [rad/s]; displacement: at the channel [m]; missing: k + i w c [N/m]

    by_observation: (2, 1 + 2 n) of k [N/m] and c [N s/m] by the observations: logarithm of the frequency, then
        logarithm of amplitude and phase of every sensor
    """

    w: float
    displacement: complex
    missing: complex
    by_observation: Floats


@dataclass(frozen=True, eq=False)
class MeasuredPoint:
    """w: [rad/s]; rows: of the sensors (n,); channel: place among them; amplitude: (n,) first harmonics [m]
    noise: (n, 2) relative standard deviation of amplitude, and that of phase"""

    w: float
    rows: Integers
    channel: int
    amplitude: Complex
    noise: Floats


def expand(
    system: NonlinearSystem,
    excitation: Excitation,
    mode: ResonantMode,
    measured: MeasuredPoint,
    start: tuple[Floats, Complex],
) -> Expansion | None:
    """The motion that fits a measured point, and the force that it asks for; None where none is found.

    start: relative displacements (n_relative, n_coefficients) [m] and q (h,) to begin with
    """
    held = HeldModes(system, measured.w, mode.numbers)
    weights = 1 / measured.noise.ravel()
    x, q = start
    for _ in range(_ITERATIONS):
        at = _linearised(held, excitation, measured.rows, x, q)
        wanted = _pairs(np.log(measured.amplitude / at.sensors))
        dq = np.linalg.lstsq(weights[:, None] * at.by_q, weights * wanted, rcond=None)[0]
        dq *= min(1.0, _FARTHEST * float(np.linalg.norm(q)) / max(float(np.linalg.norm(dq)), np.finfo(float).tiny))
        dx = at.dx + at.x_by_q @ dq
        x, q = x + dx, q + dq[0::2] + 1j * dq[1::2]
        small = np.linalg.norm(dx) <= _SETTLED * np.linalg.norm(x)
        if small and np.linalg.norm(dq) < _SETTLED * np.linalg.norm(q):
            return _expansion(at, excitation, mode, q, measured.channel, weights)
    return None


@dataclass(frozen=True, eq=False)
class _Linearised:
    """The motion with the mode held, linear about some x.

    dx: Newton step of x at held q; x_by_q: (n_relative, n_coefficients, 2 h) by real and imaginary parts of q
    g: departure after the step; g_by_q: likewise
    sensors: (n,) first harmonics after the step [m]; by_q: (2 n, 2 h) of their logarithms
    """

    held: HeldModes
    dx: Floats
    x_by_q: Floats
    g: Floats
    g_by_q: Floats
    sensors: Complex
    by_q: Floats


def _linearised(held: HeldModes, excitation: Excitation, rows: Integers, x: Floats, q: Complex) -> _Linearised:
    system, relative = held.system, slice(len(x))
    units = _units(len(q))
    departure = system.departure(x, held.w)
    jacobian = factorise(held, departure)
    residual = x - held.excitation(excitation) - held.moved(relative, q) + held.apply(departure.value)
    dx = -jacobian.solve(residual)
    x_by_q = np.stack([jacobian.solve(held.moved(relative, unit)) for unit in units], axis=2)
    changes = apply_tangent(system, departure, np.concatenate([dx[..., None], x_by_q], axis=2))
    g, g_by_q = departure.value + changes[..., 0], changes[..., 1:]
    motion = held.excitation(excitation, rows) + held.moved(rows, q) - held.apply(g, rows)
    sensors = system.harmonics.amplitude(motion, 1)
    by_q = [
        _pairs(system.harmonics.amplitude(held.moved(rows, unit) - held.apply(g_by_q[..., i], rows), 1) / sensors)
        for i, unit in enumerate(units)
    ]
    return _Linearised(held, dx, x_by_q, g, g_by_q, sensors, np.stack(by_q, axis=1))


def _expansion(
    at: _Linearised, excitation: Excitation, mode: ResonantMode, q: Complex, channel: int, weights: Floats
) -> Expansion:
    """Observations move q as least squares has it; the frequency also moves the force at held q, by the mode's inertia
    and its viscous damping."""
    held, w, y = at.held, at.held.w, at.sensors[channel]
    scale = -1 / (mode.shape * y)
    missing = scale * held.force(q, at.g, excitation)
    of_y = at.by_q[2 * channel] + 1j * at.by_q[2 * channel + 1]
    of_force = [held.force(unit, at.g_by_q[..., i], None) for i, unit in enumerate(_units(len(q)))]
    by_q = scale * np.array(of_force) - missing * of_y
    inertia = -2 * w + 1j * held.system.stuck.viscous[mode.numbers[0], mode.numbers[0]]
    by_sensors = by_q @ (np.linalg.pinv(weights[:, None] * at.by_q) * weights)
    each = np.append(w * scale * inertia * q[0], by_sensors)
    # the dashpot is what is missing in quadrature, over the frequency
    of_dashpot = each.imag / w - np.eye(len(each))[0] * missing.imag / w
    return Expansion(w, complex(y), missing, np.stack([each.real, of_dashpot]))


def _units(h: int) -> list[Complex]:
    """Of the real and imaginary part of every held mode."""
    return list(np.kron(np.eye(h), np.array([[1.0 + 0j], [1j]])))


def _pairs(values: Complex) -> Floats:
    """Real and imaginary parts side by side: (n,) -> (2 n,)"""
    return np.stack([values.real, values.imag], axis=-1).ravel()
