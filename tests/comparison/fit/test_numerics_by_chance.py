"""The numerical error that a test in which contacts slip has by chance."""

import numpy as np
import pytest
from support.small_model import condition, parametrisation, small_model, synthetic_plan

from updamp.comparison.fit.compared import predict_branches
from updamp.comparison.fit.matching import across
from updamp.comparison.fit.numerical_gate import NumericalGate
from updamp.comparison.fit.observations import noise_of
from updamp.comparison.prediction.numerical_error import UNSURE
from updamp.model.calibration import YOUNGS_MODULUS

FORCES = (1e-3, 30.0, 60.0)  # at the first of which nothing slips


@pytest.fixture(scope="module")
def asked():
    plain = parametrisation()
    conditions = tuple(condition(force) for force in FORCES)
    plan, _ = synthetic_plan(plain, np.zeros(4), conditions, np.full(4, 1e-4), seed=2)
    finer = {"stiffer": YOUNGS_MODULUS.apply(small_model(), float(np.exp(0.15)))}
    gate = NumericalGate(plan, finer, widened=0).at(plain, np.zeros(4))
    return plan, gate.parametrisation, predict_branches(plain, np.zeros(4), plan)


def of(numerics, name: str) -> list[int]:
    return [i for i, pattern in enumerate(numerics.names) if pattern.startswith(f"{name} by chance")]


def size(plan, branches, changes: dict[str, np.ndarray]) -> dict[str, float]:
    """Sum of mean squares of changes (n, k, m) across each branch, in standard deviations."""
    found = {}
    for test, branch in enumerate(branches):
        along = branch.evenly.along
        basis = across(along, np.broadcast_to(noise_of(plan.observations, test), along.shape))
        seen = np.einsum("nrm,nkm->krn", basis, changes[branch.condition.name])
        found[branch.condition.name] = float(np.sum(seen**2) / np.prod(seen.shape[1:]))
    return found


def test_it_is_half_of_what_finer_numerics_change_in_the_others_that_slip(asked):
    plan, p, branches = asked
    numerics, (stuck, *slipping) = p.numerics, [c.name for c in plan.conditions]
    assert of(numerics, stuck) == []
    own = {c: numerics.patterns[c][:, [numerics.names.index(f"stiffer {c}")]] / UNSURE for c in numerics.patterns}
    left = size(plan, branches, own)
    chance = size(plan, branches, {c: numerics.patterns[c][:, of(numerics, c)] for c in numerics.patterns})
    assert left[slipping[0]] != pytest.approx(left[slipping[1]], rel=0.05)
    for c in slipping:
        assert 1 <= len(of(numerics, c)) <= len(p.nuisances)
        (other,) = {*slipping} - {c}
        assert chance[c] == pytest.approx(UNSURE**2 * left[other], rel=1e-6)


def test_it_is_each_test_s_own(asked):
    plan, p, _ = asked
    for one in plan.conditions:
        for other in plan.conditions:
            if other is not one:
                assert not p.numerics.patterns[other.name][:, of(p.numerics, one.name)].any()
