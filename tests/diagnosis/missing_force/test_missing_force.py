"""The missing force of hidden elements is read back: its kind, its size, and where there is none."""

from dataclasses import replace

import jax.numpy as jnp
import numpy as np
import pytest
from support.amplitude_damper import AmplitudeDamper, AmplitudeDamperParameters
from support.small_model import condition, small_model, synthetic_plan

from updamp.comparison.fit.compared import compare_at, predict_branches
from updamp.comparison.fit.observations import Plan
from updamp.comparison.fit.scatter import Scatter
from updamp.comparison.fit.shape_error import ShapeError
from updamp.comparison.prediction.parameters import Parametrisation
from updamp.diagnosis.missing_force.missing_force import missing_forces
from updamp.effects.rig_model import PointElement
from updamp.hbm.contact.springs import CubicParameters, CubicSpring
from updamp.hbm.problem.structural_changes import Attachment
from updamp.model.calibration import FRICTION, PRELOAD

# the contact sticks at 10 N, and slips in all of the resonance at 60 N
CONDITIONS = (condition(10.0), condition(60.0, upwards=False))
# stiffness and damping of the material are known: a calibration would take up springs and dashpots
KNOWN = (FRICTION, PRELOAD)
SCATTER = np.array([n.scatter for n in KNOWN])


MODEL = Parametrisation(small_model(), KNOWN)


@pytest.fixture(scope="module")
def missing():
    """What is read off data of a hidden model with the plain small model."""
    empty = Plan(CONDITIONS, ())
    branches = predict_branches(MODEL, np.zeros(2), empty)
    scatter = Scatter({n.name: n.scatter for n in KNOWN}, drift=5e-5, gain=0.005)

    def read(hidden, repeats=2, shape_known=True):
        truth = Parametrisation(hidden, KNOWN)
        plan, _ = synthetic_plan(truth, np.zeros(2), CONDITIONS, SCATTER, seed=3, repeats=repeats)
        if not shape_known:
            plan = replace(plan, observations=tuple(replace(o, shapes=whole(o)) for o in plan.observations))
        (found,) = missing_forces(compare_at(MODEL, np.zeros(2), plan, branches, scatter), MODEL, plan)
        assert found.mode == "first"
        return found

    return read


def whole(o):
    """Each sensor reads a mode alone whose shape is not well known there."""
    return tuple(ShapeError(0.5, np.ones(len(o), dtype=complex)) for _ in range((o.observed.shape[1] - 1) // 2))


def attached(**values):
    return replace(small_model(), attachments=(Attachment("hidden", {"a.x": 1.0}, **values),))


def with_element(law, parameters):
    return replace(small_model(), elements=(PointElement("hidden", ("a.x",), law, parameters),))


def within(value, deviation, expected, relative):
    """All pieces together, and no piece further off than noise and the linearisation of its assembly's offsets."""
    expected = np.broadcast_to(expected, value.shape)
    weights = 1 / deviation**2
    mean = np.sum(weights * (value - expected)) / np.sum(weights)
    assert abs(mean) < relative * np.abs(expected).max()
    assert np.all(np.abs(value - expected) < 4 * deviation + 2 * relative * np.abs(expected).max())


def test_where_nothing_is_hidden_nothing_is_missing(missing):
    found = missing(small_model())
    assert found.reading.startswith("nothing is missing"), found.reading
    normal = np.concatenate([found.stiffness / found.stiffness_deviation, found.damping / found.damping_deviation])
    assert np.sqrt(np.mean(normal**2)) < 1.7  # repeats share offsets, so pieces are not independent


def test_a_hidden_spring_with_a_dashpot(missing):
    found = missing(attached(stiffness=300.0, dashpot=1.0))
    stiffness, damping = found.reading.split("; ")
    assert stiffness.startswith("stiffness is missing")
    assert "as of a spring" in stiffness
    assert damping.startswith("damping is missing")
    assert "as of a viscous damper" in damping
    within(found.stiffness, found.stiffness_deviation, 300.0, 0.05)
    within(found.damping, found.damping_deviation, 1.0, 0.05)


def test_of_a_shape_that_is_not_well_known_the_points_that_tell_of_the_mode_are_taken(missing):
    """24 of 40, of what an error of the shape does too."""
    found = missing(attached(stiffness=300.0, dashpot=1.0), shape_known=False)
    within(found.stiffness, found.stiffness_deviation, 300.0, 0.05)
    within(found.damping, found.damping_deviation, 1.0, 0.05)


def test_a_hidden_mass_is_read_as_stiffness_below_zero_and_weighed(missing):
    found = missing(attached(mass=0.005))
    grams = float(found.reading.split("mass of ")[1].split()[0])
    assert grams == pytest.approx(5.0, rel=0.05)
    within(found.stiffness, found.stiffness_deviation, -0.005 * (2 * np.pi * 42) ** 2, 0.08)


def test_a_hidden_cubic_spring(missing):
    coefficient = 1e6
    # two repeats tell the square from the power 1.5 by 8 to 13 in BIC, where 10 are asked for
    found = missing(with_element(CubicSpring(), CubicParameters(coefficient * jnp.ones(1))), repeats=4)
    assert "cubic spring" in found.reading
    assert "these data" not in found.reading
    assert float(found.reading.split("cubic spring of ")[1].split()[0]) == pytest.approx(coefficient, rel=0.1)
    within(found.stiffness, found.stiffness_deviation, 0.75 * coefficient * found.amplitude**2, 0.05)


def test_a_hidden_quadratic_damper(missing):
    coefficient = 200.0
    found = missing(with_element(AmplitudeDamper(), AmplitudeDamperParameters(coefficient * jnp.ones(1))))
    assert found.reading.startswith("damping is missing in proportion to amplitude")
    assert float(found.reading.split("a.x: ")[1].split()[0]) == pytest.approx(coefficient, rel=0.05)
    within(found.damping, found.damping_deviation, 4 / (3 * np.pi) * coefficient * found.amplitude, 0.05)
