"""Effects without a derivative: what a step to their typical size changes along a branch."""

from dataclasses import replace

import numpy as np
import pytest
from support.small_model import NOISE, condition, parametrisation, small_model, synthetic_plan

from updamp.comparison.fit.compared import predict_branches
from updamp.comparison.fit.numerical_gate import NumericalGate, in_wider_window
from updamp.comparison.fit.numerical_patterns import change_to, with_unwrapped_phases
from updamp.comparison.prediction.model_at import ModelAt
from updamp.comparison.prediction.parameters import Parametrisation
from updamp.comparison.prediction.traced_branch import trace_branch
from updamp.diagnosis.score_tests import finite_steps
from updamp.diagnosis.score_tests.finite_steps import steps_along
from updamp.effects.effect import Effect, EffectParameter
from updamp.effects.static_dynamic_coupling import EFFECT as MEAN_MOTION
from updamp.hbm.problem.structural_changes import Attachment
from updamp.model.calibration import YOUNGS_MODULUS
from updamp.parallel.workers import here

U = np.zeros(4)


def effect(name, typical, apply):
    return Effect(
        name, f"there is a {name}", (EffectParameter("size", 0.0, 0.0, 1.0, typical, "", "test"),), apply, True
    )


# Slips sooner, and is as stiff as before for as long as it sticks.
WEAKER = effect("weaker", 0.3, lambda m, v: m.with_contacts(n0=m.contacts.parameters.n0 * np.exp(-v["size"])))
SPRING = effect(
    "spring",
    0.3,
    lambda m, v: replace(
        m, attachments=(*m.attachments, Attachment("test", points={"b.x": 1.0}, stiffness=1e4 * v["size"]))
    ),
)


@pytest.fixture(scope="module")
def there():
    return ModelAt(parametrisation(), U)


@pytest.fixture(scope="module")
def branches(there):
    """All stuck, and with slip at resonance."""
    return [trace_branch(there.parametrisation, U, condition(force)) for force in (1.0, 60.0)]


def steps(there, branches, *effects):
    return steps_along(there, branches, effects, None, lambda _: None, here)


def test_where_all_sticks_nothing_changes_and_nothing_is_traced(there, branches, monkeypatch):
    monkeypatch.setattr(finite_steps, "BranchTask", None)
    ((weaker, mean_motion),) = steps(there, branches[:1], WEAKER, MEAN_MOTION)
    assert weaker.shape == mean_motion.shape == (len(branches[0].points), 1, 5)
    assert not weaker.any()
    assert not mean_motion.any()


def test_where_contacts_slip_or_the_structure_changes_the_step_is_that_of_a_trace(there, branches):
    found = steps(there, branches, WEAKER, SPRING)
    for branch, changes in zip(branches, found, strict=True):
        observed, sweep = with_unwrapped_phases(branch.observed.value), in_wider_window(branch.condition)
        for own, change in zip((WEAKER, SPRING), changes, strict=True):
            if own is not SPRING and branch is branches[0]:
                continue
            changed = Parametrisation(own.apply(there.model, own.at_typical()), ())
            traced = change_to(observed, trace_branch(changed, np.zeros(0), sweep), branch.condition)[0]
            assert np.abs(traced).max() > 0.01
            # what is interpolated is expected to be right to a tenth of the noise, at corners less (`refined.py`)
            assert np.sqrt(np.mean((change[:, 0] - traced) ** 2)) < 0.1 * NOISE
            np.testing.assert_allclose(change[:, 0], traced, atol=NOISE)


def test_the_step_is_free_of_the_numerical_error_that_was_taken_off():
    """Of an effect that is as good as none: else the error itself would count as what the effect changes."""
    plain, stiffer = parametrisation(), 0.002
    plan, _ = synthetic_plan(plain, U, (condition(30.0),), np.full(4, 1e-4), seed=2)
    finer = {"stiffer": YOUNGS_MODULUS.apply(small_model(), float(np.exp(stiffer)))}
    p = NumericalGate(plan, finer, widened=0).at(plain, U).parametrisation
    u = np.zeros(len(p))
    solved = predict_branches(p, u, plan)
    none = effect("next to none", 1e-9, SPRING.apply)
    ((change,),) = steps(ModelAt(p, u), solved, none)
    assert np.abs(change).max() < 2e-3
    ((with_error,),) = steps(ModelAt(plain, U), solved, none)
    assert np.abs(with_error[..., 0]).max() > stiffer / 4


def test_a_fit_does_not_come_to_where_the_effect_is_absent():
    """There it has no derivative to leave by, and the mean motion is a harmonic less."""
    extended = replace(parametrisation(), effects=(MEAN_MOTION,))
    least = np.clip(np.append(U, 0.0), extended.lower, extended.upper)
    assert 0 < least[-1] < 0.01
    branch = trace_branch(extended, least, condition(60.0))
    assert np.isfinite(branch.slopes[..., -2, :]).all()
    from_above = replace(WEAKER, parameters=(EffectParameter("size", 1.0, 0.0, 1.0, 0.7, "", "test"),))
    assert replace(parametrisation(), effects=(from_above,)).lower[-1] > 0
