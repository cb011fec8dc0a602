"""Effects without a derivative: what a step to their typical size changes along a branch."""

from dataclasses import replace

import numpy as np
import pytest
from support.small_model import condition, parametrisation

from updamp.comparison.fit import numerical_gate
from updamp.comparison.fit.numerical_patterns import with_unwrapped_phases
from updamp.comparison.prediction.model_at import ModelAt
from updamp.comparison.prediction.traced_branch import trace_branch
from updamp.diagnosis.score_tests import finite_steps
from updamp.diagnosis.score_tests.finite_steps import steps_along
from updamp.effects.effect import Effect, EffectParameter
from updamp.effects.static_dynamic_coupling import EFFECT as MEAN_MOTION
from updamp.hbm.problem.structural_changes import Attachment
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
    monkeypatch.setattr(finite_steps, "change_of_branch", None)
    ((weaker, mean_motion),) = steps(there, branches[:1], WEAKER, MEAN_MOTION)
    assert weaker.shape == mean_motion.shape == (len(branches[0].points), 1, 5)
    assert not weaker.any()
    assert not mean_motion.any()


def test_where_contacts_slip_or_the_structure_changes_the_step_is_that_of_a_trace(there, branches):
    found = steps(there, branches, WEAKER, SPRING)
    for branch, (weaker, spring) in zip(branches, found, strict=True):
        observed = with_unwrapped_phases(branch.observed.value)
        for own, change in ((WEAKER, weaker), (SPRING, spring)):
            if own is WEAKER and branch is branches[0]:
                continue
            changed = own.apply(there.model, own.at_typical())
            traced = numerical_gate.change_of_branch(changed, branch.condition, observed)
            np.testing.assert_array_equal(change[:, 0], traced)
            assert np.abs(change).max() > 0.01


def test_a_fit_does_not_come_to_where_the_effect_is_absent():
    """There it has no derivative to leave by, and the mean motion is a harmonic less."""
    extended = replace(parametrisation(), effects=(MEAN_MOTION,))
    least = np.clip(np.append(U, 0.0), extended.lower, extended.upper)
    assert 0 < least[-1] < 0.01
    branch = trace_branch(extended, least, condition(60.0))
    assert np.isfinite(branch.slopes[..., -2, :]).all()
    from_above = replace(WEAKER, parameters=(EffectParameter("size", 1.0, 0.0, 1.0, 0.7, "", "test"),))
    assert replace(parametrisation(), effects=(from_above,)).lower[-1] > 0
