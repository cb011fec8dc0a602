"""The mesh stage: from the rig's dimensions to hexahedra and contact elements."""

from math import degrees

import numpy as np

from updamp.geometry.contact_triangulation import contact_elements
from updamp.geometry.cross_sections import blade_section, damper_section
from updamp.geometry.extruded_blocks import extrude_section
from updamp.geometry.rig_mesh import ComponentMesh, GeometryError, RigMesh, scaled_jacobian
from updamp.rig.rig import Rig

SMALLEST_SCALED_JACOBIAN = 0.2


def build_mesh(rig: Rig, preset_name: str) -> RigMesh:
    """Mesh the right-hand blade and the damper with the divisions rig.mesh[preset_name] and lay the contacts over it.

    raises: GeometryError for an unknown preset or hexahedra of a scaled Jacobian of 0.2 or less
    """
    if preset_name not in rig.mesh:
        raise GeometryError("mesh", preset_name, f"there is no such preset; the rig file has {', '.join(rig.mesh)}")
    divisions = rig.mesh[preset_name]
    blade, damper = (
        extrude_section(section(rig, divisions), rig.blade.width, divisions.width)
        for section in (blade_section, damper_section)
    )
    quality = min(_check_quality(rig, component) for component in (blade, damper))
    return RigMesh(blade, damper, contact_elements(rig, divisions), quality)


def _check_quality(rig: Rig, component: ComponentMesh) -> float:
    """Smallest scaled Jacobian of the component."""
    quality = scaled_jacobian(component.vertices, component.hexahedra)
    worst = int(quality.argmin())
    smallest = float(quality[worst])
    if smallest > SMALLEST_SCALED_JACOBIAN:
        return smallest
    finding = f"the {component.name}'s scaled Jacobian is {smallest:.3f}; it must exceed {SMALLEST_SCALED_JACOBIAN}: "
    _, y, _ = np.mean(component.vertices[component.hexahedra[worst]], axis=0)
    if component.name == "damper" and y > rig.face_top[1]:
        raise GeometryError(
            "damper.apex_flat", f"{rig.damper.apex_flat * 1e3:.6g} mm", finding + "widen it or raise damper.apex_height"
        )
    angle = f"{degrees(rig.platform.underside_angle):.6g} deg"
    raise GeometryError("platform.underside_angle", angle, finding + "between 12 and 78 deg is allowed")
