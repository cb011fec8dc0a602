"""What each stage calls. Imports are made on call: a stage that is not run does not load its libraries."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import TYPE_CHECKING

from updamp.rig.rig import Rig

if TYPE_CHECKING:
    from updamp.fem.finite_element_model import CoupledCheck, FiniteElementResult
    from updamp.fem.reduced_model import ReducedModel
    from updamp.fem.static_contact.rest_state import StaticContact
    from updamp.geometry.rig_mesh import RigMesh

Progress = Callable[[str], None]


def build_mesh(rig: Rig, preset: str) -> RigMesh:
    from updamp.geometry.build_mesh import build_mesh

    return build_mesh(rig, preset)


def finite_elements(rig: Rig, mesh: RigMesh, check: bool, progress: Progress) -> FiniteElementResult:
    """check: whether to make the coupled check while the factorisation of the blade is at hand"""
    from updamp.fem.finite_element_model import finite_element_model
    from updamp.fem.springs import ContactStiffness

    contact = ContactStiffness(rig.contact.tangential_stiffness, rig.contact.normal_stiffness)
    return finite_element_model(mesh, rig, contact if check else None, progress)


def coupled_check(rig: Rig, mesh: RigMesh, reduced: ReducedModel) -> CoupledCheck:
    from updamp.fem.finite_element_model import coupled_check
    from updamp.fem.springs import ContactStiffness

    return coupled_check(
        mesh, rig, reduced, ContactStiffness(rig.contact.tangential_stiffness, rig.contact.normal_stiffness)
    )


def static_contact(rig: Rig, reduced: ReducedModel) -> StaticContact:
    from updamp.fem.static_contact.static_contact import static_contact

    return static_contact(reduced, rig)


@dataclass(frozen=True)
class StageFunctions:
    """One function a stage; a test may put a quicker one in the place of the finite elements."""

    mesh: Callable[[Rig, str], RigMesh] = build_mesh
    finite_elements: Callable[[Rig, RigMesh, bool, Progress], FiniteElementResult] = finite_elements
    coupled_check: Callable[[Rig, RigMesh, ReducedModel], CoupledCheck] = coupled_check
    static_contact: Callable[[Rig, ReducedModel], StaticContact] = static_contact
