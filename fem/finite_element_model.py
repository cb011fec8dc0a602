"""The finite element stages: from the mesh to the models of blade and damper, the reduced model of the rig, its check.

Blade and damper are products of their own, so that a change of one leaves the other alone. Factorisations cannot be
stored: what shares one is done while the components are held (`fem/rig_components.py`).
"""

from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from updamp.fem.component import Component
from updamp.fem.coupled_modes import CoupledModes, coupled_frequencies_reduced, coupled_modes_full
from updamp.fem.reduced_model import ReducedComponent, ReducedModel
from updamp.fem.reduction import (
    ReductionOptions,
    component_modes,
    mirrored_component,
    momentum_about_clamp,
    reduce_component,
)
from updamp.fem.rig_components import BLADE, DAMPER, RigComponents
from updamp.fem.springs import ContactStiffness, Springs, on_damper, stuck_contact
from updamp.geometry.contact_elements import ContactElements
from updamp.geometry.rig_mesh import RigMesh
from updamp.rig.rig import Rig
from updamp.rig.wires import wire_springs

Floats = NDArray[np.float64]

SHAPES = 6  # kept for pictures


@dataclass(frozen=True, eq=False)
class CoupledCheck:
    """The stuck rig on its wires: the full finite element model against the reduced one.

    full, reduced: (n,) [Hz], ascending
    out_of_phase, in_phase: numbers of the OOP and the IP mode among them
    shapes: of these two, name ("OOP", "IP") -> component -> (n_vertices, 3) [kg^-1/2], global directions; the left
        blade's vertices are the mirror images of the mesh's
    max_relative_residual: of the full model's modes [-]
    """

    full: Floats
    reduced: Floats
    out_of_phase: int
    in_phase: int
    shapes: dict[str, dict[str, Floats]]
    max_relative_residual: float

    @property
    def largest_difference(self) -> float:
        """Largest |reduced / full - 1| [-]."""
        return float(np.abs(self.reduced / self.full - 1).max())


@dataclass(frozen=True, eq=False)
class ComponentModel:
    """One component by itself, the right-hand blade or the damper.

    frequencies: (n_modes,) [Hz], 0 for rigid-body modes
    shapes: (6, n_vertices, 3) of the first modes [kg^-1/2]
    max_relative_residual: of the modes [-]
    """

    reduced: ReducedComponent
    frequencies: Floats
    shapes: Floats
    max_relative_residual: float


@dataclass(frozen=True, eq=False)
class FiniteElementResult:
    """reduced: the model for all later stages
    blade_frequencies: (n_modes,) of the blade by itself [Hz]
    blade_shapes: (6, n_vertices, 3) of the right-hand blade's first modes [kg^-1/2]
    """

    reduced: ReducedModel
    blade_frequencies: Floats
    blade_shapes: Floats


def finite_element_model(mesh: RigMesh, rig: Rig, options: ReductionOptions | None = None) -> FiniteElementResult:
    """All of it in memory, without the check. raises: as `component_model`"""
    with RigComponents(mesh, rig) as parts:
        blade, damper = (component_model(parts, name, options) for name in (BLADE, DAMPER))
        return joined(blade, damper, mesh.contacts)


def component_model(parts: RigComponents, name: str, options: ReductionOptions | None = None) -> ComponentModel:
    """Modes and residual flexibility of one component. name: "blade" or "damper"

    raises: SolverMissingError, SolverFailedError, InaccurateModesError; GeometryError where mesh and patches differ
    """
    options = ReductionOptions(parts.rig.reduction.modes) if options is None else options
    part = parts.factorised(name)
    with parts.clock("modes", f"modes of the {name}"):
        modes = component_modes(part, options)
    with parts.clock("reduction", f"residual flexibility of the {name}"):
        reduced = reduce_component(part, modes, options)
    own = part.component
    if name == BLADE:
        reduced = replace(reduced, momentum_about_clamp=momentum_about_clamp(own, modes, parts.rig.blade.axis_offset))
    n_vertices = own.mesh.connectivity[:, :8].max() + 1
    shapes = own.matrices.on_mesh(modes.phi[:, :SHAPES])[:, :n_vertices]
    return ComponentModel(reduced, modes.frequencies, shapes, modes.max_relative_residual)


def joined(blade: ComponentModel, damper: ComponentModel, contacts: ContactElements) -> FiniteElementResult:
    """The rig of a right-hand blade, its mirror image and a damper; contacts: of the mesh that both were made from"""
    right, floating = blade.reduced, damper.reduced
    reduced = ReducedModel(
        blade_left=mirrored_component(right, "blade_left"),
        blade_right=replace(right, name="blade_right"),
        damper=replace(floating, name="damper"),
        contacts=contacts,
        max_relative_residual=max(blade.max_relative_residual, damper.max_relative_residual),
    )
    return FiniteElementResult(reduced, blade.frequencies, blade.shapes)


def coupled_check(parts: RigComponents, reduced: ReducedModel, contact: ContactStiffness) -> CoupledCheck:
    """The stuck rig on the full model against the reduced one. raises: SolverFailedError, ArpackNoConvergence

    The blade's static flexibility is that of the reduced model, which spares as many solves as the interface has
    columns; were it wrong, the residual of the full model's modes would show it.
    """
    blade, damper = parts.factorised(BLADE), parts.factorised(DAMPER)
    with parts.clock("coupled_check", "stuck rig on the full model"):
        springs = rig_springs(reduced, parts.rig, contact)
        modes = coupled_modes_full(blade, damper, _static_flexibility(reduced.blade_right), springs)
        return CoupledCheck(
            modes.frequencies,
            coupled_frequencies_reduced(reduced, springs, len(modes.frequencies)),
            modes.out_of_phase,
            modes.in_phase,
            {
                "OOP": _shape(blade.component, damper.component, modes, modes.out_of_phase),
                "IP": _shape(blade.component, damper.component, modes, modes.in_phase),
            },
            modes.max_relative_residual,
        )


def rig_springs(reduced: ReducedModel, rig: Rig, contact: ContactStiffness) -> Springs:
    """Stuck contact at every contact element, and both wires."""
    return stuck_contact(reduced.contacts, contact) + on_damper(reduced.contacts, wire_springs(rig))


def _static_flexibility(reduced: ReducedComponent) -> Floats:
    """Of a clamped component [m/N]."""
    return (reduced.phi / reduced.omega**2) @ reduced.phi.T + reduced.residual


def _shape(blade: Component, damper: Component, modes: CoupledModes, number: int) -> dict[str, Floats]:
    def on_vertices(part: Component, fields: Floats) -> Floats:
        n_vertices = part.mesh.connectivity[:, :8].max() + 1
        return part.matrices.on_mesh(fields[:, [number]])[0, :n_vertices]

    return {
        "blade_left": on_vertices(blade, modes.blade_left) * np.array([-1.0, 1.0, 1.0]),
        "blade_right": on_vertices(blade, modes.blade_right),
        "damper": on_vertices(damper, modes.damper),
    }
