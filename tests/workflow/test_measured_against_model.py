"""Modal constants and questions on units; what is asked of which mistake is in tests/support/broken."""

from pathlib import Path

import numpy as np
import pytest
from support.jumping_beam import Joint, Mode, swept

from updamp.measurement.load import load_measurement
from updamp.model.build import modal_model
from updamp.model.rig_files import load_modal
from updamp.workflow.measured_against_model import QuestionOptions, measured_against_model, modal_constant

RIGS = Path(__file__).parents[2] / "rigs"
DATA = Path(__file__).parents[3] / "shared" / "data" / "brb" / "response_controlled.csv"
F = np.linspace(79.5, 81.5, 60)
W, W0 = 2 * np.pi * F, 2 * np.pi * 80.4


def oscillator(loss_factor: float, constant: complex = 0.5) -> np.ndarray:
    return constant / (W0**2 * (1 + 1j * loss_factor) - W**2)


@pytest.mark.parametrize("loss_factor", [0.001, 0.003, 0.02])
def test_a_modal_constant_is_found_whatever_the_damping(loss_factor: float) -> None:
    assert modal_constant(F, oscillator(loss_factor), QuestionOptions()) == pytest.approx(0.5, rel=1e-6)


def test_it_is_not_told_from_what_is_no_resonance() -> None:
    rng = np.random.default_rng(0)
    noise = rng.standard_normal(60) + 1j * rng.standard_normal(60)
    assert modal_constant(F, noise, QuestionOptions()) is None
    assert modal_constant(F, oscillator(1e-5), QuestionOptions()) is None, "one point on the peak is not enough"
    assert modal_constant(F, 0 * noise, QuestionOptions()) is None


@pytest.mark.parametrize("upwards", [False, True])
def test_it_is_not_told_from_a_resonance_that_bends_over(upwards: bool) -> None:
    """By a tenth of its width it is told, by one of them and by three, with a jump, it is not: there one side shows a
    straight line of some other slope."""
    beam, softens = Mode(80.4, 0.003, 2.0), Joint(cubic=-2e9)
    f = np.linspace(78.5, 82.0, 100)
    f = f if upwards else f[::-1]
    slight, bent, jumping = (
        modal_constant(f, swept((beam,), softens, f, force) / force, QuestionOptions()) for force in (0.35, 2.0, 4.0)
    )
    assert slight == pytest.approx(0.5, rel=0.01)
    assert bent is jumping is None


def test_a_real_test_in_the_right_units_is_asked_nothing() -> None:
    if not DATA.is_file():
        pytest.skip(f"{DATA} is missing: the beam's data are under GPL-3.0 and are kept beside the checkout")
    measurement = load_measurement(RIGS / "brake_reuss_measurement.toml", ["beam.drive.x"], rig="brake_reuss")
    assert measured_against_model(modal_model(load_modal(RIGS / "brake_reuss.toml")), measurement) == []
