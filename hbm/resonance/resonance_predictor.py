"""The tangent of a branch of resonances, the predictor along it, and the metric of its steps."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from updamp.hbm.continuation.step_lengths import StepLengths
from updamp.hbm.harmonics import Harmonics
from updamp.hbm.newton.metric import Metric
from updamp.hbm.resonance.resonance import Linearised, ResonanceSolution, ResonanceState


@dataclass(frozen=True)
class RelativeMetric:
    """Lengths in (z, w, ln F): z and w as on a response curve (hbm/newton/metric.py), where the mean position hardly
    counts; scale_w: one unit of arc [rad/s]."""

    harmonics: Harmonics
    scale_w: float

    def on_curve(self, here: ResonanceState) -> Metric:
        return Metric.at(here.z, self.harmonics, self.scale_w)

    def product(self, here: ResonanceState, a: ResonanceState, b: ResonanceState) -> float:
        return self.on_curve(here).product((a.z, a.w), (b.z, b.w)) + a.log_force * b.log_force

    def distance(self, here: ResonanceState, there: ResonanceState) -> float:
        move = difference(there, here, 1.0)
        return float(np.sqrt(self.product(here, move, move)))

    def unit(self, here: ResonanceState, towards: ResonanceState) -> ResonanceState:
        length = np.sqrt(self.product(here, towards, towards))
        return ResonanceState(*(part / length for part in (towards.z, towards.w, towards.log_force, towards.phase)))


@dataclass(frozen=True, eq=False)
class BranchOfResonances:
    """The branch of constant phase through a solution, and its sense.

    Along a branch of f(y) = 0 with one unknown more than equations the sign of det(df/dy; t) stays, t its tangent, in
    folds and kinks alike (Eaves and Scarf 1976, Math. Oper. Res. 1). Eliminating the displacements leaves det J times
    the phase's derivatives, so that t follows with its sign from the last linearised equations alone.

    orientation: that sign, 1 or -1
    """

    metric: RelativeMetric
    orientation: float

    @staticmethod
    def from_force(metric: RelativeMetric, first: ResonanceSolution, direction: float) -> "BranchOfResonances":
        """direction: 1 where the force rises from the first resonance on, -1 where it falls"""
        line = first.linearised
        sign = line.jacobian.determinant_sign * np.sign(line.y_by_frequency.imag)
        return BranchOfResonances(metric, float(direction * sign))

    def tangent(self, line: Linearised, state: ResonanceState) -> ResonanceState:
        """Of unit length."""
        sign, force = self.orientation * line.jacobian.determinant_sign, np.exp(state.log_force)
        dw, dlog_force = -sign * line.y_by_log_force.imag, sign * line.y_by_frequency.imag
        dx = -line.by_frequency * dw - line.by_log_force * dlog_force
        return self.metric.unit(state, ResonanceState(dx / force - state.z * dlog_force, dw, dlog_force, 0.0))


@dataclass(frozen=True, eq=False)
class FollowedResonance:
    """tangent: of unit length, along the branch; step: from the point before"""

    solution: ResonanceSolution
    tangent: ResonanceState
    step: float

    @property
    def state(self) -> ResonanceState:
        return self.solution.state


def predict(
    followed: Sequence[FollowedResonance], step: float, metric: RelativeMetric, lengths: StepLengths
) -> ResonanceState:
    """Along the last point's tangent, bent by the change of the tangent since the point before (second order)."""
    last = followed[-1]
    guess = ahead(last.state, last.tangent, step)
    if len(followed) < 2:
        return guess
    before = metric.unit(last.state, followed[-2].tangent)
    if not lengths.bent(step, last.step, metric.product(last.state, before, last.tangent)):
        return guess
    return ahead(guess, difference(last.tangent, before, 1 / last.step), step**2 / 2)


def ahead(state: ResonanceState, rate: ResonanceState, step: float) -> ResonanceState:
    return ResonanceState(
        state.z + step * rate.z,
        state.w + step * rate.w,
        state.log_force + step * rate.log_force,
        state.phase + step * rate.phase,
    )


def difference(a: ResonanceState, b: ResonanceState, factor: float) -> ResonanceState:
    return ResonanceState(
        factor * (a.z - b.z), factor * (a.w - b.w), factor * (a.log_force - b.log_force), factor * (a.phase - b.phase)
    )
