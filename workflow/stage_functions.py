"""What each stage calls."""

from collections.abc import Callable, Mapping
from dataclasses import dataclass

from updamp.fem import finite_element_model as fem
from updamp.fem.finite_element_model import ComponentModel, CoupledCheck
from updamp.fem.reduced_model import ReducedModel
from updamp.fem.rig_components import BLADE, DAMPER, RigComponents
from updamp.fem.springs import ContactStiffness
from updamp.fem.static_contact import static_contact as at_rest
from updamp.fem.static_contact.rest_state import StaticContact
from updamp.geometry.rig_mesh import RigMesh
from updamp.parallel.system_libraries import lacking
from updamp.rig.rig import Rig
from updamp.workflow import stages
from updamp.workflow.stages import Stage

# Without them gmsh cannot be loaded: shared library -> Debian package.
GMSH_LIBRARIES: Mapping[str, str] = {
    "libGL.so.1": "libgl1",
    "libGLU.so.1": "libglu1-mesa",
    "libXcursor.so.1": "libxcursor1",
    "libXft.so.2": "libxft2",
    "libXinerama.so.1": "libxinerama1",
    "libgomp.so.1": "libgomp1",
}


def build_mesh(rig: Rig, preset: str) -> RigMesh:
    """raises: ImportError naming the system libraries that gmsh lacks; what the mesh's own function does"""
    if missing := lacking(GMSH_LIBRARIES):
        raise ImportError(f"no mesh can be made: {missing}")
    # On call: gmsh needs system libraries, which a machine that takes the mesh from its file may lack.
    from updamp.geometry.build_mesh import build_mesh

    return build_mesh(rig, preset)


def blade(parts: RigComponents) -> ComponentModel:
    return fem.component_model(parts, BLADE)


def damper(parts: RigComponents) -> ComponentModel:
    return fem.component_model(parts, DAMPER)


def coupled_check(parts: RigComponents, reduced: ReducedModel) -> CoupledCheck:
    """Finds the factorisations at hand where the components were made just now."""
    contact = parts.rig.contact
    return fem.coupled_check(parts, reduced, ContactStiffness(contact.tangential_stiffness, contact.normal_stiffness))


def static_contact(rig: Rig, reduced: ReducedModel) -> StaticContact:
    return at_rest.static_contact(reduced, rig)


@dataclass(frozen=True)
class StageFunctions:
    """One function a stage; a test may put a quicker one in the place of the finite elements."""

    mesh: Callable[[Rig, str], RigMesh] = build_mesh
    blade: Callable[[RigComponents], ComponentModel] = blade
    damper: Callable[[RigComponents], ComponentModel] = damper
    coupled_check: Callable[[RigComponents, ReducedModel], CoupledCheck] = coupled_check
    static_contact: Callable[[Rig, ReducedModel], StaticContact] = static_contact

    def component(self, stage: Stage) -> Callable[[RigComponents], ComponentModel]:
        """stage: BLADE or DAMPER"""
        return {stages.BLADE: self.blade, stages.DAMPER: self.damper}[stage]
