"""The points of one measured run, expanded through the model one by one."""

from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from typing import Any

import numpy as np
from numpy.typing import NDArray
from scipy.interpolate import interp1d

from updamp.comparison.fit.matching import Matched, by_drive
from updamp.comparison.prediction.held_branch import force_at
from updamp.comparison.prediction.predicted_branch import PredictedBranch
from updamp.diagnosis.missing_force.modal_expansion import Expansion, MeasuredPoint, expand
from updamp.diagnosis.missing_force.resonant_mode import ResonantMode, first_harmonics, modal_amplitudes, system_at
from updamp.hbm.newton.observe import response
from updamp.hbm.problem.system import Excitation, NonlinearSystem

Floats = NDArray[np.float64]
Complex = NDArray[np.complex128]
Integers = NDArray[np.int64]

# Points below this share of a run's largest amplitude say next to nothing about the mode.
_LOWEST = 0.15
# Points of a run that are expanded, at most.
_MOST = 24


@dataclass(frozen=True, eq=False)
class ExpandedRun:
    """One run expanded. matched: with k and c of its n points, whitened with the sensors' noise, for the residual
    amplitude: (n,) at the channel [m]; by_force: (n, 2, 2) residual by k [N/m] and c [N s/m]
    test: place of its condition"""

    matched: Matched
    amplitude: Floats
    w: Floats
    by_force: Floats

    @property
    def test(self) -> int:
        return self.matched.observations.test


def expanded_run(matched: Matched, branch: PredictedBranch, excitation: str, mode: ResonantMode) -> ExpandedRun | None:
    """None where not a single point could be expanded. branch: that the run was matched with; excitation: name of the
    point that the shaker acts on

    raises: ValueError where the run does not have the mode's channel
    """
    points = _Points.of(matched, branch, excitation, mode)
    found = {i: e for i in _enough(points.amplitude) if (e := points.expanded(i)) is not None}
    if not found:
        return None
    rows = [_row(e, matched, branch, points.columns, i) for i, e in found.items()]
    residual, by_force, by_parameter, by_observation = (np.stack(each) for each in zip(*rows, strict=True))
    of_points = matched.only(np.array(list(found)))
    return ExpandedRun(
        replace(of_points, residual=residual, by_parameter=by_parameter, by_observation=by_observation),
        np.array([abs(e.displacement) for e in found.values()]),
        np.array([e.w for e in found.values()]),
        by_force,
    )


def _enough(amplitude: Floats) -> Integers:
    """Points that tell of the mode, evenly thinned."""
    useful = np.flatnonzero(amplitude > _LOWEST * amplitude.max())
    return useful[np.unique(np.linspace(0, len(useful) - 1, min(len(useful), _MOST)).round().astype(int))]


def _row(
    expansion: Expansion, matched: Matched, branch: PredictedBranch, columns: Integers, i: int
) -> Sequence[Floats]:
    """Of one point: k and c, and their derivatives, over the sensors' noise."""
    M = np.zeros((2, matched.observations.observed.shape[1]))
    M[:, columns] = expansion.by_observation
    noise = M * _noise(matched, branch, i)
    root = np.linalg.inv(np.linalg.cholesky(noise @ noise.T))
    slopes = branch.at(matched.place[i]).slopes[:-1]
    value = np.array([expansion.missing.real, expansion.missing.imag / expansion.w])
    return root @ value, root, root @ M @ slopes.T, root @ M


def _noise(matched: Matched, branch: PredictedBranch, i: int) -> Floats:
    """(m,) of sensors and numerics together"""
    return np.hypot(matched.observations.noise[i], branch.rough_at(matched.place[i]))


def _added(branch: PredictedBranch, sensors: Integers, excitation: str) -> tuple[Floats, Complex]:
    """What the branch has beyond the solved points that it is made of: (n_points,) of the logarithm of the frequency,
    (n_points, n_sensors) of the logarithms of the amplitudes."""
    points = branch.points
    system = system_at(points[0])
    rows = np.array([system.free.row(branch.condition.sensors[i][0]) for i in sensors])
    excited, condition = system.free.row(excitation), branch.condition
    solved = []
    for p in points:
        force = Excitation(excited, force_at(p, condition))
        amplitude = system.harmonics.amplitude(response(p.solution.equation, force, rows), 1)
        solved.append(amplitude * condition.force / force.force)
    of_frequency = branch.state[:, 0] - np.log([point.frequency for point in points])
    return of_frequency, np.log(branch.amplitude[:, sensors] / np.array(solved))


def _between(place: Floats, known: Floats, values: NDArray[Any]) -> NDArray[Any]:
    """Linearly between known places, along the first axis."""
    return np.asarray(interp1d(known, values, axis=0, bounds_error=False, fill_value=(values[0], values[-1]))(place))


@dataclass(frozen=True, eq=False)
class _Points:
    """The measured points of one run as they would be on the model that the branch was solved for.

    w: (n,) [rad/s]; measured: (n, n_sensors) first harmonics [m]; force: (n,) [N]; columns: of the observations used
    """

    matched: Matched
    branch: PredictedBranch
    system: NonlinearSystem
    mode: ResonantMode
    excited: int
    w: Floats
    measured: Complex
    columns: Integers

    @staticmethod
    def of(matched: Matched, branch: PredictedBranch, excitation: str, mode: ResonantMode) -> "_Points":
        at, system = branch.at(matched.place), system_at(branch.points[0])
        # the force is put into the equations as it was measured, so its share of the difference is left in
        observed = at.value + matched.difference + by_drive(matched.observations, at.slopes)
        sensors = np.array(first_harmonics(branch))
        # what finer numerics are expected to change is in the branch, but not in the equations
        added = _added(branch, sensors, excitation)
        of_frequency, of_amplitude = (_between(matched.place, branch.place, change) for change in added)
        observed[:, 0] -= of_frequency
        observed[:, 1 + 2 * sensors] -= of_amplitude.real
        observed[:, 2 + 2 * sensors] -= of_amplitude.imag
        measured = np.exp(observed[:, 1 + 2 * sensors] + 1j * observed[:, 2 + 2 * sensors])
        columns = np.concatenate([[0], np.stack([1 + 2 * sensors, 2 + 2 * sensors], axis=1).ravel()])
        row = system.free.row(excitation)
        return _Points(matched, branch, system, mode, row, 2 * np.pi * np.exp(observed[:, 0]), measured, columns)

    @cached_property
    def rows(self) -> Integers:
        """(n_sensors,) of the linear model"""
        return np.array([self.system.free.row(self.branch.condition.sensors[i][0]) for i in self._sensors])

    @property
    def _sensors(self) -> Integers:
        return (self.columns[1::2] - 1) // 2

    @property
    def channel(self) -> int:
        """Place among the sensors; raises: ValueError where it was not measured"""
        row = self.system.free.row(self.mode.point)
        if row not in self.rows:
            raise ValueError(
                f"test {self.branch.condition.name!r} does not have the channel at {self.mode.point}, which its mode's "
                "missing force is read off; leave out the test, or that channel everywhere"
            )
        return list(self.rows).index(row)

    @property
    def amplitude(self) -> Floats:
        """(n,) at the channel [m]"""
        return np.asarray(np.abs(self.measured[:, self.channel]))

    def expanded(self, i: int) -> Expansion | None:
        noise = _noise(self.matched, self.branch, i)[self.columns[1:]].reshape(-1, 2)
        force = self.branch.condition.force * float(np.exp(self.matched.observations.log_force[i]))
        point = MeasuredPoint(float(self.w[i]), self.rows, self.channel, self.measured[i], noise)
        return expand(self.system, Excitation(self.excited, force), self.mode, point, self._start(i))

    def _start(self, i: int) -> tuple[Floats, Complex]:
        """Between the two neighbouring points of the branch, in the measured phase and size."""
        branch, place = self.branch, self.matched.place[i]
        after = int(np.clip(np.searchsorted(branch.place, place), 1, len(branch.points) - 1))
        low, high = branch.place[after - 1 : after + 1]
        share = float(np.clip((place - low) / (high - low), 0, 1))
        pair = branch.points[after - 1 : after + 1]
        x = (1 - share) * pair[0].x + share * pair[1].x
        forces = [Excitation(self.excited, force_at(p, branch.condition)) for p in pair]
        q = [modal_amplitudes(p, f)[list(self.mode.numbers)] for p, f in zip(pair, forces, strict=True)]
        return x, (1 - share) * q[0] + share * q[1]
