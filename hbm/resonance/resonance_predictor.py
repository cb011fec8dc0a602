"""The predictor on a branch of resonances, and the metric of its steps."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from updamp.hbm.resonance.resonance import ResonanceSolution, ResonanceState


@dataclass(frozen=True)
class RelativeMetric:
    """Lengths in (z, w, ln F): z over its size, w over scale_w [rad/s]."""

    scale_w: float

    def distance(self, here: ResonanceState, there: ResonanceState) -> float:
        dz, dw, dlog_force = there.z - here.z, there.w - here.w, there.log_force - here.log_force
        return float(np.sqrt(np.sum(dz**2) / size_of(here) ** 2 + (dw / self.scale_w) ** 2 + dlog_force**2))

    def unit(self, here: ResonanceState, towards: ResonanceState) -> ResonanceState:
        length = np.sqrt(
            np.sum(towards.z**2) / size_of(here) ** 2 + (towards.w / self.scale_w) ** 2 + towards.log_force**2
        )
        return ResonanceState(*(part / length for part in (towards.z, towards.w, towards.log_force, towards.phase)))


def size_of(state: ResonanceState) -> float:
    return max(float(np.linalg.norm(state.z)), np.finfo(float).tiny)


def predict(
    points: Sequence[ResonanceSolution], step: float, direction: float, metric: RelativeMetric
) -> tuple[ResonanceState, ResonanceState]:
    """Direction of the branch and the state `step` further: a parabola through the last three points, a line through
    two, and from one the tangent of constant phase."""
    last = points[-1].state
    if len(points) == 1:
        normal = metric.unit(last, _tangent(points[0], direction))
        return normal, ahead(last, normal, step)
    before = points[-2].state
    distance = metric.distance(before, last)
    secant = difference(last, before, 1 / distance)
    rate = secant
    if len(points) > 2:
        earlier = points[-3].state
        gap = metric.distance(earlier, before)
        bend = difference(secant, difference(before, earlier, 1 / gap), 1 / (distance + gap))
        rate = ahead(secant, bend, step + distance)
    return metric.unit(last, secant), ahead(last, rate, step)


def _tangent(solution: ResonanceSolution, direction: float) -> ResonanceState:
    """d(z, w, ln F) along the branch of constant phase, ln F moving in `direction`."""
    line, state = solution.linearised, solution.state
    dw = -direction * line.y_by_log_force.imag / line.y_by_frequency.imag
    dx = -line.by_frequency * dw - line.by_log_force * direction
    return ResonanceState(dx / solution.force - state.z * direction, dw, direction, 0.0)


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
