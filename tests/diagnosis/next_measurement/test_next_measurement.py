"""Two effects that one level hardly tells apart, and the run that would."""

from dataclasses import replace
from types import SimpleNamespace

import jax.numpy as jnp
import numpy as np
import pytest
from support.amplitude_damper import AmplitudeDamper, AmplitudeDamperParameters
from support.small_model import condition, small_model, synthetic_plan

from updamp.comparison.fit.compared import compare_at, predict_branches
from updamp.comparison.fit.fit import fit
from updamp.comparison.prediction.parameters import Parametrisation
from updamp.comparison.prediction.traced_branch import trace_branch
from updamp.diagnosis.criteria import Criteria
from updamp.diagnosis.decision.decide import Decision
from updamp.diagnosis.evidence import Evidence, Trial
from updamp.diagnosis.next_measurement.candidate_runs import candidate_runs
from updamp.diagnosis.next_measurement.next_measurement import (
    NOTHING,
    _noise,
    _worth_recording,
    next_measurements,
    surviving_explanations,
)
from updamp.diagnosis.next_measurement.separation import PredictedRun, RunNoise, distance, separation
from updamp.diagnosis.verdict import NextMeasurement
from updamp.effects.effect import Effect, EffectParameter
from updamp.effects.rig_model import PointElement
from updamp.hbm.continuation.continuation import ContinuationOptions
from updamp.hbm.problem.structural_changes import Attachment
from updamp.measurement.measurement import FREQUENCY_ERROR
from updamp.model.calibration import FRICTION, LOSS_FACTOR, PRELOAD

NUISANCES = (LOSS_FACTOR, FRICTION, PRELOAD)
FINE = ContinuationOptions(largest_step=0.1)
FIRST = (("a.x", 1), ("b.x", 1))
MEASURED = (condition(10.0),)
MODEL = Parametrisation(small_model(), NUISANCES)


def _quadratic(model, values):
    damper = AmplitudeDamperParameters(values["coefficient"] * jnp.ones(1))
    return replace(model, elements=(*model.elements, PointElement("hidden", ("a.x",), AmplitudeDamper(), damper)))


def _dashpot(model, values):
    return replace(model, attachments=(Attachment("hidden", {"a.x": 1.0}, dashpot=values["coefficient"]),))


def _effect(name, apply, typical):
    return Effect(name, name, (EffectParameter("coefficient", 0.0, -1e4, 1e4, typical, "", ""),), apply)


QUADRATIC, DASHPOT = _effect("quadratic", _quadratic, 200.0), _effect("dashpot", _dashpot, 1.0)


@pytest.fixture(scope="module")
def measured():
    truth, scatter = np.array([0, 0, 0, 1.0]), np.array([*(n.scatter for n in NUISANCES), 0])
    model = Parametrisation(small_model(), NUISANCES, (QUADRATIC,))
    return synthetic_plan(model, truth, MEASURED, scatter, seed=3, repeats=2)[0]


@pytest.fixture(scope="module")
def explanations(measured):
    fits = {}
    for effect in (QUADRATIC, DASHPOT):
        model = Parametrisation(small_model(), NUISANCES, (effect,))
        fits[effect.name] = fit(model, measured, np.zeros(4))
    return fits


@pytest.fixture(scope="module")
def proposed(explanations, measured):
    return next_measurements(explanations, measured, most_runs=2)


def test_the_effects_are_hardly_told_apart_so_far(explanations):
    """The right one does not fit decisively better."""
    assert explanations["dashpot"].compared.chi2 - explanations["quadratic"].compared.chi2 < 10


def test_a_run_that_tells_them_apart_comes_first(proposed, measured):
    best = proposed[0]
    assert best.effects == ("quadratic", "dashpot")
    assert best.separation > 4
    assert "quadratic and dashpot" in best.sentence
    rates = [m.separation / m.hours for m in proposed]
    assert rates == sorted(rates, reverse=True)
    names = [run.condition.name for run in candidate_runs(measured, MODEL, 2)]
    assert all("first at" in m.sentence for m in proposed)
    assert len(names) == 2


def test_what_tells_no_more_than_the_run_without_it_is_not_recorded(proposed):
    """The dampers differ by the first harmonic already at this level; the third one's is below the noise."""
    assert not [m for m in proposed if "harmonic 3" in m.sentence]
    made = [NextMeasurement(what, ("a", "b"), apart, 0.5) for what, apart in (("run", 5.0), ("2", 5.4), ("3", 5.6))]
    assert [m.sentence for m in _worth_recording(made)] == ["run", "3"]


def test_candidate_runs_are_those_that_the_rig_can_make(measured):
    runs = candidate_runs(measured, MODEL, 12)
    made = [(run.condition.force, run.condition.upwards, run.load) for run in runs]
    assert made == [(20, True, 1), (10, True, 1), (10, True, 1.3), (10, False, 1), (5, True, 1), (10, True, 0.7)]
    again = runs[1].recordings
    assert [r.sensors for r in again] == [FIRST, (*FIRST, ("a.x", 3), ("b.x", 3))]
    assert [round(60 * run.recordings[0].hours) for run in runs] == [10, 10, 130, 10, 10, 130]


def test_the_separation_foretells_what_the_run_shows(explanations):
    """A run at twice the level, of the first effect: how much worse the other one follows it, both adjusted again
    within what the data so far leave them free."""
    apart = separation(*(_prediction(f, 20.0) for f in explanations.values()), FIRST)
    truth, scatter = explanations["quadratic"], np.array([*(n.scatter for n in NUISANCES), 0])
    drops = []
    for seed in (5, 6):
        plan, _ = synthetic_plan(truth.parametrisation, truth.u, (condition(20.0),), scatter, seed, repeats=1)
        drops.append(_adjusted(explanations["dashpot"], plan) - _adjusted(truth, plan))
    assert np.sqrt(np.mean(drops)) == pytest.approx(apart, abs=2.0)  # deviation 1.4 of the root of two draws' mean


def _adjusted(f, plan):
    """chi2 of new data alone, with the parameters' covariance so far."""
    plan = replace(plan, lacks_nothing=True)  # what the wrong model lacks is what is looked for: no noise
    about = compare_at(f.parametrisation, f.u, plan, predict_branches(f.parametrisation, f.u, plan), f.compared.scatter)
    residual, columns = about.equations()
    right = columns.T @ residual
    return residual @ residual - right @ np.linalg.solve(np.linalg.inv(f.covariance) + columns.T @ columns, right)


def _prediction(f, force, frequency_error=FREQUENCY_ERROR):
    branch = trace_branch(f.parametrisation, f.u, condition(force, window=(37.5, 52.5)), FINE)
    noise = RunNoise(frequency_error, {"a.x": 0.005, "b.x": 0.005, "": 0.005})
    return PredictedRun(branch, f.covariance, tuple(n.name for n in NUISANCES), f.compared.scatter, noise)


def test_explanations_lie_closer_where_frequencies_are_known_less_well(explanations):
    """As a measurement states it (`frequency_error`), of points read off a figure for one."""
    apart = [
        separation(*(_prediction(f, 20.0, error) for f in explanations.values()), FIRST)
        for error in (FREQUENCY_ERROR, 1e-3, 3e-2)
    ]
    assert apart[0] > apart[1] > apart[2], "a little: these two hardly move the frequency"
    assert apart[2] < 0.995 * apart[0]


def test_runs_are_planned_with_the_frequency_error_of_the_measurement(measured):
    stated = [replace(o, own=np.insert(o.own[:, 1:], 0, 4e-4, axis=1)) for o in measured.observations]
    assert _noise(measured).frequency == pytest.approx(FREQUENCY_ERROR)
    assert _noise(replace(measured, observations=tuple(stated))).frequency == pytest.approx(4e-4)


def test_an_explanation_does_not_lie_apart_from_itself(explanations):
    one = _prediction(explanations["quadratic"], 20.0)
    assert separation(one, one, FIRST) < 0.01


def test_what_parameters_may_be_adjusted_to_does_not_separate(explanations):
    """Friction moved by its own deviation."""
    f = explanations["quadratic"]
    moved = replace(f, compared=replace(f.compared, u=f.u + f.deviations * np.array([0, 1.0, 0, 0])))
    free = separation(_prediction(f, 20.0), _prediction(moved, 20.0), FIRST)
    known = replace(f, covariance=1e-8 * f.covariance), replace(moved, covariance=1e-8 * f.covariance)
    held = separation(*(_prediction(each, 20.0) for each in known), FIRST)
    assert free < 1.2
    assert held > 1.3 * free


def test_the_distance_is_what_is_left_of_least_squares():
    rng = np.random.default_rng(1)
    residual, spread = rng.standard_normal(30), rng.standard_normal((30, 7))
    padded = np.vstack([spread, np.eye(7)])
    right = np.append(residual, np.zeros(7))
    left = right - padded @ np.linalg.lstsq(padded, right, rcond=None)[0]
    assert distance(residual, spread) == pytest.approx(np.linalg.norm(left))


def test_one_explanation_needs_no_telling_apart(explanations, measured):
    assert next_measurements({"quadratic": explanations["quadratic"]}, measured) == ()


# Which explanations are left to be told apart, for each outcome.

NAN = float("nan")


def trial(*effects, excess, delta_bic=50.0, full=True, drop=100.0):
    return Trial(effects, excess, drop, delta_bic, NAN, "", full)


def found(*trials):
    """FitContext stand for themselves by the names of their effects."""
    singles, pairs = ([t for t in trials if len(t.effects) == n] for n in (1, 2))
    evidence = Evidence(9.0, 9.0, 1.0, (), tuple(singles), tuple(pairs), ())
    baseline = SimpleNamespace(fitted="calibrated")
    refits = {t.effects: SimpleNamespace(fitted="+".join(t.effects)) for t in trials}
    return SimpleNamespace(baseline=baseline, refits=refits, evidence=evidence)


def of(outcome, group=(), *trials):
    equals = tuple(t for name in group for t in trials if t.effects == (name,))
    return surviving_explanations(
        found(*trials), Decision(outcome, group[:1], group, None, alternatives=equals), Criteria()
    )


def test_a_group_is_told_apart_and_nobody_else():
    trials = trial("a", excess=1.1), trial("b", excess=1.0), trial("c", excess=1.05), trial("b", "c", excess=0.9)
    assert of("inseparable", ("b", "a"), *trials) == {"b": "b", "a": "a"}


def test_where_all_fail_those_that_fail_least():
    trials = trial("a", excess=4.0), trial("b", excess=6.5), trial("c", excess=3.0, full=False)
    assert of("unknown", (), *trials) == {}
    both = trial("b", "a", excess=3.9)
    assert of("unknown", (), *trials, both) == {"b and a": "b+a", "a": "a"}
    many = [trial(name, excess=4.0 + i / 10) for i, name in enumerate("defg")]
    assert list(of("unknown", (), *many)) == ["d", "e", "f"]


@pytest.mark.parametrize(("delta_bic", "wanted"), [(50.0, {NOTHING: "calibrated", "a": "a"}), (5.0, {})])
def test_an_effect_that_the_data_of_the_fit_ask_for_stands_against_nothing(delta_bic, wanted):
    assert (
        of("adequate", (), trial("a", excess=1.0, delta_bic=delta_bic), trial("b", excess=0.9, delta_bic=1)) == wanted
    )


def test_nothing_is_to_be_told_apart_where_an_effect_is_identified():
    assert of("identified", (), trial("a", excess=1.0), trial("b", excess=1.05)) == {}
