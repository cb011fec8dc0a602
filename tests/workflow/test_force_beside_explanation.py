"""The missing force is read beside the calibration that goes with what is named."""

import re
from types import SimpleNamespace

import numpy as np
import pytest
from support.small_model import synthetic_plan
from support.two_modes import DRIVE, TIP, two_modes

from updamp.comparison.fit.compared import compare_at, predict_branches
from updamp.comparison.prediction.branch_tasks import in_turn
from updamp.comparison.prediction.parameters import Parametrisation
from updamp.comparison.prediction.run_condition import RunCondition
from updamp.diagnosis.candidate_models.baseline import baseline
from updamp.diagnosis.criteria import Criteria
from updamp.diagnosis.decision.decide import decide
from updamp.diagnosis.missing_force.missing_force import missing_forces
from updamp.diagnosis.selection.search import search
from updamp.effects.catalogue import JOINTS
from updamp.workflow.diagnose_run import _forces

DRAG = 20.0  # N s^2/m^2


def runs(drag, noise, *points):
    """Of a drag at the drive, from one assembly, measured at these points"""
    deviations = (2e-6, *2 * len(points) * (noise,))
    conditions = tuple(
        RunCondition(f"{f:g} N", "first", f, True, (39.0, 41.0), tuple((p, 1) for p in points), noise=deviations)
        for f in (0.5, 2.0, 8.0)
    )
    truth = Parametrisation(JOINTS["joint_quadratic"].apply(two_modes(), {"coefficient": drag}), ())
    return synthetic_plan(truth, np.zeros(0), conditions, np.zeros(0), seed=4, noise=noise, repeats=1)[0]


@pytest.fixture(scope="module")
def found():
    plan = runs(DRAG, 0.005, DRIVE, TIP)
    return search(baseline(two_modes(), (), plan, {}), (JOINTS["joint_quadratic"],), Criteria())


def test_a_drag_is_read_with_its_size(found):
    """Calibration without it raises the loss factor by a share that first order does not give back."""
    base = found.baseline.fitted
    taken_up = base.u[base.parametrisation.names.index("loss_factor")]
    assert taken_up > 0.05
    decision = decide(found.evidence, Criteria())
    assert decision.effects == ("joint_quadratic",)
    (force,) = _forces(found, decision, in_turn)
    assert size(force.reading) == pytest.approx(DRAG, rel=0.05)
    unnamed = SimpleNamespace(outcome="unknown", effects=(), group=(), trial=None)
    (beside_base,) = _forces(found, unnamed, in_turn)
    assert abs(size(beside_base.reading) - DRAG) > abs(size(force.reading) - DRAG)


def test_no_gain_makes_up_for_the_force_that_is_read():
    """Of one sensor and one assembly, the calibration known: what the model lacks had counted for nothing when the gain
    was found, which was taken for a tenth off, where a hundredth is stated, and the drag for a tenth less."""
    start = baseline(two_modes(), (), runs(3 * DRAG, 0.001, DRIVE), {}, held_out=[])
    p, plan, scatter = start.fitted.parametrisation, start.plan, start.fitted.compared.scatter
    u = np.zeros(len(p))
    (force,) = missing_forces(compare_at(p, u, plan, predict_branches(p, u, plan), scatter), p, plan)
    assert size(force.reading) == pytest.approx(3 * DRAG, rel=0.02)


def size(reading):
    """At the channel that is told, seen from the drive: a force and a motion there are r and 1/r times those at the
    drive, r the ratio of the shapes."""
    value = float(re.search(r"or ([0-9.e+-]+) ", reading).group(1))
    ratio = 1.5 / 0.4 if f"at {TIP}" in reading else 1.0
    return value * ratio**3
