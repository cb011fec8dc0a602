"""How likely the models are that were fitted, beside each other: weights by the Bayesian information criterion.

With all as likely beforehand the probability of a model is exp(gain / 2) over the sum of all, where gain is that of the
criterion from the model without effects (R. E. Kass and A. E. Raftery, J. Am. Stat. Assoc. 90 (1995) 773),
neighbouring points counted as one. None of them needs to be right: what the best one leaves says that.
"""

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from updamp.diagnosis.candidate_models.refit import gain_of_bic
from updamp.diagnosis.evidence import Evidence, Trial


def gain(trial: Trial, evidence: Evidence) -> float:
    """Of the information criterion, over the model without effects."""
    return gain_of_bic(trial.drop, trial.parameters, evidence.independent, evidence.as_one)


def weights(trials: Sequence[Trial], evidence: Evidence) -> NDArray[np.float64]:
    """Of the model without effects and of each of these, their sum 1."""
    gains = np.array([0.0, *(gain(t, evidence) for t in trials)])
    found = np.exp((gains - gains.max()) / 2)
    return np.asarray(found / found.sum())
