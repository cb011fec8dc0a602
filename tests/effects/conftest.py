"""The reference rig with few modes and patches of the real size, as a model that effects may change."""

from dataclasses import replace
from pathlib import Path

import pytest
from support.plain_rig import plain_model

from updamp.effects.dimension_blend import varied_dimension
from updamp.effects.rig_model import RigModel
from updamp.rig.dimensions import DIMENSIONS

RIG_FILE = Path(__file__).parents[1] / "data" / "short_faces.toml"
# The law that takes its events at the samples compiles ten times as fast; low friction, so that contacts slip.
CHANGES = {
    "contact.law": "jenkins_box_sampled",
    "contact.friction_coefficient": 0.15,
    "harmonic_balance.harmonics": [1, 2, 3],
    "harmonic_balance.time_samples": 64,
}
STEP = 0.02


@pytest.fixture(scope="session")
def model() -> RigModel:
    """With what other values of its dimensions change."""
    plain = plain_model(RIG_FILE, CHANGES)
    dimensions = {
        name: varied_dimension(plain, plain_model(RIG_FILE, CHANGES, (name, STEP)), STEP) for name in DIMENSIONS
    }
    return replace(plain, dimensions=dimensions)
