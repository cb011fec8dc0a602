"""Which minima of an effect another one is looked for beside, with made-up fits."""

from dataclasses import dataclass

import pytest

from updamp.diagnosis.candidate_models.fit_tasks import FittedCandidate
from updamp.diagnosis.candidate_models.minima import knowing_of
from updamp.diagnosis.candidate_models.refit import Refit
from updamp.diagnosis.evidence import Trial
from updamp.effects.effect import Effect

EFFECT = Effect("gradient", "there is a gradient", (), lambda model, _: model)


@dataclass(frozen=True)
class Compared:
    branches: tuple[object, ...] = (None,)


class OneEffect:
    def columns(self, _: str) -> slice:
        return slice(0, 1)


ONE_EFFECT = OneEffect()


@dataclass(frozen=True)
class MadeUp:
    u: tuple[float, ...]
    compared: Compared = Compared()
    parametrisation: OneEffect = ONE_EFFECT


def ended_at(size: float, drop: float) -> FittedCandidate:
    refit = Refit((EFFECT,), MadeUp((size,)), drop, drop, "")
    return FittedCandidate(refit, Trial(("gradient",), 2.0, drop, drop, 0.9, "", True, unseen=0.9))


@pytest.mark.parametrize(
    ("chosen", "others", "kept"),
    [
        ((0.79, 630.0), [(-0.62, 620.0), (-0.46, 610.0)], [-0.62]),
        ((0.79, 630.0), [(-0.46, 610.0), (-0.62, 620.0)], [-0.62]),
        ((-0.60, 630.0), [(-0.62, 620.0)], []),
        # the numerical error of its own model has led it astray
        ((-0.46, 610.0), [(-0.62, 620.0)], [-0.62]),
        ((-0.46, 610.0), [(-0.62, 620.0), (0.79, 600.0)], [-0.62, 0.79]),
    ],
)
def test_of_each_sign_the_lowest_minimum_is_kept(chosen, others, kept):
    best, *rest = (ended_at(*one) for one in (chosen, *others))
    found = knowing_of(best, [best, *rest]).refit
    assert [fitted.u[0] for fitted in found.elsewhere] == kept
    assert all(fitted.compared.branches == () for fitted in found.elsewhere), "they would fill the memory"
    assert found.fitted is best.refit.fitted
