"""Effects of a joint in a model of identified modes: nothing at null, felt as their formulas say, refused elsewhere."""

from dataclasses import replace
from pathlib import Path

import numpy as np
import pint
import pytest
from scipy.interpolate import CubicHermiteSpline

from updamp.comparison.prediction.parameters import Parametrisation
from updamp.comparison.prediction.predicted_branch import PredictedBranch
from updamp.comparison.prediction.run_condition import HeldResponse, RunCondition
from updamp.comparison.prediction.traced_branch import trace_branch
from updamp.effects.catalogue import CATALOGUE, JOINTS
from updamp.effects.rig_model import RigModel
from updamp.model.build import modal_model
from updamp.model.calibration import nuisances
from updamp.model.rig_files import load_modal

UNITS = pint.get_application_registry()  # one for all: to make one takes half a second

NAMES = (
    "joint_viscous", "joint_viscoelastic", "joint_square", "joint_cubic", "joint_quintic", "joint_clearance",
    "joint_quadratic", "joint_cubic_damping", "joint_friction", "joint_slider", "joint_microslip",
)  # fmt: skip
POINT = "beam.drive.x"
FORCED = RunCondition("forced", "first", 0.2, True, (79.0, 81.5), ((POINT, 1),))
LEVEL = 40.0  # m/s^2
HELD = replace(FORCED, name="held", control=HeldResponse(POINT, LEVEL, 2))
MASS, ETA = 2.0, 0.0031  # of rigs/brake_reuss.toml


@pytest.fixture(scope="module")
def beam() -> RigModel:
    return modal_model(load_modal(Path(__file__).parents[2] / "rigs" / "brake_reuss.toml"))


def branch(beam: RigModel, name: str, share: float, condition: RunCondition) -> PredictedBranch:
    """share: of all the effect's parameters, from null to typical"""
    p = Parametrisation(beam, nuisances(beam), (JOINTS[name],))
    u = np.zeros(len(p))
    u[len(p.nuisances) :] = share
    return trace_branch(p, u, condition)


def peak(found: PredictedBranch) -> tuple[float, float]:
    """Frequency [Hz] and receptance [m/N]"""
    dense = np.linspace(found.place[0], found.place[-1], 20000)
    value = found.at(dense).value
    top = int(np.argmax(value[:, 1]))
    return float(np.exp(value[top, 0])), float(np.exp(value[top, 1])) / found.condition.force


def test_names_and_parameters() -> None:
    assert tuple(JOINTS) == NAMES
    assert not set(JOINTS) & set(CATALOGUE)
    for effect in JOINTS.values():
        for p in effect.parameters:
            assert p.lower <= p.null <= p.upper
            assert p.lower <= p.typical <= p.upper
            assert p.typical != p.null
            assert p.source
            unit = UNITS.parse_units(p.unit)
            assert (1 * unit).to_base_units().magnitude == pytest.approx(1)


@pytest.mark.parametrize("name", NAMES)
@pytest.mark.parametrize("condition", [FORCED, HELD], ids=["forced", "held"])
def test_at_null_it_is_the_linear_mode(beam: RigModel, name: str, condition: RunCondition) -> None:
    found = branch(beam, name, 0.0, condition)
    w, w0 = 2 * np.pi * found.frequency, 2 * np.pi * 80.38
    expected = condition.force / MASS / (w0**2 * (1 + 1j * ETA) - w**2)
    np.testing.assert_allclose(found.amplitude[:, 0], expected, rtol=1e-7)


@pytest.mark.parametrize("name", NAMES)
def test_slopes_are_those_of_branches_traced_anew(beam: RigModel, name: str) -> None:
    """With the response held, at the typical size; at the same frequency, as changes of the receptance."""
    p = Parametrisation(beam, nuisances(beam), (JOINTS[name],))
    u = np.append(np.zeros(len(p.nuisances)), np.ones(len(p) - len(p.nuisances)))
    found = trace_branch(p, u, HELD)
    h, inside = 1e-3, (found.frequency > 79.2) & (found.frequency < 81.3)
    own = CubicHermiteSpline(found.state[:, 0], found.state[:, 1:], found.along[:, 1:] / found.along[:, :1])
    for j in range(len(p)):
        moved = trace_branch(p, u + h * np.eye(len(p))[j], HELD)
        new = CubicHermiteSpline(moved.state[:, 0], moved.state[:, 1:], moved.along[:, 1:] / moved.along[:, :1])
        predicted = found.state + h * found.slopes[:, j]
        change = (predicted[:, 1:] - own(predicted[:, 0]))[inside]
        expected = (new(predicted[:, 0]) - own(predicted[:, 0]))[inside]
        assert np.linalg.norm(change - expected) < 0.01 * np.linalg.norm(expected)
        assert np.linalg.norm(expected) > 1e-2 * h * np.linalg.norm(found.state[:, 1:])


def test_slope_by_the_level_is_what_a_higher_level_does(beam: RigModel) -> None:
    found = branch(beam, "joint_quadratic", 1.0, HELD)
    h = 1e-3
    higher = replace(HELD, control=HeldResponse(POINT, LEVEL * np.exp(h), 2))
    assert HELD.control is not None
    moved = branch(beam, "joint_quadratic", 1.0, higher)
    i = int(np.argmax(np.abs(found.amplitude[:, 0])))
    new = np.interp(found.state[i, 0], moved.state[:, 0], np.abs(moved.amplitude[:, 0]))
    ahead = found.state[i, 1:] + h * found.slopes[i, -1, 1:]
    assert np.hypot(*ahead) == pytest.approx(new, rel=2e-4)
    assert np.hypot(*ahead) < 0.9997 * np.abs(found.amplitude[i, 0])


@pytest.mark.parametrize(
    ("name", "stiffness", "dashpot"),
    [
        ("joint_viscous", 0.0, 2.0),
        ("joint_square", 8 / (3 * np.pi) * 1e7, 0.0),
        ("joint_cubic", 0.75 * 1e11, 0.0),
        ("joint_quintic", 0.625 * 1e19, 0.0),
        ("joint_clearance", 5e3, 0.0),
        ("joint_quadratic", 0.0, 8 / (3 * np.pi) * 50.0),
        ("joint_cubic_damping", 0.0, 0.75 * 1e3),
        ("joint_friction", 0.0, 4 / np.pi * 0.1),
        ("joint_viscoelastic", 5e3, 0.0),
        ("joint_slider", -5e3, 4 * 5e3 / np.pi),
    ],
)
def test_resonance_at_a_held_level_is_that_of_the_equivalent_mode(
    beam: RigModel, name: str, stiffness: float, dashpot: float
) -> None:
    """stiffness, dashpot: equivalent ones at this amplitude; those of the springs per A, A^2 and A^4, of a clearance
    far beyond the gap, of the quadratic damper per w A, of the cubic one per its square, of dry friction over w A, the
    viscoelastic layer's as k i w tau / (1 + i w tau); of a slider the stiffness lost far beyond where it slips."""
    f, receptance = peak(branch(beam, name, 1.0, HELD))
    w = 2 * np.pi * f
    amplitude = LEVEL / w**2
    stiffness *= amplitude ** {"joint_square": 1, "joint_cubic": 2, "joint_quintic": 4}.get(name, 0)
    if name == "joint_clearance":
        t = np.arccos(5e-5 / amplitude)
        stiffness *= 2 / np.pi * (t - np.sin(t) * np.cos(t))
    if name == "joint_slider":
        slip = 5e-5 / amplitude
        t = np.arccos(1 - 2 * slip)
        stiffness *= 1 - (t - np.sin(t) * np.cos(t)) / np.pi
        dashpot *= slip * (1 - slip) / w
    dashpot *= (w * amplitude) ** {"joint_quadratic": 1, "joint_cubic_damping": 2, "joint_friction": -1}.get(name, 0)
    added = complex(stiffness, w * dashpot)
    if name == "joint_viscoelastic":
        added = stiffness * 1j * w * 1e-3 / (1 + 1j * w * 1e-3)
    k = MASS * (2 * np.pi * 80.38) ** 2
    assert f == pytest.approx(np.sqrt((k + added.real) / MASS) / (2 * np.pi), rel=3e-5)
    assert receptance == pytest.approx(1 / (k * ETA + added.imag), rel=2e-3)


def test_microslip_softens_and_damps_as_masings_loop_does(beam: RigModel) -> None:
    """Of a uniform distribution (chi = 0): C = lost / AT; loop area 4/3 C A^3, stiffness lost to the first harmonic
    C A."""
    values = {"stiffness_lost": 2e3, "exponent": 0.0}
    model = JOINTS["joint_microslip"].apply(beam, values)
    f, receptance = peak(trace_branch(Parametrisation(model, ()), np.zeros(0), HELD))
    amplitude = LEVEL / (2 * np.pi * f) ** 2
    C, k = 2e3 / 1e-4, MASS * (2 * np.pi * 80.38) ** 2
    assert f == pytest.approx(80.38 * np.sqrt(1 - C * amplitude / k), rel=5e-5)
    assert receptance == pytest.approx(1 / (k * ETA + 4 / (3 * np.pi) * C * amplitude), rel=0.01)


@pytest.mark.parametrize("name", NAMES)
def test_refused_where_there_are_contacts_and_where_modes_were_computed(
    model: RigModel, beam: RigModel, name: str
) -> None:
    effect = JOINTS[name]
    for values in (effect.at_null(), effect.at_typical()):
        with pytest.raises(ValueError, match="this model has contacts of its own"):
            effect.apply(model, values)
        with pytest.raises(ValueError, match="were computed"):
            effect.apply(replace(beam, identified=False), values)


@pytest.mark.parametrize("name", [name for name in CATALOGUE if name != "shaker_attachment"])
def test_effects_of_bladed_rigs_are_refused_by_a_beam(beam: RigModel, name: str) -> None:
    """They need contacts, blades, tips, wires or the zero harmonic, and say which."""
    with pytest.raises((ValueError, KeyError), match=r"contact|blade|wire|harmonic|tip|damper"):
        _ = CATALOGUE[name].apply(beam, CATALOGUE[name].at_typical()).system


def test_all_joints_stack(beam: RigModel) -> None:
    stacked = beam
    for effect in JOINTS.values():
        stacked = effect.apply(stacked, effect.at_null())
    found = trace_branch(Parametrisation(stacked, ()), np.zeros(0), HELD)
    assert peak(found)[0] == pytest.approx(80.38, rel=1e-5)
