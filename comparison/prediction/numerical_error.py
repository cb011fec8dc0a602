"""What finer numerics would change: what is added to the model's observations, and how sure that is.

The branch of a finer model (mesh, contact patches, harmonics, time samples) is compared with that of the model in use.
The finer model is nearer the truth, but is not the truth: what it changes is known to within half of its size. That
uncertainty enters the fit as patterns of size 0 with standard deviation 1, so that misfits of that shape and size prove
nothing: one pattern for the whole difference and, of what calibration cannot make up for, one a mode and one a test.

Where contacts begin to slip one after the other the response is jagged, by how many of them there are, and so is the
difference. Where the teeth really are is not known: their size is added to the noise of the sensors there.
"""

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.ndimage import uniform_filter1d

Floats = NDArray[np.float64]

# Of what finer numerics change.
UNSURE = 0.5
_FREQUENCY = 0.02  # of a turn of phase: what the whole window counts


@dataclass(frozen=True, eq=False)
class NumericalError:
    """names: of the patterns, such as "mesh IP"

    coarse: condition's name -> (n, m) observations along the branch at which the following are known
    expected: condition's name -> (n, m) to be added to the observations
    patterns: condition's name -> (n, n_patterns, m) standard deviations of what that is off by
    rough: condition's name -> (n, m) standard deviations of what is left of place to place
    """

    names: tuple[str, ...] = ()
    coarse: Mapping[str, Floats] | None = None
    expected: Mapping[str, Floats] | None = None
    patterns: Mapping[str, Floats] | None = None
    rough: Mapping[str, Floats] | None = None

    def solved_window(self, condition: str, window: tuple[float, float]) -> tuple[float, float]:
        """Frequencies [Hz] that the model has to be solved at for what it shows, this error added, to cover a window:
        as unsure as the error is, twice its standard deviation is to spare. A mesh may shift a resonance by more than a
        narrow window has room for."""
        if self.expected is None:
            return window
        shift = self.expected[condition][:, 0]
        spare = 2 * UNSURE * np.abs(shift).max()
        (low, high), (least, most) = window, (shift.min() - spare, shift.max() + spare)
        return float(low * np.exp(-max(most, 0.0))), float(high * np.exp(-min(least, 0.0)))

    def at(self, condition: str, observed: Floats, window: tuple[float, float]) -> tuple[Floats, Floats, Floats]:
        """Expected change (k, m), patterns (k, n_patterns, m) and roughness (k, m).

        Those of the most similar place, where a branch of other parameters shows `observed` (k, m)."""
        if self.coarse is None or self.expected is None or self.patterns is None or self.rough is None:
            none = np.zeros_like(observed)
            return none, none[:, None][:, :0], none
        place = most_similar(observed, self.coarse[condition], window)
        expected, patterns, rough = (
            _between(place, one[condition]) for one in (self.expected, self.patterns, self.rough)
        )
        return expected, patterns, rough


def _between(place: Floats, values: Floats) -> Floats:
    """Along the first axis; place: (k,) in units of its entries."""
    low = np.clip(place.astype(int), 0, len(values) - 2)
    share = (place - low).reshape(-1, *[1] * (values.ndim - 1))
    return np.asarray((1 - share) * values[low] + share * values[low + 1])


def most_similar(observed: Floats, along: Floats, window: tuple[float, float]) -> Floats:
    """(k,) places along a branch (n, m), in units of its points, that are most like the observations (k, m).

    A resonance that is shifted by more than its width is the same resonance still: frequency hardly counts.

    observations: logarithm of frequency, then of each amplitude and its phase; window: frequencies [Hz], whose range
        counts as much as a part of a turn of phase
    """
    weights = np.ones(observed.shape[1])
    weights[0] = _FREQUENCY * 2 * np.pi / np.log(window[1] / window[0])
    chords = weights * np.diff(along, axis=0)
    lengths = np.maximum(np.sum(chords**2, axis=1), np.finfo(float).tiny)
    found = np.empty(len(observed))
    for i, point in enumerate(observed):
        apart = weights * to_nearest_turn(point - along[:-1])
        share = np.clip(np.sum(apart * chords, axis=1) / lengths, 0.0, 1.0)
        nearest = int(np.argmin(np.sum((apart - share[:, None] * chords) ** 2, axis=1)))
        found[i] = nearest + share[nearest]
    return found


def branch_difference(coarse: Floats, finer: Floats, window: tuple[float, float]) -> Floats:
    """(n, m) of every point of the coarse branch from the most similar place of the finer one, to be added to it."""
    return to_nearest_turn(_between(most_similar(coarse, finer, window), finer) - coarse)


def jaggedness(change: Floats) -> Floats:
    """(n, m) size of what is not smooth in changes (n, m) along a branch: what points lie off the straight line between
    their neighbours, as root mean square over five of them (variance 1.5 of that of independent points)."""
    off = np.zeros_like(change)
    off[1:-1] = change[1:-1] - (change[:-2] + change[2:]) / 2
    return np.asarray(np.sqrt(uniform_filter1d(off**2, 5, axis=0, mode="nearest") / 1.5))


def to_nearest_turn(change: Floats) -> Floats:
    """Changes (..., m) of observations with those of the phases between half a turn back and forth."""
    turned = change.copy()
    turned[..., 2::2] -= 2 * np.pi * np.round(turned[..., 2::2] / (2 * np.pi))
    return turned
