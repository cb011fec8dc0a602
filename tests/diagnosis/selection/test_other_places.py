"""A joint that is not where the shaker is: two modes tell its place."""

from dataclasses import replace

import numpy as np
import pytest
from support.small_model import synthetic_plan
from support.two_modes import DRIVE, TIP, two_modes

from updamp.comparison.prediction.parameters import Parametrisation
from updamp.comparison.prediction.run_condition import RunCondition
from updamp.diagnosis.candidate_models.baseline import baseline
from updamp.diagnosis.criteria import Criteria
from updamp.diagnosis.decision.decide import decide
from updamp.diagnosis.selection.search import search
from updamp.effects.catalogue import JOINTS
from updamp.effects.placed import placed

HIDDEN = {"coefficient": 6e8}
EFFECTS = (JOINTS["joint_cubic"], JOINTS["joint_quadratic"])
LEVELS = {"first": ((0.1, 0.2, 0.3), (39.5, 40.7)), "second": ((1.5, 3.0, 5.0), (96.0, 98.0))}


def run(mode, force, window):
    return RunCondition(
        f"{mode} {force:g} N", mode, force, True, window, ((DRIVE, 1), (TIP, 1)), noise=(2e-6, *4 * (0.005,))
    )


@pytest.fixture(scope="module")
def start():
    conditions = tuple(run(mode, force, window) for mode, (forces, window) in LEVELS.items() for force in forces)
    truth = Parametrisation(placed(JOINTS["joint_cubic"], TIP).apply(two_modes(), HIDDEN), ())
    plan, _ = synthetic_plan(truth, np.zeros(0), conditions, np.zeros(0), seed=8, repeats=1)
    return baseline(two_modes(), (), replace(plan, drift=1e-4), {})


@pytest.mark.long
def test_the_effect_is_named_at_its_place_with_its_size(start):
    found = search(start, EFFECTS, Criteria())
    decision = decide(found.evidence, Criteria())
    assert (decision.outcome, decision.effects) == ("identified", (f"joint_cubic@{TIP}",))
    fitted = found.refits[decision.effects].fitted
    assert fitted.parametrisation.values(fitted.u)[decision.effects[0]]["coefficient"] == pytest.approx(6e8, rel=0.1)
    assert decision.trial.excess < 1.3 < found.evidence.trial_of(("joint_cubic",)).excess
    assert found.evidence.test_of(decision.effects[0]).visibility > 0.2
