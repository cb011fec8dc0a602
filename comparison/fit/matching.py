"""Where on the model's branch a measured point belongs, and how far from there it lies.

A point of a sweep is compared with the branch, not with the response at its frequency: near a turning point there is
none, or three. The residual is what is left across the branch, after the place along it has been chosen freely
(errors in all variables: W. E. Deming, Statistical Adjustment of Data, 1943).
"""

from collections.abc import Iterator
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray
from scipy.interpolate import PPoly

from updamp.comparison.fit.observations import Observations
from updamp.comparison.prediction.numerical_error import to_nearest_turn
from updamp.comparison.prediction.predicted_branch import Observed, PredictedBranch, logarithms, of_force

Floats = NDArray[np.float64]

# How often the place is looked for again, four times as finely, and where, in widths.
_LOOKS, _AROUND = 5, np.linspace(-1, 1, 9)


@dataclass(frozen=True, eq=False)
class Matched:
    """One run against the branch.

    place: (n,) along the branch; difference: (n, m) measured less model there, phases to the nearest turn
    noise: (n, m) standard deviations of sensors and numerics
    residual: (n, m - 1) across the branch, in these; fewer where phases are not
        known
    by_parameter: (n, m - 1, p) what a unit of each parameter takes from it; by_observation: (n, m - 1, m) likewise a
        unit of each observation, such as a drift of frequency (0) or a sensor's gain
    """

    observations: Observations
    place: Floats
    difference: Floats
    noise: Floats
    residual: Floats
    by_parameter: Floats
    by_observation: Floats


def match(
    branch: PredictedBranch,
    run: Observations,
    u: Floats,
    spread: Floats,
    correction: Floats | float = 0.0,
) -> Matched:
    """Match a run against the branch moved to first order to the parameters u.

    correction: (m,) taken off the observations, such as a known drift or gain
    spread: (p,) standard deviations that the parameters may still be off by; they say how much frequency, amplitude
        and phase each tell of the place
    """
    shift, spread = np.append(u - branch.u, 0.0), np.append(spread, 0.0)
    run = replace(run, observed=run.observed - correction)
    place = _nearest(_Moved.of(branch, shift, run), _weights(branch, run, spread))
    observed = branch.at(place)
    difference = _difference(run, observed, shift)
    return _across(run, place, difference, observed, np.hypot(run.noise, branch.rough_at(place)))


def _difference(run: Observations, model: Observed, shift: Floats) -> Floats:
    """(n, m) measured less model"""
    moved = np.einsum("npm,p->nm", model.slopes, shift) + by_drive(run, model.slopes)
    return to_nearest_turn(run.observed - model.value - moved)


def by_drive(run: Observations, slopes: Floats) -> Floats:
    """(n, ..., m) what measured force and level do to the observations, being off those of the condition.

    slopes: (n, ..., p + 1, m) of the branch where the points are, or (1, ..., p + 1, m)
    """
    of_slope, everywhere = _drive(run)
    each = (len(run), *(1 for _ in slopes.shape[1:-2]))
    return np.asarray(slopes[..., -1, :] * of_slope.reshape(*each, 1) + everywhere.reshape(*each, -1))


def _drive(run: Observations) -> tuple[Floats, Floats]:
    """(n,) what the branch's last slope is to be taken times, and (n, m) what is the same all along the branch."""
    if run.log_level is None:
        return run.log_force, np.zeros_like(run.observed)
    # with the response held amplitudes are those over the force
    amplitudes = np.append(0.0, np.tile([1.0, 0.0], run.observed.shape[1] // 2))
    return run.log_level, run.log_force[:, None] * amplitudes


def _weights(branch: PredictedBranch, run: Observations, spread: Floats) -> Floats:
    """(m,) one over the standard deviations, of sensors and parameters together; the same all along the branch, since
    where contacts begin to slip the derivatives leap, and any point would do for a place that is uncertain enough."""
    of_parameters = np.einsum("npm,p->nm", branch.evenly_squared, spread**2)
    noise = np.median(run.noise, axis=0)
    return np.asarray(1 / np.sqrt(noise**2 + np.median(of_parameters, axis=0)))


@dataclass(frozen=True, eq=False)
class _Moved:
    """A run and the branch moved to first order, for places that are tried by the thousand.

    seen: (n, m) observed, less what measured force and level do to it everywhere; of_drive: (n,) what the slope by the
        force, or by the level held, is taken times besides; None where they are the condition's
    curves: of the state along the branch, of its change by the whole shift, and, where that is asked for, by a unit of
        the force or level
    """

    branch: PredictedBranch
    seen: Floats
    of_drive: Floats | None
    curves: PPoly

    @staticmethod
    def of(branch: PredictedBranch, shift: Floats, run: Observations) -> "_Moved":
        of_drive, everywhere = _drive(run)
        curve, slopes = branch.curves
        whole = np.einsum("kipm,p->kim", slopes.c, shift)
        of_unit = [slopes.c[:, :, -1]] if of_drive.any() and not branch.proportional else []
        curves = PPoly.construct_fast(np.stack([curve.c, whole, *of_unit], axis=2), branch.place)
        return _Moved(branch, run.observed - everywhere, of_drive if of_drive.any() else None, curves)

    def distance(self, tried: Floats, weights: Floats) -> Floats:
        """(n, k) squared, of every point of the run from the places tried for it (n or 1, k)"""
        total = np.zeros((len(self.seen), tried.shape[1]))
        for off, turn in self._off(tried, weights):
            total += np.square(_within_turn(off, turn))
        return total

    def nearest_piece(self, ends: Floats, followed: NDArray[np.bool_], weights: Floats) -> tuple[Floats, Floats]:
        """(n,) the place nearest to every point of the run on straight lines from each of the places to the next, and
        how long its line is along the branch. Lines, not places: where frequencies are known far better than places
        are close, the place whose frequency happens to be the nearest may be on another part of the branch.

        ends: (k + 1,) places; followed: (k,)
        """
        square, product, length = (np.zeros((len(self.seen), len(followed))) for _ in range(3))
        for off, turn in self._off(ends[None], weights):
            change = _within_turn(np.diff(off, axis=1), turn)
            start = _within_turn(off[:, :-1] + change / 2, turn) - change / 2
            square += start**2
            product += start * change
            length += change**2
        share = np.clip(-product / np.maximum(length, np.finfo(float).tiny), 0.0, 1.0)
        distance = np.where(followed, square + share * (2 * product + share * length), np.inf)
        best = np.argmin(distance, axis=1)
        along = np.diff(ends)[best]
        return ends[best] + share[np.arange(len(best)), best] * along, along

    def _off(self, tried: Floats, weights: Floats) -> Iterator[tuple[Floats, float]]:
        """(n, k) how far every point of the run is off the places tried for it (n or 1, k), and what a turn is, 0
        but for phases; by `weights` (m,) that are not 0. One kind of observation after the other, since arrays
        whose last axis has the few of them take several times as long."""
        found = self.curves(tried)
        value, change = logarithms(found[..., 0, :], found[..., 1:, :])
        # of amplitudes proportional to the force without a curve
        drive = change[..., 1, :] if change.shape[-2] > 1 else of_force(change.shape[-1])
        value += change[..., 0, :]
        for j in np.flatnonzero(weights):
            off = self.seen[:, j, None] - value[..., j]
            if self.of_drive is not None:
                off -= self.of_drive[:, None] * drive[..., j]
            is_phase = j and j % 2 == 0
            yield off * weights[j], 2 * np.pi * weights[j] if is_phase else 0.0


def _within_turn(off: Floats, turn: float) -> Floats:
    """Phases to the nearest turn; turn: 0 for what is no phase"""
    return off - turn * np.round(off / turn) if turn else off


def _nearest(moved: _Moved, weights: Floats) -> Floats:
    """(n,) the nearest on many short straight lines, then finer and finer looks around it; a gradient would go astray
    where contacts begin to slip.

    All of the branch is tried, whichever part a sweep would be on: a sweep may leave a part before its fold, when
    something disturbs it, and one that begins in a hysteresis may begin on either part.
    """
    place, width = moved.nearest_piece(*moved.branch.pieces, weights)
    each = np.arange(len(place))
    for _ in range(_LOOKS):
        around = place[:, None] + width[:, None] * _AROUND
        around = np.clip(around, moved.branch.place[0], moved.branch.place[-1])
        closest = np.argmin(moved.distance(around, weights), axis=1)
        place, width = around[each, closest], width / 4
    return place


def _across(run: Observations, place: Floats, difference: Floats, model: Observed, noise: Floats) -> Matched:
    """What is left once the place along the branch has been chosen by the noise alone; noise: (n, m), that of the
    numerics included."""
    basis = across(model.along, noise)
    return Matched(
        run,
        place,
        difference,
        noise,
        np.einsum("nrm,nm->nr", basis, difference),
        np.einsum("nrm,npm->nrp", basis, model.slopes[:, :-1]),
        basis,
    )


def across(along: Floats, noise: Floats) -> Floats:
    """(n, m - 1, m) what takes changes of observations to those across the branch, in standard deviations.

    along: (n, m) direction of the branch; noise: (n, m) standard deviations, infinite all along for what was not
        observed: then there is one value less for each
    """
    known = np.flatnonzero(np.isfinite(noise).all(axis=0))
    seen = noise[:, known]
    basis = np.linalg.qr((along[:, known] / seen)[:, :, None], mode="complete")[0][:, :, 1:]
    found = np.zeros((len(noise), basis.shape[2], noise.shape[1]))
    found[:, :, known] = basis.transpose(0, 2, 1) / seen[:, None, :]
    return found
