"""Where on the model's branch a measured point belongs, and how far from there it lies.

A point of a sweep is compared with the branch, not with the response at its frequency: near a turning point there is
none, or three. The residual is what is left across the branch, after the place along it has been chosen freely
(errors in all variables: W. E. Deming, Statistical Adjustment of Data, 1943).
"""

from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from updamp.comparison.fit.nearest_place import MovedCurve, nearest_places
from updamp.comparison.fit.observations import Observations
from updamp.comparison.prediction.numerical_error import to_nearest_turn
from updamp.comparison.prediction.predicted_branch import NO_AMPLITUDE, Observed, PredictedBranch, of_force

Floats = NDArray[np.float64]


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

    def only(self, points: NDArray[np.int64]) -> "Matched":
        """points: places of those that are kept"""
        rows = ("place", "difference", "noise", "residual", "by_parameter", "by_observation")
        kept = {name: getattr(self, name)[points] for name in rows}
        return replace(self, observations=self.observations.only(points), **kept)


def match(
    branch: PredictedBranch,
    run: Observations,
    u: Floats,
    spread: Floats,
    correction: Floats | float = 0.0,
) -> Matched:
    """Match a run against the branch moved to first order to the parameters u.

    correction: (m,) or (n, m) taken off the observations, such as a known drift or gain
    spread: (p,) standard deviations that the parameters may still be off by; they say how much frequency, amplitude
        and phase each tell of the place
    """
    shift, spread = np.append(u - branch.u, 0.0), np.append(spread, 0.0)
    run = replace(run, observed=run.observed - correction)
    place = _nearest(branch, shift, run, _weights(branch, run, spread))
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


def _nearest(branch: PredictedBranch, shift: Floats, run: Observations, weights: Floats) -> Floats:
    """(n,) places of the branch moved to first order, less what measured force and level do to the run."""
    of_drive, everywhere = _drive(run)
    curve, slopes = branch.curves
    whole = np.einsum("kipm,p->kim", slopes.c, shift)
    # of amplitudes proportional to the force without a curve
    of_unit = [slopes.c[:, :, -1]] if of_drive.any() and not branch.proportional else []
    moved = MovedCurve(np.stack([curve.c, whole, *of_unit], axis=2), branch.place, of_force(len(weights)), NO_AMPLITUDE)
    return np.asarray(nearest_places(moved, *branch.pieces, run.observed - everywhere, of_drive, weights))


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
