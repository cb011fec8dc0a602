"""The models that were fitted, with how likely they are beside each other (`probability.py`) and what they leave."""

from collections.abc import Mapping
from types import MappingProxyType

import numpy as np

from updamp.diagnosis.decision.probability import weights
from updamp.diagnosis.evidence import Evidence
from updamp.diagnosis.verdict import Explanation, FittedEffect

# Of the probability from where on, in words: M. D. Mastrandrea et al., Guidance note on consistent treatment of
# uncertainties, IPCC (2010), table 1.
_WORDS = (
    (0.99, "virtually certain"),
    (0.9, "very likely"),
    (0.66, "likely"),
    (0.33, "about as likely as not"),
    (0.1, "unlikely"),
    (0.01, "very unlikely"),
    (0.0, "exceptionally unlikely"),
)


def explanations(
    evidence: Evidence, fitted: Mapping[tuple[str, ...], tuple[FittedEffect, ...]] = MappingProxyType({})
) -> tuple[Explanation, ...]:
    """Of the model without effects and of all fits that were left to settle, the likeliest first.

    fitted: values of the effects of each fit, by their names
    """
    settled = [t for t in (*evidence.trials, *evidence.combined) if t.full]
    left = [((), evidence.excess, evidence.held_out), *((t.effects, t.excess, t.held_out) for t in settled)]
    found = [
        Explanation(effects, float(p), float(np.sqrt(excess)), held_out, fitted.get(effects, ()))
        for (effects, excess, held_out), p in zip(left, weights(settled, evidence), strict=True)
    ]
    return tuple(sorted(found, key=lambda e: (-e.probability, e.misfit)))


def in_words(probability: float) -> str:
    return next(words for least, words in _WORDS if probability >= least)
