"""Where on the model's branch a measured point belongs, and how far from there it lies.

A point of a sweep is compared with the branch, not with the response at its frequency: near a turning point there is
none, or three. The residual is what is left across the branch, after the place along it has been chosen freely
(errors in all variables: W. E. Deming, Statistical Adjustment of Data, 1943).
"""

from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from updamp.comparison.fit.observations import Observations
from updamp.comparison.prediction.numerical_error import to_nearest_turn
from updamp.comparison.prediction.predicted_branch import Observed, PredictedBranch

Floats = NDArray[np.float64]

# Places tried between two neighbouring points of the branch.
_BETWEEN = 8
# How often the place is looked for again, four times as finely.
_LOOKS = 4


@dataclass(frozen=True, eq=False)
class Matched:
    """One run against the branch.

    place: (n,) along the branch; difference: (n, m) measured less model there, phases to the nearest turn
    residual: (n, m - 1) across the branch, in standard deviations of sensors and numerics; fewer where phases are not
        known
    by_parameter: (n, m - 1, p) what a unit of each parameter takes from it; by_observation: (n, m - 1, m) likewise a
        unit of each observation, such as a drift of frequency (0) or a sensor's gain
    """

    observations: Observations
    place: Floats
    difference: Floats
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
    place = _nearest(_moved_as_a_whole(branch, shift), run, _weights(branch, run, spread))
    observed = branch.at(place)
    difference = _difference(run, observed, shift)
    return _across(run, place, difference, observed, np.hypot(run.noise, branch.rough_at(place)))


def _moved_as_a_whole(branch: PredictedBranch, shift: Floats) -> PredictedBranch:
    """With one parameter in place of all, a unit of which is the whole shift: places are tried by the hundred."""
    whole = np.einsum("npm,p->nm", branch.slopes, shift)
    return replace(branch, slopes=np.stack([whole, branch.slopes[:, -1]], axis=1))


def _difference(run: Observations, model: Observed, shift: Floats) -> Floats:
    """(n, m) measured less model"""
    moved = np.einsum("npm,p->nm", model.slopes, shift) + by_drive(run, model.slopes)
    return to_nearest_turn(run.observed - model.value - moved)


def by_drive(run: Observations, slopes: Floats) -> Floats:
    """(n, ..., m) what measured force and level do to the observations, being off those of the condition.

    slopes: (n, ..., p + 1, m) of the branch where the points are, or (1, ..., p + 1, m)
    """
    drive = slopes[..., -1, :]
    each = (len(run), *(1 for _ in drive.shape[1:]))
    if run.log_level is None:
        return np.asarray(drive * run.log_force.reshape(each))
    # with the response held amplitudes are those over the force
    amplitudes = np.append(0.0, np.tile([1.0, 0.0], (drive.shape[-1] - 1) // 2))
    return np.asarray(drive * run.log_level.reshape(each) + amplitudes * run.log_force.reshape(each))


def _weights(branch: PredictedBranch, run: Observations, spread: Floats) -> Floats:
    """(m,) one over the standard deviations, of sensors and parameters together; the same all along the branch, since
    where contacts begin to slip the derivatives leap, and any point would do for a place that is uncertain enough."""
    slopes = branch.observed.slopes
    of_parameters = np.einsum("npm,p->nm", slopes**2, spread**2)
    noise = np.median(run.noise, axis=0)
    return np.asarray(1 / np.sqrt(noise**2 + np.median(of_parameters, axis=0)))


def _distance(moved: PredictedBranch, run: Observations, tried: Floats, weights: Floats) -> Floats:
    """(n, k) squared, of every point of the run from the places tried for it (n or 1, k)."""
    model = moved.at(tried)
    predicted = model.value + model.slopes[..., 0, :]
    difference = to_nearest_turn(run.observed[:, None] - predicted - by_drive(run, model.slopes))
    return np.asarray(np.sum((weights * difference) ** 2, axis=2))


def _nearest(branch: PredictedBranch, run: Observations, weights: Floats) -> Floats:
    """(n,) the best of many places on the parts that the sweep visits, then finer and finer looks around it; a
    gradient would go astray where contacts begin to slip. branch: moved as a whole"""
    tried, widths = _visited_places(branch)
    best = np.argmin(_distance(branch, run, tried[None], weights), axis=1)
    place, width = tried[best], widths[best]
    for _ in range(_LOOKS):
        around = place[:, None] + width[:, None] * np.linspace(-1, 1, 9)
        around = np.clip(around, branch.place[0], branch.place[-1])
        closest = np.argmin(_distance(branch, run, around, weights), axis=1)
        place, width = np.take_along_axis(around, closest[:, None], axis=1)[:, 0], width / 4
    return place


def _visited_places(branch: PredictedBranch) -> tuple[Floats, Floats]:
    """(k,) places that the sweep comes by, up to a fold and from where it lands, and half of the distance to the next:
    where the frequency is beyond all before. A fold lies between two points, which move as parameters do."""
    followed = np.array([not point.after_gap for point in branch.points[1:]], dtype=bool)
    near = np.flatnonzero((branch.visited[:-1] | branch.visited[1:]) & followed)
    share = (np.arange(_BETWEEN) + 0.5) / _BETWEEN
    length = np.diff(branch.place)[near]
    tried = (branch.place[near][:, None] + length[:, None] * share).ravel()
    widths = np.repeat(length / _BETWEEN, _BETWEEN)
    if (branch.frequency[-1] > branch.frequency[0]) != branch.condition.upwards:
        tried, widths = tried[::-1], widths[::-1]
    frequency = branch.at(tried).value[:, 0] * (1.0 if branch.condition.upwards else -1.0)
    ahead = frequency >= np.maximum.accumulate(frequency)
    return tried[ahead], widths[ahead]


def _across(run: Observations, place: Floats, difference: Floats, model: Observed, noise: Floats) -> Matched:
    """What is left once the place along the branch has been chosen by the noise alone; noise: (n, m), that of the
    numerics included."""
    basis = across(model.along, noise)
    return Matched(
        run,
        place,
        difference,
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
