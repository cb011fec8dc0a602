"""Branches of a finished fit: with the sizes that it has found for the patterns of numerical error."""

from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from updamp.diagnosis.model.held_branch import pairs
from updamp.diagnosis.model.predicted_branch import PredictedBranch, of_state

Floats = NDArray[np.float64]


def at_sizes(branch: PredictedBranch, u: Floats) -> PredictedBranch:
    """A branch with the patterns of numerical error as large as u has them.

    branch: solved at u, with patterns as its last parameters, at sizes of its own (`with_patterns`: 0)
    """
    apart = u - branch.u
    apart[: len(branch.w_by_parameter[0])] = 0.0  # the model's own parameters: it was solved there
    if not apart.any():
        return branch
    change = np.einsum("npm,p->nm", branch.at(branch.place).slopes[:, :-1], apart)
    state = branch.state.copy()
    state[:, 0] += change[:, 0]
    turn = np.exp(change[:, 1::2] + 1j * change[:, 2::2])
    state[:, 1:] = pairs((branch.state[:, 1::2] + 1j * branch.state[:, 2::2]) * turn)
    along = np.concatenate([branch.along[:, :1], _turned(branch.along, turn)], axis=1)
    along += of_state(np.gradient(change, branch.place, axis=0)[:, None], state)[:, 0]
    slopes = np.concatenate([branch.slopes[..., :1], _turned(branch.slopes, turn[:, None])], axis=-1)
    return replace(branch, u=branch.u + apart, state=state, along=along, slopes=slopes)


def _turned(change: Floats, turn: NDArray[np.complex128]) -> Floats:
    """Changes of the amplitudes alone, multiplied by `turn`."""
    return pairs((change[..., 1::2] + 1j * change[..., 2::2]) * turn)
