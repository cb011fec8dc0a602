"""A delay of all responses, which turns the phase of each mode by another angle: told by itself, not as an angle."""

from dataclasses import replace

import numpy as np
import pytest
from support.two_modes import swept_arm, swept_levels, two_modes

from updamp.comparison.compare import compare
from updamp.comparison.comparison import Comparison
from updamp.effects.rig_model import RigModel
from updamp.measurement.measurement import Channel, MeasuredRun, Measurement
from updamp.model.build import modal_model
from updamp.rig.modal_rig import ModalRig

POINT, MASS, LOSS = "arm.drive.x", 2.0, 0.01
LOW, HIGH = 50.0, 500.0


def arm() -> RigModel:
    modes = {
        f"mode_{f:g}": {"frequency": f"{f} Hz", "loss_factor": LOSS, "modal_mass": f"{MASS} kg", "shape": {POINT: 1.0}}
        for f in (LOW, HIGH)
    }
    return modal_model(ModalRig.model_validate({"kind": "modal", "name": "arm", "excitation": POINT, "modes": modes}))


def measured(delay: float, angle: float = 0.0) -> Measurement:
    """Two levels a mode, noise of 0.3 %, all of it late by the delay [s] and lagging by the angle [rad]. No code of
    updamp."""
    rng, runs = np.random.default_rng(11), []
    for mode in (LOW, HIGH):
        f = mode * np.linspace(0.98, 1.02, 41)
        w = 2 * np.pi * f
        receptance = sum(1 / MASS / ((2 * np.pi * f0) ** 2 * (1 + 1j * LOSS) - w**2) for f0 in (LOW, HIGH))
        for force in (1.0, 4.0):
            x = force * receptance * np.exp(-1j * (w * delay + angle))
            x = x * (1 + 0.003 / np.sqrt(2) * (rng.standard_normal(41) + 1j * rng.standard_normal(41)))
            drive = np.full(41, force + 0j)
            name = f"mode_{mode:g}"
            runs.append(
                MeasuredRun(f"{name} {force:g} N", name, True, "force", force, 1, ("a",), (1,), f, drive, x[None, None])
            )
    return Measurement("arm", 0.0, POINT, (Channel("a", POINT),), tuple(runs), repeatability=0.003)


def of_arm(measurement: Measurement) -> Comparison:
    return compare(arm(), measurement)[0]


@pytest.mark.parametrize("delay", [3e-4, -1e-4])
def test_a_delay_is_told_and_nothing_else(delay: float) -> None:
    (finding,) = of_arm(measured(delay)).findings
    assert (finding.quantity, finding.mode, finding.level) == ("phase", "", None)
    assert finding.relative == pytest.approx(delay, abs=1e-6)
    side = "lag" if delay > 0 else "lead"
    assert f"measured phases {side} the model's by {1e3 * abs(delay):.3g} ms in all runs" in finding.text


def test_an_angle_of_all_modes_is_no_delay() -> None:
    (finding,) = of_arm(measured(0.0, np.radians(5))).findings
    assert np.degrees(finding.relative) == pytest.approx(5, abs=0.1)
    assert "5.0 degrees in all runs" in finding.text


def test_without_a_delay_none_is_told() -> None:
    assert of_arm(measured(0.0)).findings == ()


@pytest.mark.parametrize("lag", [0.3, -0.1])
def test_one_sensor_that_lags_is_named_and_its_phases_left_out(lag: float) -> None:
    """ "Resonance 0.08 % low" was told, with which calibration made up for half of it, and none was off."""
    (finding,) = compare(two_modes(), swept_levels(*[(1.0, np.exp(-1j * lag))] * 3))[0].findings
    assert (finding.quantity, finding.mode, finding.level, finding.channel) == ("phase", "", None, "tip")
    assert finding.relative == pytest.approx(lag, rel=0.1)
    side = "lag" if lag > 0 else "lead"
    assert finding.text.startswith(f"tip: its phases {side} the model's by ")
    assert "in all runs, and the other sensors do not" in finding.text


def test_one_sensor_that_is_delayed_is_told_the_time() -> None:
    """4.3 degrees in the one mode and 10.5 in the other: "7.4 degrees in all runs" holds in none."""
    sound, rng = swept_arm(modes=("first", "second")), np.random.default_rng(5)
    runs = []
    for run in sound.runs:
        late = np.stack([np.ones(len(run)), np.exp(-2j * np.pi * run.frequency * 3e-4)])[:, None]
        noise = rng.standard_normal((2, *run.response.shape))
        runs.append(replace(run, response=run.response * late * np.exp(0.003 * (noise[0] + 1j * noise[1]))))
    (finding,) = compare(two_modes(), replace(sound, runs=tuple(runs), repeatability=0.003))[0].findings
    assert (finding.quantity, finding.channel) == ("phase", "tip")
    assert "ms in all runs, and the other sensors do not" in finding.text
    assert finding.relative == pytest.approx(3e-4, rel=0.15)


def test_sensors_that_lag_alike_are_no_ones_own() -> None:
    (finding,) = compare(two_modes(), swept_levels(*[(np.exp(-0.2j), np.exp(-0.2j))] * 3))[0].findings
    assert (finding.quantity, finding.channel) == ("phase", "")
