"""How far two explanations lie apart in what a run would show.

With the branch of each, and the run that the first would give put against the branch of the second, what is left
across the branch is r, in standard deviations of the sensors. It is known up to

    covariance V = 1 + U U^T + S_1 C_1 S_1^T + S_2 C_2 S_2^T,

U the scatter of one assembly (nuisance parameters, drift, gains), S the slopes of each branch by the explanation's own
parameters and C their covariance as fitted: both may be adjusted again, as far as the data so far leave them free.
The separation is the root of r^T V^-1 r, the distance of D. V. Lindley's (Ann. Math. Stat. 27 (1956) 986) and G. E. P.
Box and W. J. Hill's (Technometrics 9 (1967) 57) designs that discriminate; of both ways round, the smaller one. That
explanations fitted to the same data are wrong together in places is not counted, so it is rather too small.

Amplitudes are compared relative to the first harmonic at the same sensor, real and imaginary parts apart, so that a
harmonic that one explanation does not have at all may be compared. Its noise is that of the first harmonic.
"""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray
from scipy.interpolate import CubicHermiteSpline, PchipInterpolator

from updamp.comparison.fit.matching import across, match
from updamp.comparison.fit.observations import Observations
from updamp.comparison.fit.scatter import Scatter
from updamp.comparison.prediction.predicted_branch import PredictedBranch

Floats = NDArray[np.float64]
Complex = NDArray[np.complex128]
Integers = NDArray[np.int64]
Sensor = tuple[str, int]
Project = Callable[[Floats], Floats]

_POINTS = 40  # of the run


@dataclass(frozen=True, eq=False)
class RunNoise:
    """Relative standard deviations: of a single frequency, and of the sensor at each point, under "" that of others"""

    frequency: float
    sensors: Mapping[str, float]

    def deviations(self, points: Sequence[str], scale: float) -> Floats:
        """(1 + 2 n,) of a frequency and of the real and imaginary part at each point, sensors' noise times `scale`"""
        each = scale * np.array([self.sensors.get(point, self.sensors[""]) for point in points])
        return np.append(self.frequency, np.repeat(each, 2))


@dataclass(frozen=True, eq=False)
class PredictedRun:
    """A run as one explanation has it. covariance: (p, p) of the branch's parameters, the first of which are the
    nuisance parameters named in `scatter`"""

    branch: PredictedBranch
    covariance: Floats
    nuisances: tuple[str, ...]
    scatter: Scatter
    noise: RunNoise

    @property
    def root(self) -> Floats:
        """(p, p) L with L L^T the covariance"""
        values, vectors = np.linalg.eigh(self.covariance)
        return np.asarray(vectors * np.sqrt(np.maximum(values, 0.0)))


def separation(one: PredictedRun, other: PredictedRun, sensors: Sequence[Sensor]) -> float:
    """In standard deviations, for a run with these sensors; nan where the branches have no frequency in common.

    sensors: with the first harmonic at each point, and among those of both branches' conditions
    """
    both = [_one_way(a, b, sensors) for a, b in ((one, other), (other, one))]
    return float(min(both)) if np.all(np.isfinite(both)) else float("nan")


def _one_way(truth: PredictedRun, model: PredictedRun, sensors: Sequence[Sensor]) -> float:
    place = _places(truth.branch, model.branch)
    if not len(place):
        return float("nan")
    there = _matched(truth, model, place, sensors)
    a, b = _Local.of(truth.branch, place, sensors), _Local.of(model.branch, there, sensors)
    scale = _scale(a, sensors, truth)
    deviation = truth.noise.deviations([point for point, _ in sensors], truth.scatter.noise)
    basis = across(b.scaled(b.along, scale), np.broadcast_to(deviation, (len(place), len(deviation))))

    def project(changes: Floats) -> Floats:
        """(n, k, m) -> (n (m - 1), k)"""
        return np.asarray(np.einsum("nrm,nkm->nrk", basis, changes).reshape(-1, changes.shape[1]))

    residual = project(a.scaled(a.state - b.state, scale)[:, None])[:, 0]
    slopes = [np.stack([x.scaled(s, scale) for s in x.slopes.transpose(1, 0, 2)], axis=1) for x in (b, a)]
    free = [project(s) @ p.root for s, p in zip(slopes, (model, truth), strict=True)]
    return distance(residual, np.hstack([_scatter(b, slopes[0], scale, model, project), *free]))


def distance(residual: Floats, spread: Floats) -> float:
    """Root of r^T (1 + U U^T)^-1 r. residual: (n,); spread: (n, k) U"""
    left, sizes, _ = np.linalg.svd(spread, full_matrices=False)
    along = left.T @ residual
    return float(np.sqrt(max(residual @ residual - along @ (along * sizes**2 / (1 + sizes**2)), 0.0)))


def _scatter(local: "_Local", slopes: Floats, scale: Floats, model: PredictedRun, project: Project) -> Floats:
    """(n, k) U, one assembly's"""
    sizes = [model.scatter.parameters.get(name, 0.0) for name in model.nuisances]
    n, m = local.state.shape
    of_run, gains = np.zeros((n, 2, m)), np.zeros((n, scale.shape[1], m))
    of_run[:, 0, 0] = model.scatter.drift
    for j in range(scale.shape[1]):
        columns = slice(1 + 2 * j, 3 + 2 * j)
        gains[:, j, columns] = model.scatter.gain * local.state[:, columns] / scale[:, j, None]
    parameters = slopes[:, : len(sizes)] * np.array(sizes)[:, None]
    of_run[:, 1] = gains.sum(axis=1) * model.scatter.level / model.scatter.gain
    return project(np.concatenate([parameters, of_run, gains], axis=1))


@dataclass(frozen=True, eq=False)
class _Local:
    """A branch at places of it, some sensors only. state, along: (n, m); slopes: (n, p, m), as in PredictedBranch"""

    state: Floats
    along: Floats
    slopes: Floats

    @staticmethod
    def of(branch: PredictedBranch, place: Floats, sensors: Sequence[Sensor]) -> "_Local":
        columns = _columns(branch, sensors)
        curve = CubicHermiteSpline(branch.place, branch.state[:, columns], branch.along[:, columns])
        slopes = PchipInterpolator(branch.place, branch.slopes[:, :-1, columns])
        return _Local(curve(place), curve(place, 1), slopes(place))

    def scaled(self, change: Floats, scale: Floats) -> Floats:
        """A change of state (n, m) with every amplitude over its scale (n, n_sensors)."""
        return np.column_stack([change[:, 0], change[:, 1:] / np.repeat(scale, 2, axis=1)])

    @property
    def amplitude(self) -> Complex:
        return self.state[:, 1::2] + 1j * self.state[:, 2::2]


def _columns(branch: PredictedBranch, sensors: Sequence[Sensor]) -> list[int]:
    places = [branch.condition.sensors.index(sensor) for sensor in sensors]
    return [0, *(column for i in places for column in (1 + 2 * i, 2 + 2 * i))]


def _scale(local: _Local, sensors: Sequence[Sensor], truth: PredictedRun) -> Floats:
    """(n, n_sensors) amplitudes that relative noise is relative to: of the first harmonic at the same point; at a point
    that no noise is known of, no less than where it is known, since a further sensor is no better than the others."""
    size = {s: np.abs(local.amplitude[:, i]) for i, s in enumerate(sensors) if s[1] == 1}
    known_at = truth.noise.sensors
    known = [value for (point, _), value in size.items() if point in known_at]
    usual = np.exp(np.mean(np.log(known), axis=0))
    each = [size[point, 1] if point in known_at else np.maximum(size[point, 1], usual) for point, _ in sensors]
    return np.stack(each, axis=1)


def _places(branch: PredictedBranch, other: PredictedBranch) -> Floats:
    """(n,) solved points, about evenly along what a sweep sees of the branch, at frequencies that the other one has
    too: between points a branch is only interpolated."""
    low = max(branch.condition.window[0], other.frequency.min())
    high = min(branch.condition.window[1], other.frequency.max())
    usable = branch.place[branch.visited & (branch.frequency > low) & (branch.frequency < high)]
    if not len(usable):
        return usable
    even = np.linspace(usable[0], usable[-1], _POINTS)
    return usable[np.unique(np.argmin(np.abs(usable[None] - even[:, None]), axis=1))]


def _matched(truth: PredictedRun, model: PredictedRun, place: Floats, sensors: Sequence[Sensor]) -> Floats:
    """(n,) places on the model's branch, found from the first harmonics, which are measured anyway."""
    first = [s for s in sensors if s[1] == 1 and s[0] in truth.noise.sensors]
    a, b = _restricted(truth.branch, first), _restricted(model.branch, first)
    deviation = truth.noise.deviations([point for point, _ in first], truth.scatter.noise)
    deviation = np.broadcast_to(deviation, (len(place), len(deviation)))
    run = Observations("", 0, 0, a.at(place).value, deviation, np.zeros(len(place)))
    sizes = np.sqrt(np.diag(model.covariance))
    return match(b, run, b.u, sizes).place


def _restricted(branch: PredictedBranch, sensors: Sequence[Sensor]) -> PredictedBranch:
    columns = _columns(branch, sensors)
    return replace(
        branch,
        condition=branch.condition.seen_by(sensors),
        state=branch.state[:, columns],
        along=branch.along[:, columns],
        slopes=branch.slopes[..., columns],
        rough=None,
    )
