"""Minima that fits of the same effects have ended at.

While something else is missing, the lowest need not be where the effects are in truth: with another effect beside them
a higher one may become the lowest of all.
"""

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from updamp.diagnosis.candidate_models.baseline import Baseline
from updamp.diagnosis.candidate_models.fit_tasks import FittedCandidate, without_branches
from updamp.diagnosis.candidate_models.refit import Refit, assessed
from updamp.diagnosis.criteria import Criteria


def knowing_of(chosen: FittedCandidate, fits: Sequence[FittedCandidate]) -> FittedCandidate:
    """The fit that goes on to be compared, with other minima among the fits of the same effects: of each sign of the
    effects the lowest, unless that is the chosen one itself."""
    kept = [chosen.refit]
    for refit in sorted((f.refit for f in fits), key=lambda r: -r.drop):
        if all(refit.drop > k.drop or _signs(refit) != _signs(k) for k in kept):
            kept.append(refit)
    elsewhere = tuple(without_branches(r.fitted) for r in kept[1:])
    return replace(chosen, refit=replace(chosen.refit, elsewhere=elsewhere))


def minima(refit: Refit, start: Baseline, criteria: Criteria) -> list[Refit]:
    """All that are known, those first that are solved with the fewest harmonics: beside each a search is made, which is
    several times quicker there."""
    others = [assessed(start.fitted, fitted, start.train_plan, refit.effects, criteria) for fitted in refit.elsewhere]
    return sorted([refit, *others], key=lambda r: len(r.fitted.parametrisation.base.harmonics.orders))


def _signs(refit: Refit) -> tuple[float, ...]:
    """Of the effects' parameters"""
    u, p = refit.fitted.u, refit.fitted.parametrisation
    return tuple(float(sign) for effect in refit.effects for sign in np.sign(u[p.columns(effect.name)]))
