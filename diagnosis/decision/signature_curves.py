"""Signatures of the effects beside the residual, run by run, for the report."""

from collections.abc import Mapping

import numpy as np
from numpy.typing import NDArray

from updamp.comparison.fit.matching import Matched
from updamp.diagnosis.score_tests.score import Score
from updamp.diagnosis.selection.search import SearchResult
from updamp.diagnosis.verdict import Signature

Floats = NDArray[np.float64]
# Effects drawn: the best by the score test.
_MOST_EFFECTS = 6


def signatures(found: SearchResult, names: Mapping[str, str]) -> tuple[Signature, ...]:
    """Of the best effects in the first repeat of every training run. names: point of the model -> its channel"""
    plan, compared = found.baseline.train_plan, found.extended.compared
    first = plan.repeats[0]
    curves = []
    for score in found.scored[:_MOST_EFFECTS]:
        for m in (m for m in compared.matched if m.observations.repeat == first):
            condition = plan.conditions[m.observations.test]
            change = _observed(found, m, score)
            noise = m.observations.noise
            for j, (point, k) in enumerate(condition.sensors):
                if k != 1:
                    continue
                columns = 1 + 2 * j, 2 + 2 * j
                own = [change[:, c] / noise[:, c] for c in columns]
                left = [m.difference[:, c] / noise[:, c] for c in columns]
                curves.append(
                    Signature(
                        score.effect.name,
                        condition.name,
                        condition.mode,
                        condition.level,
                        names[point],
                        m.observations.frequency,
                        *own,
                        *left,
                    )
                )
    return tuple(curves)


def _observed(found: SearchResult, m: Matched, score: Score) -> Floats:
    """(n, m) change of the observations by the effect's step and the nuisance parameters' best answer to it.

    The columns are those across the branch: back in the observations they have no part along it.
    """
    answer = found.extended.answer(score.effect, score.step)
    across = m.by_parameter @ answer
    back = np.linalg.pinv(m.by_observation)
    return np.asarray(np.einsum("nmr,nr->nm", back, across))
