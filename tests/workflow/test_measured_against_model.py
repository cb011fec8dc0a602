"""Modal constants and questions on units; what is asked of which mistake is in tests/support/broken."""

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from support.jumping_beam import Joint, Mode, swept
from support.two_modes import DRIVE, TIP, swept_arm, two_modes

from updamp.measurement.load import load_measurement
from updamp.measurement.measurement import MeasurementError
from updamp.model.build import modal_model
from updamp.model.rig_files import load_modal
from updamp.workflow.measured_against_model import measured_against_model
from updamp.workflow.modal_constant import modal_fit

RIGS = Path(__file__).parents[2] / "rigs"
DATA = Path(__file__).parents[3] / "shared" / "data" / "brb" / "response_controlled.csv"
F = np.linspace(79.5, 81.5, 60)
W, W0 = 2 * np.pi * F, 2 * np.pi * 80.4


def oscillator(loss_factor: float, constant: complex = 0.5) -> np.ndarray:
    return constant / (W0**2 * (1 + 1j * loss_factor) - W**2)


@pytest.mark.parametrize("loss_factor", [0.001, 0.003, 0.02])
def test_a_modal_constant_is_found_whatever_the_damping(loss_factor: float) -> None:
    found = modal_fit(F, oscillator(loss_factor, -0.5j))
    assert found.constant == pytest.approx(-0.5j, rel=1e-6)
    assert found.pole == pytest.approx(W0**2 * (1 + 1j * loss_factor), rel=1e-9)


def test_it_is_not_told_from_what_is_no_resonance() -> None:
    rng = np.random.default_rng(0)
    noise = rng.standard_normal(60) + 1j * rng.standard_normal(60)
    assert modal_fit(F, noise) is None
    assert modal_fit(F, oscillator(1e-5)) is None, "one point on the peak is not enough"
    assert modal_fit(F, 0 * noise) is None


@pytest.mark.parametrize("upwards", [False, True])
def test_it_is_not_told_from_a_resonance_that_bends_over(upwards: bool) -> None:
    """By a tenth of its width it is told, by one of them and by three, with a jump, it is not: there one side shows a
    straight line of some other slope."""
    beam, softens = Mode(80.4, 0.003, 2.0), Joint(cubic=-2e9)
    f = np.linspace(78.5, 82.0, 100)
    f = f if upwards else f[::-1]
    slight, bent, jumping = (modal_fit(f, swept((beam,), softens, f, force) / force) for force in (0.35, 2.0, 4.0))
    assert slight.constant == pytest.approx(0.5, rel=0.01)
    assert bent is jumping is None


def test_a_real_test_in_the_right_units_is_asked_nothing() -> None:
    if not DATA.is_file():
        pytest.skip(f"{DATA} is missing: the beam's data are under GPL-3.0 and are kept beside the checkout")
    measurement = load_measurement(RIGS / "brake_reuss_measurement.toml", ["beam.drive.x"], rig="brake_reuss")
    assert measured_against_model(modal_model(load_modal(RIGS / "brake_reuss.toml")), measurement) == []


def test_a_sensor_that_looks_the_other_way_is_asked_about() -> None:
    assert measured_against_model(two_modes(), swept_arm()) == []
    assert measured_against_model(two_modes(), swept_arm(tip=np.exp(0.5j))) == [], "a lag is no sign"
    (question,) = measured_against_model(two_modes(), swept_arm(tip=-1.0))
    assert question.startswith("channel 'tip' (run 'first 1 N'): it moves against the model")
    assert "at the resonance at 39.97 Hz" in question
    assert "channels.tip.direction" in question


@pytest.mark.parametrize(
    ("turn", "says"), [(90, "90 degrees ahead of"), (-90, "90 degrees behind"), (110, "110 degrees")]
)
def test_a_quarter_of_a_turn_is_asked_about(turn: float, says: str) -> None:
    """A velocity read as a displacement, or its phase: it was told as a resonance 0.6 % high and damping 13 % high."""
    (question,) = measured_against_model(two_modes(), swept_arm(tip=np.exp(1j * np.radians(turn))))
    assert says in question
    assert "channels.tip.quantity and what its phase is measured against" in question


@pytest.mark.parametrize(("quantity", "gravity"), [("displacement", False), ("acceleration", True)])
def test_a_factor_of_ten_is_one_of_gravity_for_accelerations_alone(quantity: str, gravity: bool) -> None:
    measured = swept_arm(tip=10.0)
    channels = tuple(replace(channel, quantity=quantity) for channel in measured.channels)
    (question,) = measured_against_model(two_modes(), replace(measured, channels=channels))
    assert "the range of an amplifier" in question
    assert ("standard gravity" in question) == gravity


def test_sensors_that_are_exchanged_are_asked_about_in_the_mode_that_tells() -> None:
    """Both move alike in the first mode, whose run comes first, and against each other in the second one."""
    right = swept_arm(modes=("first", "second"))
    assert measured_against_model(two_modes(), right) == []
    runs = tuple(replace(run, response=run.response[::-1]) for run in right.runs)
    signs = [q for q in measured_against_model(two_modes(), replace(right, runs=runs)) if "moves against" in q]
    assert [question.split("'")[1::2][:2] for question in signs] == [["drive", "second 1 N"], ["tip", "second 1 N"]]
    assert all("two sensors, or their phases, exchanged?" in question for question in signs)


def test_a_sensor_that_looks_the_other_way_is_asked_about_once() -> None:
    questions = measured_against_model(two_modes(), swept_arm(tip=-1.0, modes=("first", "second")))
    assert len(questions) == 1


def test_phases_that_run_the_other_way_are_asked_about() -> None:
    questions = measured_against_model(two_modes(), swept_arm(conjugated=True))
    assert [question.split("'")[1] for question in questions] == ["drive", "tip"]
    assert all("its phase rises through the resonance" in question for question in questions)


def test_amplitudes_alone_tell_no_sign() -> None:
    measurement = swept_arm(tip=-1.0)
    runs = tuple(replace(run, without_phase=("tip",)) for run in measurement.runs)
    assert measured_against_model(two_modes(), replace(measurement, runs=runs)) == []


def test_a_model_that_is_excited_elsewhere_is_not_compared() -> None:
    with pytest.raises(MeasurementError, match=f'excitation = "{TIP}": the rig file excites the model at "{DRIVE}"'):
        measured_against_model(two_modes(), swept_arm(excitation=TIP))


def test_a_run_without_its_resonance_is_asked_about() -> None:
    """Measured beside it alone, the end of the window was told as the resonance."""
    (run,) = swept_arm().runs
    top = int(np.argmax(np.abs(run.receptance("drive"))))
    beside = slice(top + 4, None)
    cut = replace(run, frequency=run.frequency[beside], force=run.force[beside], response=run.response[..., beside])
    (question,) = measured_against_model(two_modes(), replace(swept_arm(), runs=(cut,)))
    assert "has no resonance between 40.1" in question
    assert measured_against_model(two_modes(), swept_arm()) == []


def test_a_run_that_is_highest_on_another_mode_s_flank_is_one_of_this_rig() -> None:
    """ "The model can resonate nowhere within 20 % of that": the second mode, from beside the first one on."""
    f = np.linspace(50.0, 104.0, 200)
    w, modes = 2 * np.pi * f, ((40.0, 0.4**2), (97.0, 0.05**2))
    receptance = sum(c / ((2 * np.pi * f0) ** 2 * (1 + 0.01j) - w**2) for f0, c in modes)
    (run,) = swept_arm(modes=("second",)).runs
    response = np.stack([receptance, receptance])[:, None]
    wide = replace(run, frequency=f, force=np.ones(len(f), complex), response=response)
    assert np.abs(receptance).argmax() == 0
    asked = measured_against_model(two_modes(), replace(swept_arm(), runs=(wide,)))
    assert not any("no resonance between" in question for question in asked)


@pytest.mark.parametrize(
    ("factor", "says"), [(np.pi / 180, "radians taken for degrees"), (180 / np.pi, "degrees taken for radians")]
)
def test_a_phase_in_the_wrong_unit_is_asked_about(factor: float, says: str) -> None:
    (run,) = swept_arm().runs
    response = np.abs(run.response) * np.exp(1j * factor * np.unwrap(np.angle(run.response), axis=-1))
    questions = measured_against_model(two_modes(), replace(swept_arm(), runs=(replace(run, response=response),)))
    assert sum(says in question for question in questions) == 2


@pytest.mark.parametrize("loss", [0.04, 0.033])
@pytest.mark.parametrize("noise", [0.0, 0.006])
def test_modes_that_overlap_are_no_reason_to_ask(monkeypatch: pytest.MonkeyPatch, loss: float, noise: float) -> None:
    """Read as one oscillator's, the true constant of the second was 1.9 times the product of the shape's entries: "peak
    to peak taken for peak"; other such pairs were asked about a sign, or a quarter of a turn."""
    modes = {"first": (80.32, loss, 0.8, 1.0), "second": (96.709, loss, 0.6, -1.1)}
    monkeypatch.setattr("support.two_modes.MODES", modes)
    sound, runs, rng = swept_arm(modes=tuple(modes)), [], np.random.default_rng(6)
    for run in sound.runs:
        f = modes[run.mode][0] * np.linspace(0.93, 1.09, 25)
        w = 2 * np.pi * f
        parts = {
            place: sum(
                m[2] * m[place] / ((2 * np.pi * m[0]) ** 2 - w**2 + 2j * m[1] * 2 * np.pi * m[0] * w)
                for m in modes.values()
            )
            for place in (2, 3)
        }
        x = np.stack([parts[2], parts[3]])[:, None] * np.exp(noise * rng.standard_normal((2, 1, 25)))
        runs.append(replace(run, frequency=f, force=np.ones(25, complex), response=x))
    measured = replace(sound, runs=tuple(runs))
    assert measured_against_model(two_modes(), measured) == []
