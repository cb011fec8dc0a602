from pathlib import Path

import pytest

from updamp.geometry.build_mesh import build_mesh
from updamp.geometry.rig_mesh import RigMesh
from updamp.model.rig_files import load_rig
from updamp.rig.rig import Rig

RIG_FILE = Path(__file__).parents[1] / "data" / "short_faces.toml"


@pytest.fixture(scope="session")
def rig() -> Rig:
    return load_rig(RIG_FILE)


@pytest.fixture(scope="session")
def rig_file() -> Path:
    return RIG_FILE


@pytest.fixture(scope="session")
def small(rig: Rig) -> RigMesh:
    return build_mesh(rig, "small")


@pytest.fixture(scope="session")
def full(rig: Rig) -> RigMesh:
    return build_mesh(rig, "full")
