"""A linear resonator whose rig file is wrong: nothing is missing, and that the file is wrong is said first."""

from pathlib import Path

import numpy as np
import pytest

from updamp.comparison.fit.observations import plan_of
from updamp.diagnosis.candidate_models.baseline import baseline
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


def measured(stiffness: float) -> Measurement:
    """Two levels, one assembly, noise of 0.3 %; stiffness: over the rig file's. No code of updamp."""
    rng, runs, resonance = np.random.default_rng(7), [], RESONANCE * np.sqrt(stiffness)
    f = resonance * np.linspace(0.985, 1.015, 31)
    for force in (1.0, 5.0):
        x = force / (MASS * (2 * np.pi) ** 2 * (resonance**2 * (1 + 1j * LOSS) - f**2))
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
    assert ("calibration first: modal_stiffness stands 4.4 prior deviations" in said) == (outcome == "undecidable")
