"""The Brake-Reuss beam: which effect of its bolted joint is missing, judged on runs that no fit has seen."""

from pathlib import Path

import pytest

from updamp.comparison.fit.compared import objective
from updamp.comparison.fit.fit_from_far import LAST
from updamp.comparison.fit.observations import plan_of
from updamp.diagnosis.candidate_models.baseline import baseline
from updamp.diagnosis.criteria import Criteria
from updamp.diagnosis.decision.conclude import conclude
from updamp.diagnosis.decision.decide import decide
from updamp.diagnosis.decision.fitted_parameters import fitted_parameters
from updamp.diagnosis.selection.search import SearchResult, search
from updamp.diagnosis.verdict import Verdict
from updamp.effects.catalogue import CATALOGUE, JOINTS
from updamp.measurement.load import load_measurement
from updamp.model.build import modal_before_effects
from updamp.model.rig_files import load_modal

pytestmark = pytest.mark.long

ROOT = Path(__file__).parents[2]
DATA = ROOT.parent / "shared" / "data" / "brb" / "response_controlled.csv"
HELD_OUT = ("20 m/s2", "40 m/s2", "60 m/s2", "80 m/s2")


@pytest.fixture(scope="module")
def found() -> SearchResult:
    if not DATA.is_file():
        pytest.skip(f"{DATA} is missing: the beam's data are under GPL-3.0 and are kept beside the checkout")
    model = modal_before_effects(load_modal(ROOT / "rigs" / "brake_reuss.toml"))
    path = ROOT / "rigs" / "brake_reuss_measurement.toml"
    measurement = load_measurement(path, ["beam.drive.x"], rig="brake_reuss")
    start = baseline(model, (), plan_of(measurement), {}, HELD_OUT)
    refused = CATALOGUE["sub_patch_microslip"], CATALOGUE["material_damping"]
    sought = [effect for name, effect in JOINTS.items() if name not in ("joint_square", "joint_friction")]
    return search(start, (*sought, *refused), Criteria())


@pytest.fixture(scope="module")
def verdict(found: SearchResult) -> Verdict:
    return conclude(found, decide(found.evidence, Criteria()), Criteria(), {"beam.drive.x": "accelerometer"})


PAIR = ("joint_microslip", "joint_clearance")
SPRINGS = ("joint_cubic", "joint_quintic")


def test_a_clearance_beside_the_microslip_is_named(found: SearchResult, verdict: Verdict) -> None:
    """At the stated repeatability of 6.5 %, drift from run to run held at 1e-4. With another spring in its place runs
    would have to be farther off than anybody states."""
    assert verdict.verdict == "identified"
    assert verdict.effects == PAIR
    trials = {t.effects: t for t in found.evidence.combined}
    assert abs(trials[PAIR].deviations) < 3
    for spring in SPRINGS:
        rival = trials["joint_microslip", spring]
        assert abs(rival.deviations) > 3
        assert "the resonance of run '" in rival.farthest


def test_error_falls_on_runs_that_no_fit_has_seen(found: SearchResult) -> None:
    before, pair = found.evidence, next(t for t in found.evidence.combined if t.effects == PAIR)
    assert before.excess**0.5 > 3.5
    assert before.held_out > 4
    assert pair.excess**0.5 < 0.9
    assert pair.held_out < 1.2


def test_other_effects_are_worse_or_cannot_be_seen(found: SearchResult) -> None:
    trials = {t.effects: t for t in (*found.evidence.trials, *found.evidence.combined)}
    pair = trials[PAIR]
    print({n: (t.excess**0.5, t.held_out, t.farthest, t.deviations) for n, t in trials.items()})
    assert trials["joint_quadratic",].excess > 1.8 * pair.excess
    assert trials["joint_quadratic",].held_out > 1.3 * pair.held_out
    assert trials["joint_microslip",].excess > 4 * pair.excess
    others = [t for t in found.evidence.combined if t is not pair and len(t.effects) == 2]
    assert others
    assert all(t.held_out > 1.8 * pair.held_out for t in others)
    assert all(len(t.effects) <= 2 for t in found.evidence.combined)  # nothing asks for a third
    visible = {t.effect: t.visibility for t in found.evidence.tested}
    assert visible["joint_viscous"] < 0.1
    assert visible["joint_viscoelastic"] < 0.1


def test_no_fit_ends_worse_than_the_model_that_it_contains(found: SearchResult) -> None:
    """By what a fit lowers, to within what its last stage takes for settled."""
    value = {names: objective(r.fitted.parametrisation, r.fitted.compared) for names, r in found.refits.items()}
    base = found.baseline.fitted
    for names, reached in value.items():
        assert reached < objective(base.parametrisation, base.compared) + LAST.tolerance
        assert len(names) == 1 or all(reached < value[name,] + LAST.tolerance for name in names)


def test_microslips_parameters(found: SearchResult) -> None:
    """Damping grows with the amplitude to the power 1 + chi; joints in the literature had 0.1 to 1."""
    refit = found.refits[PAIR]
    microslip = next(e for e in refit.effects if e.name == "joint_microslip")
    lost, exponent = fitted_parameters(refit, microslip)
    print(lost, exponent)
    assert 1000 < lost.value < 2000
    assert exponent.lower < exponent.value < 0.8


def test_effects_of_contacts_are_refused(found: SearchResult) -> None:
    assert "no contacts" in found.extended.refused["sub_patch_microslip"]
    assert "blade_left.tip.x" in found.extended.refused["material_damping"]
