"""The finite element stages: from the mesh to the reduced model, and its check on the full model.

Factorisations cannot be stored, so what shares one is done together; the coupled check alone depends on the contact
stiffness, so it can be had alone too.
"""

from collections.abc import Callable, Iterator
from contextlib import ExitStack, contextmanager
from dataclasses import dataclass, field
from time import perf_counter

import numpy as np
from numpy.typing import NDArray

from updamp.fem.assembly import assemble, clamp
from updamp.fem.component import Component, FactorisedComponent, component, factorised
from updamp.fem.coupled_modes import CoupledModes, coupled_frequencies_reduced, coupled_modes_full, static_flexibility
from updamp.fem.coupling import Coupling, coupling_named
from updamp.fem.element_matrices import ElasticMaterial
from updamp.fem.interface import blade_interface, damper_interface
from updamp.fem.modes import Modes
from updamp.fem.quadratic_mesh import quadratic_mesh
from updamp.fem.reduced_model import ReducedComponent, ReducedModel
from updamp.fem.reduction import ReductionOptions, component_modes, mirrored_component, reduce_component
from updamp.fem.solvers import solver_named
from updamp.fem.springs import ContactStiffness, Springs, on_damper, stuck_contact
from updamp.geometry.rig_mesh import RigMesh
from updamp.rig.rig import Rig
from updamp.rig.wires import wire_springs

Floats = NDArray[np.float64]
Progress = Callable[[str], None]

BLADE_SHAPES = 6  # kept for pictures


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
class FiniteElementResult:
    """reduced: the model for all later stages
    blade_frequencies, damper_frequencies: (n_modes,) of the separate components [Hz], 0 for rigid-body modes
    blade_shapes: (6, n_vertices, 3) of the right-hand blade's first modes [kg^-1/2]
    coupled: the check, None where no contact stiffness was given
    seconds: wall time of "assembly", "modes", "reduction", "coupled_check"
    """

    reduced: ReducedModel
    blade_frequencies: Floats
    damper_frequencies: Floats
    blade_shapes: Floats
    coupled: CoupledCheck | None
    seconds: dict[str, float] = field(default_factory=dict)


def assemble_rig(mesh: RigMesh, material: ElasticMaterial, coupling: Coupling) -> tuple[Component, Component]:
    """The clamped right-hand blade and the free damper. raises: ValueError, GeometryError for meshes that do not fit"""
    blade_mesh, damper_mesh = quadratic_mesh(mesh.blade), quadratic_mesh(mesh.damper)
    blade = clamp(assemble(blade_mesh, material), np.unique(blade_mesh.faces["root"]))
    damper = assemble(damper_mesh, material)
    return (
        component(blade_mesh, blade, blade_interface(blade_mesh, blade, mesh.contacts, coupling), free=False),
        component(damper_mesh, damper, damper_interface(damper_mesh, damper, mesh.contacts, coupling), free=True),
    )


def finite_element_model(
    mesh: RigMesh,
    rig: Rig,
    contact: ContactStiffness | None = None,
    progress: Progress = lambda _: None,
    options: ReductionOptions | None = None,
) -> FiniteElementResult:
    """All finite element stages with one factorisation of the blade.

    contact: for the coupled check, which is left out without it; the reduced model does not depend on it
    progress: is told what begins
    raises: SolverMissingError, SolverFailedError, InaccurateModesError; GeometryError where mesh and patches differ
    """
    options = ReductionOptions(rig.reduction.modes) if options is None else options
    solver = solver_named(rig.reduction.solver)
    clock = _Clock(progress)
    with clock("assembly", "stiffness and mass"):
        blade, damper = assemble_rig(mesh, rig.material, coupling_named(rig.contact.coupling))
    with ExitStack() as held:
        with clock("modes", "factorisations"):
            on_root, on_support = (held.enter_context(factorised(part, solver)) for part in (blade, damper))
        blade_modes, damper_modes = (_modes(part, options, clock) for part in (on_root, on_support))
        right = _reduction(on_root, blade_modes, options, clock)
        floating = _reduction(on_support, damper_modes, options, clock)
        reduced = _reduced_model(right, floating, mesh, blade_modes, damper_modes)
        coupled = None
        if contact:
            with clock("coupled_check", "stuck rig on the full model"):
                flexibility = _static_flexibility(right) if options.residual else None
                coupled = _check(on_root, on_support, flexibility, reduced, rig, contact)
    return FiniteElementResult(
        reduced,
        blade_modes.frequencies,
        damper_modes.frequencies,
        blade.matrices.on_mesh(blade_modes.phi[:, :BLADE_SHAPES])[:, : len(mesh.blade.vertices)],
        coupled,
        clock.seconds,
    )


def coupled_check(mesh: RigMesh, rig: Rig, reduced: ReducedModel, contact: ContactStiffness) -> CoupledCheck:
    """The check alone, for a reduced model that is there already: after a change of the contact stiffness."""
    solver = solver_named(rig.reduction.solver)
    blade, damper = assemble_rig(mesh, rig.material, coupling_named(rig.contact.coupling))
    with factorised(blade, solver) as blade_part, factorised(damper, solver) as damper_part:
        return _check(blade_part, damper_part, None, reduced, rig, contact)


def rig_springs(reduced: ReducedModel, rig: Rig, contact: ContactStiffness) -> Springs:
    """Stuck contact at every contact element, and both wires."""
    return stuck_contact(reduced.contacts, contact) + on_damper(reduced.contacts, wire_springs(rig))


def _modes(part: FactorisedComponent, options: ReductionOptions, clock: "_Clock") -> Modes:
    with clock("modes", f"modes of the {part.component.name}"):
        return component_modes(part, options)


def _reduction(part: FactorisedComponent, modes: Modes, options: ReductionOptions, clock: "_Clock") -> ReducedComponent:
    with clock("reduction", f"residual flexibility of the {part.component.name}"):
        return reduce_component(part, modes, options)


def _reduced_model(
    right: ReducedComponent, damper: ReducedComponent, mesh: RigMesh, blade_modes: Modes, damper_modes: Modes
) -> ReducedModel:
    return ReducedModel(
        blade_left=mirrored_component(right, "blade_left"),
        blade_right=ReducedComponent("blade_right", right.omega, right.phi, right.residual, right.points),
        damper=ReducedComponent("damper", damper.omega, damper.phi, damper.residual, damper.points),
        contacts=mesh.contacts,
        max_relative_residual=max(blade_modes.max_relative_residual, damper_modes.max_relative_residual),
    )


def _static_flexibility(reduced: ReducedComponent) -> Floats:
    """Of a clamped component, exact with its residual: spares the check as many solves as the interface has columns.
    Were it wrong, the check's own residual would show it."""
    return (reduced.phi / reduced.omega**2) @ reduced.phi.T + reduced.residual


def _check(
    blade: FactorisedComponent,
    damper: FactorisedComponent,
    flexibility: Floats | None,
    reduced: ReducedModel,
    rig: Rig,
    contact: ContactStiffness,
) -> CoupledCheck:
    springs = rig_springs(reduced, rig, contact)
    flexibility = static_flexibility(blade) if flexibility is None else flexibility
    modes = coupled_modes_full(blade, damper, flexibility, springs)
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


def _shape(blade: Component, damper: Component, modes: CoupledModes, number: int) -> dict[str, Floats]:
    def on_vertices(part: Component, fields: Floats) -> Floats:
        n_vertices = part.mesh.connectivity[:, :8].max() + 1
        return part.matrices.on_mesh(fields[:, [number]])[0, :n_vertices]

    return {
        "blade_left": on_vertices(blade, modes.blade_left) * np.array([-1.0, 1.0, 1.0]),
        "blade_right": on_vertices(blade, modes.blade_right),
        "damper": on_vertices(damper, modes.damper),
    }


class _Clock:
    """Adds up the wall time of named stages and tells what begins; nested stages count for the inner one only."""

    def __init__(self, progress: Progress):
        self._progress = progress
        self._inner = 0.0
        self.seconds: dict[str, float] = {}

    @contextmanager
    def __call__(self, stage: str, step: str) -> Iterator[None]:
        self._progress(step)
        outer, self._inner, start = self._inner, 0.0, perf_counter()
        yield
        elapsed = perf_counter() - start
        self.seconds[stage] = self.seconds.get(stage, 0.0) + elapsed - self._inner
        self._inner = outer + elapsed
