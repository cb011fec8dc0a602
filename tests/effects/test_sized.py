"""Effects of a joint sized for the rig at hand."""

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from updamp.effects.catalogue import CATALOGUE, OWN
from updamp.effects.sized import sized
from updamp.model.build import modal_before_effects
from updamp.model.rig_files import load_modal

BEAM = modal_before_effects(load_modal(Path(__file__).parents[2] / "rigs" / "brake_reuss.toml"))
# The same in other units: forces a millionth, lengths a thousandth, frequencies twice.
FORCE, LENGTH, FREQUENCY = 1e-6, 1e-3, 2.0


def smaller():
    c = BEAM.components
    mass = FORCE / LENGTH / FREQUENCY**2
    changed = replace(c, omega_squared=c.omega_squared * FREQUENCY**2, phi=c.phi / np.sqrt(mass))
    return replace(BEAM, components=changed)


@pytest.mark.parametrize(
    ("effect", "parameter", "factor"),
    [
        ("joint_cubic", 0, FORCE / LENGTH**3),
        ("joint_square", 0, FORCE / LENGTH**2),
        ("joint_quintic", 0, FORCE / LENGTH**5),
        ("joint_clearance", 0, FORCE / LENGTH),
        ("joint_clearance", 1, LENGTH),
        ("joint_quadratic", 0, FORCE / (LENGTH * FREQUENCY) ** 2),
        ("joint_cubic_damping", 0, FORCE / (LENGTH * FREQUENCY) ** 3),
        ("joint_friction", 0, FORCE),
        ("joint_microslip", 0, FORCE / LENGTH),
        ("joint_microslip", 1, 1.0),
        ("feed_through", 0, LENGTH / FORCE),
        ("sensor_compression", 0, LENGTH**-2),
        ("sensor_delay", 0, 1 / FREQUENCY),
        ("joint_viscous", 0, FORCE / LENGTH / FREQUENCY),
        ("joint_viscoelastic", 0, FORCE / LENGTH),
        ("joint_viscoelastic", 1, 1 / FREQUENCY),
    ],
)
def test_sizes_and_bounds_change_as_the_units_do(effect: str, parameter: int, factor: float) -> None:
    """factor: of the parameter's own dimension"""
    before, after = (sized(OWN[effect], m, a).parameters[parameter] for m, a in ((BEAM, 2e-4), (smaller(), 2e-7)))
    for value in ("typical", "lower", "upper"):
        assert getattr(after, value) == pytest.approx(factor * getattr(before, value))


def test_effects_that_do_not_say_what_they_grow_with_stay() -> None:
    assert sized(CATALOGUE["shaker_attachment"], BEAM, 1e-4) is CATALOGUE["shaker_attachment"]
