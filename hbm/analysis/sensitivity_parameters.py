"""Parameters that a solved point can be differentiated with respect to.

A parameter says which loads on the stuck structure its unit change amounts to while the motion is held: for the
residual r = x - x_lin + G g, dr/dp is minus the response to them. The reference springs are held: the solution does
not depend on them, so where a contact stiffness changes, f_nl alone is differentiated, which is exact.
"""

from collections.abc import Mapping
from dataclasses import dataclass
from functools import cached_property
from typing import ClassVar, Protocol

import numpy as np
from numpy.typing import NDArray

from updamp.hbm.analysis.law_derivatives import law_derivatives
from updamp.hbm.newton.equation import Equation
from updamp.hbm.newton.structure_response import Loads, StructureMotion, all_loads, respond
from updamp.hbm.problem.linear_model import LinearModel
from updamp.hbm.problem.system import Excitation, NonlinearSystem

Floats = NDArray[np.float64]
LawEntry = tuple[int, str]


@dataclass(frozen=True, eq=False)
class SolvedPoint:
    """What parameters need to know of a point.

    law_entries: (group, entry) of all the laws' parameters that will be asked for: they are differentiated together
    """

    equation: Equation
    excitation: Excitation
    law_entries: tuple[LawEntry, ...] = ()

    @property
    def system(self) -> NonlinearSystem:
        return self.equation.receptance.system

    @cached_property
    def loads(self) -> Loads:
        """All that acts on the stuck structure, as one load."""
        return all_loads(self.equation, self.excitation)

    @cached_property
    def motion(self) -> StructureMotion:
        return respond(self.equation.receptance, self.loads)

    @cached_property
    def law_derivatives(self) -> Mapping[LawEntry, Floats]:
        """(group, entry) -> as returned by law_derivatives.law_derivatives"""
        found: dict[LawEntry, Floats] = {}
        system, equation = self.system, self.equation
        for i, group in enumerate(system.groups):
            entries = tuple(sorted({entry for place, entry in self.law_entries if place == i}))
            if entries:
                derivatives = law_derivatives(
                    group,
                    entries,
                    equation.x[group.rows],
                    equation.departure.tangents[i],
                    equation.w,
                    system.harmonics,
                    system.time_samples,
                )
                found |= {(i, entry): d for entry, d in derivatives.items()}
        return found


class Parameter(Protocol):
    @property
    def law_entries(self) -> tuple[LawEntry, ...]:
        """Parameters of the contact laws that `loads` asks for."""
        ...

    def loads(self, point: SolvedPoint) -> Loads:
        """One load: what a unit change of the parameter amounts to while the motion is held."""
        ...


@dataclass(frozen=True, eq=False)
class ContactParameter:
    """One entry of a group's law, such as mu, kt or n0, changed along a pattern over its elements.

    pattern: like the entry, (n_elements, ...): its change per unit of the parameter
    raises: ValueError for a pattern of another shape
    """

    system: NonlinearSystem
    entry: str
    pattern: Floats
    group: int = 0

    def __post_init__(self) -> None:
        names = self.system.groups[self.group].law.parameters
        shape = np.shape(getattr(self.system.groups[self.group].parameters, self.entry))
        if np.shape(self.pattern) != shape:
            raise ValueError(
                f"pattern of {names.__name__}.{self.entry} has shape {np.shape(self.pattern)}: give one of {shape}"
            )

    @property
    def law_entries(self) -> tuple[LawEntry, ...]:
        return ((self.group, self.entry),)

    def loads(self, point: SolvedPoint) -> Loads:
        derivative = point.law_derivatives[self.group, self.entry]
        n, d, c = derivative.shape[:3]
        change = derivative.reshape(n, d * c, -1) @ self.pattern.reshape(n, -1, 1)
        loads = Loads.none(point.equation.receptance, 1)
        loads.forces[point.system.groups[self.group].rows] = -change.reshape(n, d, c, 1)
        return loads


def same_for_all(system: NonlinearSystem, entry: str, group: int = 0) -> ContactParameter:
    """The same change on all elements: unit [of the entry]."""
    value = np.asarray(getattr(system.groups[group].parameters, entry))
    return ContactParameter(system, entry, np.ones_like(value), group)


def scaled(system: NonlinearSystem, entry: str, group: int = 0) -> ContactParameter:
    """A common factor on all elements' values, 1 at present: for stiffness an area, or for the preload."""
    return ContactParameter(system, entry, np.array(getattr(system.groups[group].parameters, entry)), group)


def of_element(system: NonlinearSystem, entry: str, element: int, group: int = 0) -> ContactParameter:
    """All components of the entry of one element."""
    pattern = np.zeros_like(np.asarray(getattr(system.groups[group].parameters, entry)))
    pattern[element] = 1.0
    return ContactParameter(system, entry, pattern, group)


@dataclass(frozen=True, eq=False)
class ModalParameter:
    """A change of the free structure's modal matrices; its mode shapes stay.

    stiffness, hysteretic: (m, m) [rad^2/s^2 per unit]; viscous: (m, m) [rad/s per unit]
    """

    stiffness: Floats
    hysteretic: Floats
    viscous: Floats
    law_entries: ClassVar[tuple[LawEntry, ...]] = ()

    def loads(self, point: SolvedPoint) -> Loads:
        """raises: ValueError where the stuck modes do not say how they are made of the free ones"""
        receptance, harmonics = point.equation.receptance, point.system.harmonics
        basis = point.system.stuck.basis
        if basis is None:
            raise ValueError("the stuck model has no basis in the free modes: make it with add_springs")
        free = basis @ point.motion.modal[:, :, 0]
        loads = np.zeros_like(free)
        for k in harmonics.orders:
            damping = 1j * (self.hysteretic + k * receptance.w * self.viscous) if k else 0.0
            harmonics.set_amplitude(loads, k, -(self.stiffness + damping) @ harmonics.amplitude(free, k))
        none = Loads.none(receptance, 1)
        return Loads(none.forces, (basis.T @ loads)[:, :, None])


def mode_frequency(free: LinearModel, mode: int) -> ModalParameter:
    """Natural angular frequency of one free mode [rad/s]; its damping matrices stay."""
    m = len(free.omega_squared)
    stiffness = np.zeros((m, m))
    stiffness[mode, mode] = 2 * np.sqrt(max(free.omega_squared[mode], 0.0))
    return ModalParameter(stiffness, np.zeros((m, m)), np.zeros((m, m)))


def mode_loss_factor(free: LinearModel, mode: int) -> ModalParameter:
    """Hysteretic loss factor of one free mode [-]."""
    m = len(free.omega_squared)
    hysteretic = np.zeros((m, m))
    hysteretic[mode, mode] = free.omega_squared[mode]
    return ModalParameter(np.zeros((m, m)), hysteretic, np.zeros((m, m)))


def hysteretic_scale(free: LinearModel) -> ModalParameter:
    """A common factor on the hysteretic damping, 1 at present; over the loss factor: per unit of loss factor."""
    return ModalParameter(np.zeros_like(free.hysteretic), free.hysteretic, np.zeros_like(free.hysteretic))


def viscous_scale(free: LinearModel) -> ModalParameter:
    """A common factor on the viscous damping, 1 at present."""
    return ModalParameter(np.zeros_like(free.viscous), np.zeros_like(free.viscous), free.viscous)


@dataclass(frozen=True, eq=False)
class ExcitationForce:
    """Amplitude of the excitation [N]."""

    law_entries: ClassVar[tuple[LawEntry, ...]] = ()

    def loads(self, point: SolvedPoint) -> Loads:
        loads = Loads.none(point.equation.receptance, 1)
        loads.forces[point.excitation.row, point.system.harmonics.slices[1].start, 0] = 1.0
        return loads


@dataclass(frozen=True, eq=False)
class ParameterSum:
    """A sum of parameters: what a rig's quantity does in several places, such as the pull, which presses the
    contacts and tightens the wire.

    parts: (change of the parameter per unit, parameter)
    """

    parts: tuple[tuple[float, Parameter], ...]

    @property
    def law_entries(self) -> tuple[LawEntry, ...]:
        return tuple(entry for _, part in self.parts for entry in part.law_entries)

    def loads(self, point: SolvedPoint) -> Loads:
        each = [(weight, part.loads(point)) for weight, part in self.parts]
        return Loads(
            np.sum([weight * load.forces for weight, load in each], axis=0),
            np.sum([weight * load.modal for weight, load in each], axis=0),
        )
