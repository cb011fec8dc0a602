"""Runs whose resonance wanders: no effect is named, and it is said what the data look like."""

from dataclasses import replace

import numpy as np
import pytest
from support.small_model import NUISANCES, condition, parametrisation, small_model, synthetic_plan

from updamp.diagnosis.candidate_models.baseline import baseline
from updamp.diagnosis.candidate_models.if_runs_drift import if_runs_drift
from updamp.diagnosis.criteria import Criteria
from updamp.diagnosis.decision.decide import decide
from updamp.diagnosis.decision.sentence import Wording, sentence
from updamp.diagnosis.evidence import EVIDENCE_JSON
from updamp.diagnosis.selection.search import search
from updamp.effects.effect import Effect, EffectParameter
from updamp.hbm.problem.structural_changes import Attachment

pytestmark = pytest.mark.long

# By level, which is not the order of the day.
LEVELS, WARMED = (10.0, 20.0, 30.0, 45.0, 60.0), (0.0, -0.004, 0.003, -0.002, 0.004)
SPRING = Effect(
    "spring",
    "there is a spring",
    (EffectParameter("k", 0.0, -4e4, 4e4, 2e3, "", "test"),),
    lambda m, v: replace(m, attachments=(*m.attachments, Attachment("test", points={"b.x": 1.0}, stiffness=v["k"]))),
)


def wandering(repeats):
    conditions = tuple(condition(f) for f in LEVELS)
    plan, _ = synthetic_plan(parametrisation(), np.zeros(4), conditions, np.zeros(4), seed=5, repeats=repeats)
    moved = []
    for run in plan.observations:
        observed = run.observed.copy()
        observed[:, 0] += WARMED[run.test]
        moved.append(replace(run, observed=observed))
    return replace(plan, observations=tuple(moved))


def calibrated(plan):
    with pytest.MonkeyPatch.context() as few:
        few.setattr("updamp.diagnosis.candidate_models.baseline.nuisances", lambda _: NUISANCES)
        return baseline(small_model(), (), plan, {})


@pytest.fixture(scope="module")
def start():
    return calibrated(wandering(repeats=1))


def test_the_spread_of_the_runs_is_found_and_no_effect_named(start):
    result = search(start, (SPRING,), Criteria())
    decision, free = decide(result.evidence, Criteria()), result.evidence.if_runs_drift
    assert decision.outcome == "unknown"
    fitted = [WARMED[i] for i in start.training]
    assert free.drift == pytest.approx(np.std(fitted, ddof=1), rel=0.1)
    assert free.excess < 1.3 < 10 < result.evidence.excess
    words = Wording({"spring": "there is a spring"}, "the scatter", "runs that the fit never saw")
    said = sentence(decision, result.evidence, Criteria(), words)
    assert "the runs lie 0.3" in said
    assert "state frequency_drift = 0.003" in said or "state frequency_drift = 0.004" in said
    assert EVIDENCE_JSON.from_json(EVIDENCE_JSON.to_json(result.evidence)).if_runs_drift == free


def test_what_is_stated_as_drift_is_no_misfit(start):
    evidence = search(calibrated(replace(start.plan, drift=0.004)), (SPRING,), Criteria()).evidence
    assert decide(evidence, Criteria()).outcome == "adequate"


def test_nothing_is_asked_where_repeats_tell_the_drift_or_of_two_runs(start):
    assert if_runs_drift(replace(start, plan=wandering(repeats=2))) is None
    assert if_runs_drift(replace(start, training=start.training[:2])) is None
