"""Boxes, steel, and the reference rig on a mesh of its own, small enough to solve directly."""

from dataclasses import dataclass
from pathlib import Path

import numpy as np
import pytest
import skfem
from skfem.io.meshio import HEX_MAPPING

from updamp.geometry.build_mesh import build_mesh
from updamp.geometry.rig_mesh import ComponentMesh, RigMesh
from updamp.model.rig_files import load_rig
from updamp.rig.mesh_divisions import MeshDivisions
from updamp.rig.rig import Rig

RIG_FILE = Path(__file__).parents[1] / "data" / "short_faces.toml"


@dataclass(frozen=True)
class Elastic:
    youngs_modulus: float = 197e9
    poissons_ratio: float = 0.3
    density: float = 7800.0


def make_box(divisions: tuple[int, int, int], size: tuple[float, float, float]) -> ComponentMesh:
    """A box with one corner at the origin; faces "root" (y = 0) and "top", point "corner" at the opposite corner."""
    mesh = skfem.MeshHex.init_tensor(
        *(np.linspace(0, length, n + 1) for n, length in zip(divisions, size, strict=True))
    )

    def face(height: float) -> np.ndarray:
        found = mesh.facets_satisfying(lambda x: np.abs(x[1] - height) < 1e-9)
        return mesh.facets[:, found].T.astype(np.int64)

    vertices = np.ascontiguousarray(mesh.p.T)
    hexahedra = mesh.t.T[:, HEX_MAPPING[:8]].astype(np.int64)
    corner = int(vertices.sum(axis=1).argmax())
    return ComponentMesh("box", vertices, hexahedra, {"root": face(0), "top": face(size[1])}, {"corner": corner})


@pytest.fixture(scope="session")
def steel() -> Elastic:
    return Elastic()


@pytest.fixture(scope="session")
def elastic() -> type[Elastic]:
    return Elastic


@pytest.fixture(scope="session")
def box():
    return make_box


@pytest.fixture(scope="session")
def reference_rig() -> Rig:
    """The reference rig with a mesh "tiny" of 204 elements a blade and 8 contact elements."""
    rig = load_rig(RIG_FILE)
    divisions = rig.mesh["small"].model_dump() | {
        "width": 4,
        "face": 2,
        "platform_outer": 1,
        "platform_height": 2,
        "stem_above_platform": 8,
        "stem_top": 2,
        "damper_across": 3,
        "contact_elements": 8,
    }
    return rig.model_copy(update={"mesh": {**rig.mesh, "tiny": MeshDivisions(**divisions)}})


@pytest.fixture(scope="session")
def tiny_mesh(reference_rig: Rig) -> RigMesh:
    return build_mesh(reference_rig, "tiny")


@pytest.fixture(scope="session")
def small_mesh(reference_rig: Rig) -> RigMesh:
    return build_mesh(reference_rig, "small")
