"""What each stage calls."""

from collections.abc import Callable
from dataclasses import dataclass

from updamp.fem import finite_element_model as fem
from updamp.fem.finite_element_model import CoupledCheck, FiniteElementResult
from updamp.fem.reduced_model import ReducedModel
from updamp.fem.springs import ContactStiffness
from updamp.fem.static_contact import static_contact as at_rest
from updamp.fem.static_contact.rest_state import StaticContact
from updamp.geometry.rig_mesh import RigMesh
from updamp.rig.rig import Rig

Progress = Callable[[str], None]


def build_mesh(rig: Rig, preset: str) -> RigMesh:
    # On call: gmsh needs system libraries, which a machine that takes the mesh from its file may lack.
    from updamp.geometry.build_mesh import build_mesh

    return build_mesh(rig, preset)


def finite_elements(rig: Rig, mesh: RigMesh, check: bool, progress: Progress) -> FiniteElementResult:
    """check: whether to make the coupled check while the factorisation of the blade is at hand"""
    return fem.finite_element_model(mesh, rig, _stiffness(rig) if check else None, progress)


def coupled_check(rig: Rig, mesh: RigMesh, reduced: ReducedModel) -> CoupledCheck:
    return fem.coupled_check(mesh, rig, reduced, _stiffness(rig))


def _stiffness(rig: Rig) -> ContactStiffness:
    return ContactStiffness(rig.contact.tangential_stiffness, rig.contact.normal_stiffness)


def static_contact(rig: Rig, reduced: ReducedModel) -> StaticContact:
    return at_rest.static_contact(reduced, rig)


@dataclass(frozen=True)
class StageFunctions:
    """One function a stage; a test may put a quicker one in the place of the finite elements."""

    mesh: Callable[[Rig, str], RigMesh] = build_mesh
    finite_elements: Callable[[Rig, RigMesh, bool, Progress], FiniteElementResult] = finite_elements
    coupled_check: Callable[[Rig, RigMesh, ReducedModel], CoupledCheck] = coupled_check
    static_contact: Callable[[Rig, ReducedModel], StaticContact] = static_contact
