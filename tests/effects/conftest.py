"""The reference rig with few modes and patches of the real size, as a model that effects may change."""

from dataclasses import replace

import pytest
from support.plain_rig import SHORT_FACES, SLIPPING, plain_model

from updamp.effects.dimension_blend import varied_dimension
from updamp.effects.rig_model import RigModel
from updamp.rig.dimensions import DIMENSIONS

STEP = 0.02


@pytest.fixture(scope="session")
def model() -> RigModel:
    """With what other values of its dimensions change."""
    plain = plain_model(SHORT_FACES, SLIPPING)
    dimensions = {
        name: varied_dimension(plain, plain_model(SHORT_FACES, SLIPPING, (name, STEP)), STEP) for name in DIMENSIONS
    }
    return replace(plain, dimensions=dimensions)
