"""A branch ends at the end of its window, not a step beyond, where a neighbour may be higher."""

import numpy as np

from updamp.hbm.continuation.branch import point_at
from updamp.hbm.continuation.curve_records import CurveRequest, with_point, without_point
from updamp.hbm.continuation.response_curve import ResponseCurve
from updamp.hbm.newton.metric import Metric
from updamp.hbm.newton.newton import solve
from updamp.hbm.problem.system import NonlinearSystem


def cut_at_window(system: NonlinearSystem, request: CurveRequest, curve: ResponseCurve) -> ResponseCurve:
    """The curve with its first or last point solved again at the end of the window, where it is the only one beyond."""
    for first in (True, False):
        curve = _cut(system, request, curve, first)
    return curve


def _cut(system: NonlinearSystem, request: CurveRequest, curve: ResponseCurve, first: bool) -> ResponseCurve:
    """The solution is sought from the chord across the end. As it is where there is none within the chord's length of
    it: that is another branch."""
    if len(curve) < 2 or curve.after_gap[1 if first else -1]:
        return curve
    beyond, inside = (0, 1) if first else (len(curve) - 1, len(curve) - 2)
    low, high = request.window
    f, end = curve.frequency, high if curve.frequency[beyond] > high else low
    if low <= f[beyond] <= high or not low <= f[inside] <= high or f[inside] == end:
        return curve
    share, w = (end - f[inside]) / (f[beyond] - f[inside]), 2 * np.pi * end
    way, dw = curve.displacement[beyond] - curve.displacement[inside], 2 * np.pi * (f[beyond] - f[inside])
    on_chord = curve.displacement[inside] + share * way
    scale_w = request.options.scale_w(request.window)
    metric = Metric.at(on_chord, system.harmonics, scale_w)
    solution = solve(system, request.excitation, on_chord, w, request.options.newton)
    chord = metric.length((way, dw))
    if not solution.converged or metric.length((solution.x - on_chord, 0.0)) > chord:
        return curve
    point = point_at(solution, request.excitation, scale_w, (way / chord, dw / chord), 0.0)
    return with_point(system, request, without_point(curve, beyond), point, 0 if first else len(curve) - 1)
