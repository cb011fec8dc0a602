"""Where on the model's branch a measured point belongs, and how far from there it lies.

A point of a sweep is compared with the branch, not with the response at its frequency: near a turning point there is
none, or three. The residual is what is left across the branch, after the place along it has been chosen freely
(errors in all variables: W. E. Deming, Statistical Adjustment of Data, 1943).
"""

from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from updamp.diagnosis.model.predicted_branch import Observed, PredictedBranch
from updamp.diagnosis.residual.observations import Observations

Floats = NDArray[np.float64]

# Places tried between two neighbouring points of the branch.
_BETWEEN = 8


@dataclass(frozen=True, eq=False)
class Matched:
    """One run against the branch.

    place: (n,) along the branch; difference: (n, m) measured less model there, phases to the nearest turn
    residual: (n, m - 1) across the branch, in standard deviations of the sensors
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
    branch: PredictedBranch, run: Observations, u: Floats, spread: Floats, correction: Floats | float = 0.0
) -> Matched:
    """Match a run against the branch moved to first order to the parameters u.

    correction: (m,) taken off the observations, such as a known drift or gain
    spread: (p,) standard deviations that the parameters may still be off by; they say how much frequency, amplitude
        and phase each tell of the place
    """
    shift, spread = np.append(u - branch.u, 0.0), np.append(spread, 0.0)
    run = replace(run, observed=run.observed - correction)
    place = _slide(branch, run, _nearest(branch, run, shift, spread), shift, spread)
    observed = branch.at(place)
    difference = _difference(run, observed, shift)
    return _across(run, place, difference, observed)


def _difference(run: Observations, model: Observed, shift: Floats) -> Floats:
    """(n, m) measured less model"""
    moves = np.broadcast_to(shift, (len(run), len(shift))).copy()
    moves[:, -1] = run.log_force
    return _to_nearest_turn(run.observed - model.value - np.einsum("npm,np->nm", model.slopes, moves))


def _to_nearest_turn(difference: Floats) -> Floats:
    turned = difference.copy()
    turned[..., 2::2] -= 2 * np.pi * np.round(turned[..., 2::2] / (2 * np.pi))
    return turned


def _weights(run: Observations, slopes: Floats, spread: Floats) -> Floats:
    """(..., m) one over the standard deviations, of sensors and parameters together."""
    of_parameters = np.einsum("...pm,p->...m", slopes**2, spread**2)
    return 1 / np.sqrt(np.median(run.noise, axis=0) ** 2 + of_parameters)


def _nearest(branch: PredictedBranch, run: Observations, shift: Floats, spread: Floats) -> Floats:
    """(n,) the best of many places on the parts that the sweep visits."""
    both = branch.visited[:-1] & branch.visited[1:]
    share = (np.arange(_BETWEEN) + 0.5) / _BETWEEN
    tried = (branch.place[:-1, None] + np.diff(branch.place)[:, None] * share)[both].ravel()
    model = branch.at(tried)
    weights = _weights(run, model.slopes, spread)
    without_force = model.value + np.einsum("npm,p->nm", model.slopes, shift)
    best = np.empty(len(run))
    for i, (measured, log_force) in enumerate(zip(run.observed, run.log_force, strict=True)):
        difference = _to_nearest_turn(measured - without_force - model.slopes[:, -1] * log_force)
        # the logarithm keeps a place from winning by being uncertain
        cost = np.sum((weights * difference) ** 2 - 2 * np.log(weights), axis=1)
        best[i] = tried[np.argmin(cost)]
    return best


def _slide(branch: PredictedBranch, run: Observations, place: Floats, shift: Floats, spread: Floats) -> Floats:
    """Gauss-Newton for the place, no further than to the ends of the branch's piece."""
    piece = np.clip(np.searchsorted(branch.place, place) - 1, 0, len(branch.place) - 2)
    low, high = branch.place[piece], branch.place[piece + 1]
    reach = high - low
    for _ in range(4):
        model = branch.at(place)
        squared = _weights(run, model.slopes, spread) ** 2
        difference = _difference(run, model, shift)
        move = np.sum(squared * model.along * difference, axis=1) / np.sum(squared * model.along**2, axis=1)
        place = np.clip(
            place + move, np.maximum(low - reach, branch.place[0]), np.minimum(high + reach, branch.place[-1])
        )
    return place


def _across(run: Observations, place: Floats, difference: Floats, model: Observed) -> Matched:
    """What is left once the place along the branch has been chosen by the sensors' noise alone."""
    n, m = difference.shape
    across = np.empty((n, m - 1, m))
    for i in range(n):
        tangent = model.along[i] / run.noise[i]
        basis = np.linalg.qr(tangent[:, None], mode="complete")[0][:, 1:]
        across[i] = basis.T / run.noise[i]
    return Matched(
        run,
        place,
        difference,
        np.einsum("nrm,nm->nr", across, difference),
        np.einsum("nrm,npm->nrp", across, model.slopes[:, :-1]),
        across,
    )
