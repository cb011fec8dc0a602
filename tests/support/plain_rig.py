"""A reduced model of the rig's geometry with the fewest modes that can vibrate: two blades that bend, a rigid damper.

For tests of what comes after the finite elements, without running them. Masses and frequencies are of the right size.
"""

from collections.abc import Mapping
from pathlib import Path

import numpy as np

from updamp.effects.rig_model import RigModel
from updamp.fem.finite_element_model import ComponentModel, FiniteElementResult
from updamp.fem.reduced_model import ReducedComponent, ReducedModel
from updamp.fem.rig_components import RigComponents
from updamp.fem.static_contact.static_contact import static_contact
from updamp.geometry.build_mesh import build_mesh
from updamp.geometry.contact_elements import LEFT, RIGHT, ContactElements
from updamp.model.build import rig_model
from updamp.model.rig_files import load_rig
from updamp.rig.dimensions import DIMENSIONS
from updamp.rig.rig import Rig
from updamp.workflow import store
from updamp.workflow.curve_jobs import CurveJob

# A mesh preset for the virtual rig as coarse as it can be; as it stands in a rig file below.
TINY = {
    "width": 4, "face": 2, "platform_outer": 1, "platform_inner": 1, "platform_height": 2, "stem_thickness": 1,
    "stem_below_excitation": 2, "stem_below_platform": 1, "stem_above_platform": 4, "stem_top": 1,
    "damper_across": 2, "damper_apex": 1, "damper_base": 1, "contact_elements": 36,
}  # fmt: skip
TINY_PRESET = "\n[mesh.tiny]\n" + "".join(f"{name} = {value}\n" for name, value in TINY.items())

SHORT_FACES = Path(__file__).parents[1] / "data" / "short_faces.toml"
# The law that takes its events at the samples compiles ten times as fast; low friction, so that contacts slip.
SLIPPING = {
    "contact.law": "jenkins_box_sampled",
    "contact.friction_coefficient": 0.15,
    "harmonic_balance.harmonics": [1, 2, 3],
    "harmonic_balance.time_samples": 64,
}

LOCAL_FLEXIBILITY = 2e-10  # m/N, of each contact degree of freedom
BLADE_MODES = ((269.0, 0), (1500.0, 2), (4000.0, 1))  # Hz, direction


def plain_blade(parts: RigComponents) -> ComponentModel:
    """In the place of the finite elements of the blade."""
    return _component(_blade("blade_right", parts.rig, parts.mesh.contacts, RIGHT))


def plain_damper(parts: RigComponents) -> ComponentModel:
    return _component(_damper(parts.rig, parts.mesh.contacts))


def _component(reduced: ReducedComponent) -> ComponentModel:
    nothing = np.zeros(0)
    return ComponentModel(reduced, nothing, nothing, 1e-12)


def plain_reduced_model(rig: Rig, contacts: ContactElements) -> ReducedModel:
    return ReducedModel(
        _blade("blade_left", rig, contacts, LEFT), _blade("blade_right", rig, contacts, RIGHT),
        _damper(rig, contacts), contacts, 1e-12,
    )  # fmt: skip


def plain_model(path: Path, changes: Mapping[str, object], varied: tuple[str, float] | None = None) -> RigModel:
    """With patches of the real size, as effects and comparisons take it; changes: of the rig file; varied: dimension,
    and its relative change."""
    rig = load_rig(path, changes)
    rig = DIMENSIONS[varied[0]].changed(rig, varied[1]) if varied else rig
    reduced = plain_reduced_model(rig, build_mesh(rig, "small").contacts)
    return rig_model(reduced, static_contact(reduced, rig), rig)


def curve_jobs(path: Path, forces: tuple[float, ...], folder: Path) -> tuple[CurveJob, ...]:
    """Curves of the plain rig near its first stuck mode, with the files of the stages before in the folder."""
    rig = load_rig(path, {"study.modes.OOP.window": around_first_stuck_mode(path, 2.0)})
    reduced, nothing = plain_reduced_model(rig, build_mesh(rig, "small").contacts), np.zeros(0)
    store.write(folder / "fe.h5", FiniteElementResult(reduced, nothing, nothing), store.Stamp("fe"))
    store.write(folder / "rest.h5", static_contact(reduced, rig), store.Stamp("rest"))
    return tuple(
        CurveJob(rig, "OOP", force, f"key {force}", folder / "fe.h5", folder / "rest.h5", folder / f"{force}.h5")
        for force in forces
    )


def around_first_stuck_mode(path: Path, half_width: float) -> tuple[str, str]:
    """Window of frequencies, as in a rig file, about the first mode of the plain rig with all contacts stuck."""
    rig = load_rig(path)
    reduced = plain_reduced_model(rig, build_mesh(rig, "small").contacts)
    frequency = rig_model(reduced, static_contact(reduced, rig), rig).system.stuck.frequencies[0]
    return f"{frequency - half_width:.3f} Hz", f"{frequency + half_width:.3f} Hz"


def _blade(name: str, rig: Rig, contacts: ContactElements, side: int) -> ReducedComponent:
    """Clamped beam: displacement grows with the square of the height (bending) or with the height (axial)."""
    on = contacts.face == side
    height = rig.blade.height
    points = ("excitation.x", "tip.x", "platform.x", "platform.y")
    heights = (rig.excitation.height, rig.response_height, rig.edge_height, rig.edge_height)
    mass = rig.material.density * height * rig.blade.width * rig.blade.thickness / 4
    phi = np.zeros((3 * on.sum() + len(points), len(BLADE_MODES)))
    for mode, (_, direction) in enumerate(BLADE_MODES):
        grow = (contacts.point[on, 1] / height) ** 2
        phi[: 3 * on.sum(), mode] = (grow[:, None] * contacts.axes[on][:, :, direction]).ravel()
        for i, (point, y) in enumerate(zip(points, heights, strict=True)):
            if "xyz".index(point[-1]) == direction:
                phi[3 * on.sum() + i, mode] = (y / height) ** 2
    omega = 2 * np.pi * np.array([frequency for frequency, _ in BLADE_MODES])
    # of (y / height)^2 over the length, as the mass is meant; the other modes do not move across the blade
    momentum = -np.sqrt(mass) * height * np.array([direction == 0 for _, direction in BLADE_MODES])
    return ReducedComponent(name, omega, phi / np.sqrt(mass), LOCAL_FLEXIBILITY * np.eye(len(phi)), points, momentum)


def _damper(rig: Rig, contacts: ContactElements) -> ReducedComponent:
    half_width, bottom = rig.face_bottom
    low = bottom - rig.damper.base_height
    back, front = np.array([0.0, bottom, -rig.blade.width / 2]), np.array([0.0, bottom, rig.blade.width / 2])
    names = [(f"corner_{side}", np.array([x, low, 0.0])) for side, x in (("left", -half_width), ("right", half_width))]
    rows, points = [], []
    for point, place in names:
        for axis in "xy":
            points.append(f"{point}.{axis}")
            rows.append(_rigid(place, bottom)["xyz".index(axis)])
    for end, place in (("back", back), ("front", front)):
        for axis in "xyz":
            points.append(f"wire_{end}.{axis}")
            rows.append(_rigid(place, bottom)["xyz".index(axis)])
    local = np.concatenate([axes @ _rigid(c, bottom) for axes, c in zip(contacts.axes, contacts.point, strict=True)])
    mass = rig.damper_material.density * 1.2e-4 * rig.blade.width
    inertia = mass * np.array([rig.blade.width**2, rig.blade.width**2, (2 * half_width) ** 2]) / 12
    phi = np.vstack([local, rows]) / np.sqrt([mass, mass, mass, *inertia])
    return ReducedComponent("damper", np.zeros(6), phi, LOCAL_FLEXIBILITY * np.eye(len(phi)), tuple(points))


def _rigid(place: np.ndarray, height: float) -> np.ndarray:
    """(3, 6): displacement of a place under translations and rotations about (0, height, 0)."""
    x, y, z = place - np.array([0.0, height, 0.0])
    return np.hstack([np.eye(3), np.array([[0, z, -y], [-z, 0, x], [y, -x, 0]])])
