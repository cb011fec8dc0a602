"""What finer numerics would change: what is added to the model's observations, and how sure that is.

The branch of a finer model (mesh, contact patches, harmonics, time samples) is compared with that of the model in use.
The finer model is nearer the truth, but is not the truth: it may be left with as much as it changes (`UNSURE`). That
uncertainty enters the fit as patterns of size 0 with standard deviation 1, so that misfits of that shape and size prove
nothing: one pattern for the whole difference and, of what calibration cannot make up for, one a mode and one a test.

What finer numerics change depends on the parameters. To first order it is known about where it was asked for, so that
model and change together have the finer model's derivatives there (N. M. Alexandrov and others, J. Aircraft 38 (2001)
1093: first-order consistency).

Where contacts begin to slip one after the other the response is jagged, by how many of them there are, and so is the
difference. Where the teeth really are is not known: their size is added to the noise of the sensors there.
"""

from collections.abc import Mapping
from dataclasses import dataclass, field, replace

import numpy as np
from numpy.typing import NDArray
from scipy.ndimage import uniform_filter1d

Floats = NDArray[np.float64]

# Of what finer numerics change: a method of second order whose finer mesh has elements 1/r as long is left with
# 1 / (r^2 - 1) of what it changed (P. J. Roache, J. Fluids Eng. 116 (1994) 405). Twice as many elements on a face are
# 1/sqrt(2) as long.
UNSURE = 1.0
_FREQUENCY = 0.02  # of a turn of phase: what the whole window counts


@dataclass(frozen=True, eq=False)
class NumericalError:
    """names: of the patterns, such as "mesh IP"

    coarse: condition's name -> (n, m) observations along the branch at which the following are known
    expected: condition's name -> (n, m) to be added to the observations
    about: (p,) parameters where that was asked for; by_parameter: condition's name -> (n, p, m) its derivatives there
    patterns: condition's name -> (n, n_patterns, m) standard deviations of what that is off by
    rough: condition's name -> (n, m) standard deviations of what is left of place to place
    """

    names: tuple[str, ...] = ()
    coarse: Mapping[str, Floats] | None = None
    expected: Mapping[str, Floats] | None = None
    patterns: Mapping[str, Floats] | None = None
    rough: Mapping[str, Floats] | None = None
    about: Floats = field(default_factory=lambda: np.zeros(0))
    by_parameter: Mapping[str, Floats] = field(default_factory=dict)

    def expected_at(self, condition: str, u: Floats) -> Floats:
        """(n, m) along the branch, to first order at parameters u, which begin with those that it is known about"""
        assert self.expected is not None
        return self.expected[condition] + self._since_asked(condition, u)

    def since_asked(
        self, condition: str, shown: Floats, window: tuple[float, float], u: Floats
    ) -> tuple[Floats, NDArray[np.bool_]]:
        """(k, m) more than what was expected at the parameters where that was asked for, where a branch of parameters u
        shows (k, m), this error added; (k,) whether that is beyond the ends of what it was asked for"""
        if self.coarse is None:
            return np.zeros_like(shown), np.zeros(len(shown), dtype=bool)
        along = self.coarse[condition] + self.expected_at(condition, u)
        place = most_similar(shown, along, window)
        return _between(place, self._since_asked(condition, u)), (place <= 0) | (place >= len(along) - 1)

    def _since_asked(self, condition: str, u: Floats) -> Floats:
        """(n, m)"""
        assert self.coarse is not None
        slopes = self.by_parameter.get(condition)
        if slopes is None:
            return np.zeros_like(self.coarse[condition])
        return np.einsum("p,npm->nm", u[: len(self.about)] - self.about, slopes)

    def held_at(self, u: Floats) -> "NumericalError":
        """The same as it is at parameters u, whatever becomes of them"""
        if self.expected is None:
            return self
        return replace(
            self, expected={c: self.expected_at(c, u) for c in self.expected}, about=np.zeros(0), by_parameter={}
        )

    def solved_window(self, condition: str, window: tuple[float, float], u: Floats) -> tuple[float, float]:
        """Frequencies [Hz] that the model has to be solved at for what it shows, this error added, to cover a window:
        as unsure as the error is, twice its standard deviation is to spare. A mesh may shift a resonance by more than a
        narrow window has room for."""
        if self.expected is None:
            return window
        shift = self.expected_at(condition, u)[:, 0]
        spare = 2 * UNSURE * np.abs(shift).max()
        (low, high), (least, most) = window, (shift.min() - spare, shift.max() + spare)
        return float(low * np.exp(-max(most, 0.0))), float(high * np.exp(-min(least, 0.0)))

    def at(self, condition: str, observed: Floats, window: tuple[float, float], u: Floats) -> "ErrorAt":
        """Where a branch of parameters u shows `observed` (k, m): that of the most similar place."""
        if self.coarse is None or self.expected is None or self.patterns is None or self.rough is None:
            none = np.zeros_like(observed)
            return ErrorAt(none, none[:, None][:, :0], none[:, None][:, :0], none)
        place = most_similar(observed, self.coarse[condition], window)
        slopes = self.by_parameter.get(condition, np.zeros((len(self.coarse[condition]), 0, observed.shape[1])))
        along = self.expected_at(condition, u), slopes, self.patterns[condition], self.rough[condition]
        return ErrorAt(*(_between(place, one) for one in along))


@dataclass(frozen=True, eq=False)
class ErrorAt:
    """At places along a branch. expected: (k, m) to be added; by_parameter: (k, p, m) its derivatives
    patterns: (k, n_patterns, m); rough: (k, m)"""

    expected: Floats
    by_parameter: Floats
    patterns: Floats
    rough: Floats


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


def branch_difference(
    coarse: Floats, finer: Floats, window: tuple[float, float], slopes: Floats | None = None
) -> tuple[Floats, Floats]:
    """(n, m) of every point of the coarse branch from the most similar place of the finer one, to be added to it, and
    that one's slopes (n, p, m) there; slopes: along the finer one, none by default"""
    place = most_similar(coarse, finer, window)
    along = np.zeros((len(finer), 0, finer.shape[1])) if slopes is None else slopes
    return to_nearest_turn(_between(place, finer) - coarse), _between(place, along)


def jaggedness(change: Floats) -> Floats:
    """(n, m) size of what is not smooth in changes (n, m) along a branch: what points lie off the straight line between
    their neighbours, as root mean square over five of them (variance 1.5 of that of independent points)."""
    off = np.zeros_like(change)
    off[1:-1] = change[1:-1] - (change[:-2] + change[2:]) / 2
    running = uniform_filter1d(off**2, 5, axis=0, mode="nearest")  # a running sum: round-off may leave it below 0
    return np.asarray(np.sqrt(np.maximum(running, 0.0) / 1.5))


def to_nearest_turn(change: Floats) -> Floats:
    """Changes (..., m) of observations with those of the phases between half a turn back and forth."""
    turned = change.copy()
    turned[..., 2::2] -= 2 * np.pi * np.round(turned[..., 2::2] / (2 * np.pi))
    return turned
