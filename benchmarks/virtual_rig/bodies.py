"""The laboratory's two blades and damper: modes, residual flexibility and rotation about the clamp, kept in a file.

The finite elements are updamp's, on a mesh of their own; nothing of updamp's harmonic balance is used from here on.
"""

import os
import sys
from contextlib import ExitStack
from dataclasses import dataclass, fields
from pathlib import Path
from zipfile import BadZipFile

import numpy as np
from numpy.typing import NDArray

from updamp.fem.component import Component, factorised
from updamp.fem.coupling import coupling_named
from updamp.fem.reduction import ReductionOptions, component_modes, reduce_component
from updamp.fem.rig_components import assemble_rig
from updamp.fem.solvers import solver_named
from updamp.geometry.build_mesh import build_mesh
from updamp.geometry.contact_elements import LEFT, RIGHT, ContactElements
from updamp.geometry.points_of_force import barycentric
from updamp.rig.rig import Rig
from updamp.workflow.code_version import code_version

Floats = NDArray[np.float64]

KEPT = Path(__file__).parents[2] / "results" / "virtual_rig"
# What of the source enters the bodies, and all that the laboratory measures on them.
SOURCE = ("rig", "geometry", "fem", "benchmarks/virtual_rig/bodies.py")
LABORATORY = ("rig", "geometry", "fem", "benchmarks/virtual_rig")
# What of the rig file enters.
SECTIONS = (
    "blade", "platform", "damper", "excitation.height", "response", "reduction", "contact.coupling",
    "material.youngs_modulus", "material.poissons_ratio", "material.density",
)  # fmt: skip
# What of a material of the damper alone does, where the file states one.
OF_DAMPER = ("damper.material.youngs_modulus", "damper.material.poissons_ratio", "damper.material.density")


@dataclass(frozen=True, eq=False)
class Bodies:
    """Right-hand blade (the left one is its mirror image) and damper, as in updamp's ReducedModel.

    blade_omega: (m,) [rad/s]; blade_phi: (3 n / 2 + 4, m) [kg^-1/2]; blade_residual: (3 n / 2 + 4, same) [m/N]
    turning: (3 n / 2 + 4,) displacement of the same rows when the blade turns rigidly about z at its root by one radian
    participation: (m,) of the modes in that [kg^1/2 m]; inertia: about the same axis [kg m^2]
    damper_omega, damper_phi, damper_residual: of the damper, both faces
    face: (n,) 0 left, 1 right; area: (n,) [m^2]
    along, up: (n, 3) places of the patch's corners along the damper (z) and up the face (t1), -1 to 1 at the edges
    point: (n, 3) barycentric coordinates of the place in the patch where its force acts
    blade_points, damper_points: names of the rows after those of the contacts
    mesh: () name of its preset
    """

    blade_omega: Floats
    blade_phi: Floats
    blade_residual: Floats
    turning: Floats
    participation: Floats
    inertia: Floats
    damper_omega: Floats
    damper_phi: Floats
    damper_residual: Floats
    face: NDArray[np.int64]
    area: Floats
    along: Floats
    up: Floats
    point: Floats
    blade_points: NDArray[np.str_]
    damper_points: NDArray[np.str_]
    mesh: NDArray[np.str_]

    def at_points(self, corners: Floats) -> Floats:
        """(n,) of a linear field given at the patches' corners (n, 3), where their forces act."""
        return np.asarray((self.point * corners).sum(axis=1))

    @property
    def preset(self) -> str:
        return str(self.mesh)

    def mirrored(self, rows: Floats) -> Floats:
        """Rows of the right-hand blade for the left one: contact axes are mirrored with it, x of the points is not."""
        sign = np.ones(len(rows))
        n = len(rows) - len(self.blade_points)
        sign[n:] = [-1.0 if point.endswith(".x") else 1.0 for point in self.blade_points]
        return sign.reshape(-1, *[1] * (rows.ndim - 1)) * rows


def bodies_of(rig: Rig, preset: str, kept: Path = KEPT) -> Bodies:
    """From the file where the same code has computed the same; else by finite elements (half a minute), and kept.

    Files of the same rig and mesh that another version of updamp has made are removed.
    """
    stated = (section for section in OF_DAMPER if rig.states(section))
    name = f"{preset}_{rig.digest(*SECTIONS, f'mesh.{preset}', *stated)[:16]}"
    path = kept / f"{name}_{code_version(*SOURCE)[:16]}.npz"
    if path.is_file() and (found := _read(path)) is not None:
        return found
    for stale in kept.glob(f"{name}_*.npz"):
        print(f"{stale}: made by another version of updamp, or damaged; made anew", file=sys.stderr)
        stale.unlink(missing_ok=True)
    bodies = computed(rig, preset)
    kept.mkdir(parents=True, exist_ok=True)
    partial = path.with_suffix(f".{os.getpid()}.partial")
    with partial.open("wb") as file:
        np.savez(file, **{f.name: getattr(bodies, f.name) for f in fields(bodies)})
    partial.replace(path)
    return bodies


def _read(path: Path) -> Bodies | None:
    """None where the file is damaged."""
    try:
        with path.open("rb") as file, np.load(file) as arrays:
            return Bodies(**{name: arrays[name] for name in arrays.files})
    except (OSError, ValueError, TypeError, KeyError, EOFError, BadZipFile):
        return None


def computed(rig: Rig, preset: str) -> Bodies:
    """By finite elements on the mesh of that name."""
    mesh = build_mesh(rig, preset)
    blade, damper = assemble_rig(mesh, rig, coupling_named(rig.contact.coupling))
    options = ReductionOptions(rig.reduction.modes)
    with ExitStack() as held:
        on_root, floating = (
            held.enter_context(factorised(p, solver_named(rig.reduction.solver))) for p in (blade, damper)
        )
        modes = component_modes(on_root, options)
        right = reduce_component(on_root, modes, options)
        loose = reduce_component(floating, component_modes(floating, options), options)
    turning = rigid_turn(blade, rig.blade.axis_offset)
    momentum = blade.matrices.mass @ turning
    contacts = mesh.contacts
    return Bodies(
        blade_omega=right.omega,
        blade_phi=right.phi,
        blade_residual=right.residual,
        turning=blade.interface.operator.T @ turning,
        participation=modes.phi.T @ momentum,
        inertia=np.array(turning @ momentum),
        damper_omega=loose.omega,
        damper_phi=loose.phi,
        damper_residual=loose.residual,
        face=contacts.face,
        area=contacts.area,
        along=contacts.triangle[:, :, 2] / (rig.blade.width / 2),
        up=up_the_face(contacts),
        point=barycentric(contacts.triangle, contacts.point),
        blade_points=np.array(right.points),
        damper_points=np.array(loose.points),
        mesh=np.array(preset),
    )


def rigid_turn(blade: Component, axis: float) -> Floats:
    """(n_dofs,) of a rigid rotation about z through (x, y) = (axis, 0) by one radian: (-y, x - axis, 0)."""
    nodes = blade.mesh.nodes[blade.matrices.free_nodes]
    return np.column_stack([-nodes[:, 1], nodes[:, 0] - axis, np.zeros(len(nodes))]).ravel()


def up_the_face(contacts: ContactElements) -> Floats:
    """(n, 3) of the corners, -1 at the lower edge and 1 at the upper one."""
    place = np.empty((len(contacts), 3))
    for side in (LEFT, RIGHT):
        here = contacts.face == side
        corners = contacts.triangle[here] @ contacts.tangent1[here][0]
        place[here] = 2 * (corners - corners.min()) / (corners.max() - corners.min()) - 1
    return place
