"""What twice the time samples and one more hysteresis cycle change at the peak and on its flanks: points solved again.

More harmonics may move a branch by many half-widths, so that for those a whole curve is traced again
(hbm/analysis/finer_curve.py). Samples and cycles move it little, and a few points tell.
"""

from dataclasses import dataclass

import numpy as np

from updamp.hbm.analysis.accuracy import CheckedPoints, Deviation
from updamp.hbm.analysis.settings import one_more_cycle, setting_of, twice_the_samples
from updamp.hbm.continuation.curve import CurveRequest
from updamp.hbm.continuation.response_curve import ResponseCurve
from updamp.hbm.problem.system import NonlinearSystem


@dataclass(frozen=True)
class PointErrors:
    """Finer less the curve; not a number where a finer point was not solved, or no law has cycles.

    samples, cycles: (change of the peak's height [percent of it], shift of the resonance [Hz], largest change on the
    flanks [percent of the peak])
    reason: why they are not known, "" where they are
    """

    mode: str
    force: float
    samples: tuple[float, float, float]
    cycles: tuple[float, float, float]
    reason: str = ""


UNKNOWN = (float("nan"),) * 3


def point_errors(system: NonlinearSystem, request: CurveRequest, curve: ResponseCurve, point: str) -> PointErrors:
    """Nothing is raised: what cannot be computed is not known, with the reason."""
    if len(curve) < 2:
        return PointErrors(curve.mode, curve.force, UNKNOWN, UNKNOWN, "the branch has fewer than two points")
    try:
        checked = _peak_and_flanks(system, request, curve, point)
        samples = checked.deviation(twice_the_samples)
        cycles = checked.deviation(one_more_cycle) if setting_of(system).cycles is not None else None
    except Exception as error:  # of a law or a factorisation: no run is lost by its estimate of accuracy
        return PointErrors(curve.mode, curve.force, UNKNOWN, UNKNOWN, f"{type(error).__name__}: {error}")
    lost = [f"{f:.2f}" for one in (samples, cycles) if one is not None for f in one.unsolved]
    reason = f"finer points were not solved at {', '.join(dict.fromkeys(lost))} Hz" if lost else ""
    return PointErrors(curve.mode, curve.force, _three(samples), _three(cycles) if cycles else UNKNOWN, reason)


def _three(deviation: Deviation) -> tuple[float, float, float]:
    return deviation.peak_percent, deviation.peak_hertz, deviation.elsewhere_percent


def _peak_and_flanks(system: NonlinearSystem, request: CurveRequest, curve: ResponseCurve, point: str) -> CheckedPoints:
    """The points around the peak, and the first ones below 1 / sqrt(2) of it on both sides."""
    size = np.abs(curve.receptance(point))
    top = int(np.argmax(size))
    below = np.flatnonzero(size < size[top] / np.sqrt(2))
    flanks = np.array([*below[below < top][-1:], *below[below > top][:1]], dtype=np.int64)
    return CheckedPoints.at(system, request, curve, point, flanks)
