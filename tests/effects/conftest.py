"""The reference rig with few modes and patches of the real size, as a model that effects may change."""

from pathlib import Path

import pytest
from support.plain_rig import plain_reduced_model

from updamp.effects.rig_model import RigModel
from updamp.fem.static_contact.static_contact import static_contact
from updamp.geometry.build_mesh import build_mesh
from updamp.model.build import rig_model
from updamp.model.rig_files import load_rig

RIG_FILE = Path(__file__).parents[1] / "data" / "short_faces.toml"
# The law that takes its events at the samples compiles ten times as fast; low friction, so that contacts slip.
CHANGES = {
    "contact.law": "jenkins_box_sampled",
    "contact.friction_coefficient": 0.15,
    "harmonic_balance.harmonics": [1, 2, 3],
    "harmonic_balance.time_samples": 64,
}


@pytest.fixture(scope="session")
def model() -> RigModel:
    rig = load_rig(RIG_FILE, CHANGES)
    reduced = plain_reduced_model(rig, build_mesh(rig, "small").contacts)
    return rig_model(reduced, static_contact(reduced, rig), rig)
