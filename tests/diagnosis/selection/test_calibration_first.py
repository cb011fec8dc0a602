"""A linear resonator whose rig file is wrong: nothing is missing, and that the file is wrong is said first."""

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from updamp.comparison.fit.compared import compare_at, predict_branches
from updamp.comparison.fit.observations import plan_of
from updamp.comparison.prediction.predicted_branch import PredictedBranch
from updamp.diagnosis.candidate_models.baseline import Baseline, baseline
from updamp.diagnosis.criteria import Criteria
from updamp.diagnosis.decision.conclude import conclude
from updamp.diagnosis.decision.decide import decide
from updamp.diagnosis.selection.search import search
from updamp.effects.catalogue import JOINTS
from updamp.measurement.measurement import Channel, MeasuredRun, Measurement
from updamp.model.build import modal_before_effects
from updamp.model.rig_files import load_modal

RIG = Path(__file__).parents[3] / "rigs" / "brake_reuss.toml"
POINT, MASS, RESONANCE, LOSS = "beam.drive.x", 2.0, 80.38, 0.0031


def measured(stiffness: float, drift: float = 0.0) -> Measurement:
    """Two levels, one assembly, noise of 0.3 %; stiffness: over the rig file's; drift: of the resonance between the
    levels, relative. No code of updamp."""
    rng, runs, resonance = np.random.default_rng(7), [], RESONANCE * np.sqrt(stiffness)
    f = resonance * np.linspace(0.985, 1.015, 31)
    for force in (1.0, 5.0):
        at = resonance * (1 + drift * (force - 3) / 4)
        x = force / (MASS * (2 * np.pi) ** 2 * (at**2 * (1 + 1j * LOSS) - f**2))
        x = x * (1 + 0.003 * (rng.standard_normal(len(f)) + 1j * rng.standard_normal(len(f))))
        drive = np.full(len(f), force + 0j)
        runs.append(
            MeasuredRun(f"{force:g} N", "first", True, "force", force, 1, ("a",), (1,), f, drive, x[None, None])
        )
    return Measurement("resonator", 0.0, POINT, (Channel("a", POINT),), tuple(runs), repeatability=0.02)


@pytest.mark.parametrize(("stiffness", "outcome"), [(1.0, "adequate"), (1.045, "undecidable")])
def test_a_rig_file_that_is_wrong_is_no_missing_effect(stiffness: float, outcome: str) -> None:
    start = baseline(modal_before_effects(load_modal(RIG)), (), plan_of(measured(stiffness)), {})
    found = search(start, (JOINTS["joint_quadratic"], JOINTS["joint_cubic"]), Criteria())
    decision = decide(found.evidence, Criteria())
    assert (decision.outcome, decision.effects) == (outcome, ())
    said = conclude(found, decision, Criteria(), {POINT: "a"}).sentence
    assert ("calibration first: modal_stiffness 4.4 deviations" in said) == (outcome == "undecidable")
    assert start.fitted.compared.scatter.drift == 1e-4  # as stated, whatever the misfit would make of it
    assert "repeats" not in said
    assert ("no run was held out" in said) == (outcome == "adequate")


def test_a_drift_that_nobody_stated_is_said_first() -> None:
    """One thousandth between two runs where 1e-4 is stated: no effect is needed, and none is credited."""
    start = baseline(modal_before_effects(load_modal(RIG)), (), plan_of(measured(1.0, 1e-3)), {})
    decision = decide(search(start, (JOINTS["joint_quadratic"],), Criteria()).evidence, Criteria())
    assert (decision.outcome, decision.effects) == ("undecidable", ())
    assert "calibration first: the resonance of run '" in decision.reason


def test_points_that_are_odd_are_in_no_run_that_counts_fitted_or_held_out() -> None:
    """A point of each run that reads four times as much: adequate as without, on both."""
    sound = measured(1.0)
    runs = []
    for place, run in zip((4, 15), sound.runs, strict=True):
        response = run.response.copy()
        response[..., place] *= 4
        runs.append(replace(run, response=response))
    plan = plan_of(replace(sound, runs=tuple(runs)))
    (fitted, held_out) = (run.name for run in runs)
    start = baseline(modal_before_effects(load_modal(RIG)), (), plan, {}, held_out=[held_out])
    assert [len(o) for o in plan.observations] == [31, 31]
    assert [len(o) for o in start.plan.observations] == [30, 30]
    assert (start.plan.conditions[start.training[0]].name, len(start.train_plan.observations)) == (fitted, 1)
    decision = decide(search(start, (), Criteria()).evidence, Criteria())
    assert (decision.outcome, decision.effects) == ("adequate", ())


def test_a_calibration_that_stopped_short_is_no_reason_for_an_effect() -> None:
    """The fit with the effect finds the loss factor; so does the one without, which the effect is credited against."""
    start = baseline(modal_before_effects(load_modal(RIG)), (), plan_of(measured(1.0)), {})
    u = np.array([0.0, 0.5, 0.0])
    short = compare_at(start.fitted.parametrisation, u, start.plan, _branches(start, u), start.fitted.compared.scatter)
    stuck = replace(start, fitted=replace(start.fitted, compared=short))
    assert short.mean_squared_misfit > 10
    found = search(stuck, (JOINTS["joint_cubic"],), Criteria())
    assert found.evidence.excess < 1
    assert decide(found.evidence, Criteria()).outcome == "adequate"


def _branches(start: Baseline, u: np.ndarray) -> tuple[PredictedBranch, ...]:
    return predict_branches(start.fitted.parametrisation, u, start.plan)
