"""What finer numerics would change, as directions in which the model may be wrong.

The branch of a finer model (mesh, contact patches, harmonics, time samples) is compared with that of the model in use.
The difference is not taken off: a finer model is not the truth either. It enters the fit as a pattern whose size is
normally distributed about 0 with deviation 1, so that misfits of that shape and size prove nothing.
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

Floats = NDArray[np.float64]

_DENSE = 12  # places tried between two points of the finer branch


@dataclass(frozen=True, eq=False)
class NumericalError:
    """names: of the patterns, such as "mesh"

    patterns: condition's name -> (share of the branch's length (n,), change of the observations (n, n_patterns, m))
    """

    names: tuple[str, ...] = ()
    patterns: Mapping[str, tuple[Floats, Floats]] | None = None

    def at(self, condition: str, share: Floats, m: int) -> Floats:
        """(n, n_patterns, m) at shares of the branch's length."""
        if self.patterns is None:
            return np.zeros((len(share), 0, m))
        known, change = self.patterns[condition]
        flat = change.reshape(len(known), -1)
        each = np.stack([np.interp(share, known, column) for column in flat.T], axis=1)
        return np.asarray(each.reshape(len(share), len(self.names), m))


def difference(coarse: Floats, finer: Floats, window: tuple[float, float]) -> Floats:
    """(n, m) of every point of the coarse branch from the nearest place of the finer one, to be added to it.

    coarse: (n, m), finer: (k, m) observations along the branches: logarithm of frequency, then of each amplitude and
        its phase; window: frequencies [Hz], whose range counts as much as half a turn of phase
    """
    weights = np.ones(coarse.shape[1])
    weights[0] = np.pi / np.log(window[1] / window[0])
    steps = np.linspace(0, 1, _DENSE, endpoint=False)[:, None, None]
    dense = (finer[:-1] + steps * np.diff(finer, axis=0)).reshape(-1, finer.shape[1])
    found = np.empty_like(coarse)
    for i, point in enumerate(coarse):
        change = dense - point
        change[:, 2::2] -= 2 * np.pi * np.round(change[:, 2::2] / (2 * np.pi))
        found[i] = change[np.argmin(np.sum((weights * change) ** 2, axis=1))]
    return found


def numerical_error(
    names: Sequence[str],
    windows: Mapping[str, tuple[float, float]],
    coarse: Mapping[str, tuple[Floats, Floats]],
    finer: Sequence[Mapping[str, Floats]],
) -> NumericalError:
    """Patterns of all conditions.

    coarse: condition -> (share of length (n,), observations (n, m)); finer: for each name, condition -> (k, m)
    """
    patterns = {}
    for condition, (share, observed) in coarse.items():
        changes = [difference(observed, one[condition], windows[condition]) for one in finer]
        patterns[condition] = (share, np.stack(changes, axis=1))
    return NumericalError(tuple(names), patterns)
