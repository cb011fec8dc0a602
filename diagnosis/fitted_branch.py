"""Branches of a finished fit: with the sizes that it has found for the patterns of numerical error."""

from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from updamp.diagnosis.model.predicted_branch import PredictedBranch, displaced

Floats = NDArray[np.float64]


def at_sizes(branch: PredictedBranch, u: Floats) -> PredictedBranch:
    """A branch with the patterns of numerical error as large as u has them.

    branch: solved at u, with patterns as its last parameters, at sizes of its own (`with_patterns`: 0)
    """
    apart = u - branch.u
    apart[: len(branch.w_by_parameter[0])] = 0.0  # the model's own parameters: it was solved there
    if not apart.any():
        return branch
    change = np.einsum("npm,p->nm", branch.observed.slopes[:, :-1], apart)
    return replace(displaced(branch, change), u=branch.u + apart)
