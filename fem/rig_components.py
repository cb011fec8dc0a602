"""Blade and damper of a rig, assembled, and factorised for as long as they are held."""

from collections.abc import Callable, Iterator
from contextlib import ExitStack, contextmanager
from time import perf_counter
from types import TracebackType
from typing import Self, TypeVar

import numpy as np

from updamp.fem.assembly import assemble, clamp
from updamp.fem.component import Component, FactorisedComponent, component, factorised
from updamp.fem.coupling import Coupling, coupling_named
from updamp.fem.element_matrices import ElasticMaterial
from updamp.fem.interface import blade_interface, damper_interface
from updamp.fem.quadratic_mesh import quadratic_mesh
from updamp.fem.solvers import solver_named
from updamp.geometry.rig_mesh import RigMesh
from updamp.rig.rig import Rig

Product = TypeVar("Product")
Progress = Callable[[str], None]

BLADE, DAMPER = "blade", "damper"


class RigComponents:
    """Context manager. A component is assembled and its stiffness factorised when it is first asked for, and only then;
    both go at the end: factorisations are the largest things in memory.

    clock: adds up the wall time of "assembly", "modes", "reduction" and "coupled_check", and tells what begins
    """

    def __init__(self, mesh: RigMesh, rig: Rig, progress: Progress = lambda _: None) -> None:
        self.mesh, self.rig = mesh, rig
        self.clock = Clock(progress)
        self._held = ExitStack()
        self._factorised: dict[str, FactorisedComponent] = {}

    def __enter__(self) -> Self:
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        self._factorised.clear()
        self._held.close()

    def factorised(self, name: str) -> FactorisedComponent:
        """name: "blade" or "damper"; raises: SolverMissingError, SolverFailedError, GeometryError"""
        if name not in self._factorised:
            with self.clock("assembly", f"stiffness and mass of the {name}"):
                coupling = coupling_named(self.rig.contact.coupling)
                part = _ASSEMBLED[name](self.mesh, self.rig, coupling)
            with self.clock("modes", f"factorisation of the {name}"):
                solver = solver_named(self.rig.reduction.solver)
                self._factorised[name] = self._held.enter_context(factorised(part, solver))
        return self._factorised[name]


def assemble_rig(mesh: RigMesh, rig: Rig, coupling: Coupling) -> tuple[Component, Component]:
    """The clamped right-hand blade and the free damper, each of its material.

    raises: ValueError, GeometryError for meshes that do not fit
    """
    return _blade_of(mesh, rig, coupling), _damper_of(mesh, rig, coupling)


def assemble_blade(mesh: RigMesh, material: ElasticMaterial, coupling: Coupling) -> Component:
    """The right-hand one, clamped at its root. raises: as `assemble_rig`"""
    own = quadratic_mesh(mesh.blade)
    matrices = clamp(assemble(own, material), np.unique(own.faces["root"]))
    return component(own, matrices, blade_interface(own, matrices, mesh.contacts, coupling), free=False)


def assemble_damper(mesh: RigMesh, material: ElasticMaterial, coupling: Coupling) -> Component:
    """Free. raises: as `assemble_rig`"""
    own = quadratic_mesh(mesh.damper)
    matrices = assemble(own, material)
    return component(own, matrices, damper_interface(own, matrices, mesh.contacts, coupling), free=True)


def _blade_of(mesh: RigMesh, rig: Rig, coupling: Coupling) -> Component:
    return assemble_blade(mesh, rig.material, coupling)


def _damper_of(mesh: RigMesh, rig: Rig, coupling: Coupling) -> Component:
    return assemble_damper(mesh, rig.damper_material, coupling)


_ASSEMBLED = {BLADE: _blade_of, DAMPER: _damper_of}


class Clock:
    """Adds up the wall time of named parts of the work and tells what begins; nested ones count for the inner one only.

    seconds: so far, by name
    """

    def __init__(self, progress: Progress) -> None:
        self.progress = progress
        self._inner = 0.0
        self.seconds: dict[str, float] = {}

    @contextmanager
    def __call__(self, stage: str, step: str) -> Iterator[None]:
        self.progress(step)
        outer, self._inner, start = self._inner, 0.0, perf_counter()
        yield
        elapsed = perf_counter() - start
        self.seconds[stage] = self.seconds.get(stage, 0.0) + elapsed - self._inner
        self._inner = outer + elapsed

    def timed(self, work: Callable[[], Product]) -> tuple[Product, dict[str, float]]:
        """What the work gives, and its wall time by name."""
        before = dict(self.seconds)
        product = work()
        spent = {name: seconds - before.get(name, 0.0) for name, seconds in self.seconds.items()}
        return product, {name: seconds for name, seconds in spent.items() if seconds}
