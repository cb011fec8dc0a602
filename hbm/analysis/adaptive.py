"""The cheapest setting that meets a stated tolerance at the peak."""

import math
from dataclasses import dataclass, field
from enum import Enum

from updamp.hbm.analysis.accuracy import CheckedPoints, Deviation, ErrorEstimate, estimate_error
from updamp.hbm.analysis.settings import (
    Refinement,
    Setting,
    all_finer,
    more_harmonics,
    one_more_cycle,
    setting_of,
    twice_the_samples,
    with_setting,
)
from updamp.hbm.continuation.curve import CurveRequest, trace
from updamp.hbm.continuation.response_curve import ResponseCurve
from updamp.hbm.problem.system import NonlinearSystem


@dataclass(frozen=True)
class Tolerance:
    """Of the peak's height [percent of it] and of the resonance's frequency [Hz].

    raises: ValueError naming the one that is not positive
    """

    percent: float
    hertz: float = math.inf

    def __post_init__(self) -> None:
        for name in ("percent", "hertz"):
            if not getattr(self, name) > 0:
                raise ValueError(f"{name} = {getattr(self, name)}: a tolerance must be positive")

    def share(self, deviation: Deviation | ErrorEstimate) -> float:
        """The larger of both errors over its tolerance; infinite where the finer problem was not solved."""
        together = deviation.together if isinstance(deviation, ErrorEstimate) else deviation
        share = max(abs(together.peak_percent) / self.percent, abs(together.peak_hertz) / self.hertz)
        return math.inf if math.isnan(together.peak_percent) or math.isnan(share) else share


@dataclass(frozen=True)
class Limits:
    """Where the search begins, and the most of each that it may use.

    raises: ValueError where the beginning is beyond the limits
    """

    start: Setting = field(default_factory=lambda: Setting((0, 1), 64, 2))
    highest_order: int = 9
    time_samples: int = 512
    cycles: int = 4

    def __post_init__(self) -> None:
        if not self.allow(self.start):
            raise ValueError(f"the search cannot begin at {self.start}: raise the limits")

    def allow(self, setting: Setting) -> bool:
        return (
            setting.orders[-1] <= self.highest_order
            and setting.time_samples <= self.time_samples
            and (setting.cycles or 1) <= self.cycles
        )


class AdaptiveStatus(Enum):
    """What became of the search; `advice` says what to try."""

    MET = "tolerance met"
    LIMITS_REACHED = "limits reached"
    NOT_TRACED = "curve not traced"

    @property
    def advice(self) -> str:
        return _ADVICE[self]


_ADVICE = {
    AdaptiveStatus.MET: "",
    AdaptiveStatus.LIMITS_REACHED: "no setting within the limits meets the tolerance: raise either",
    AdaptiveStatus.NOT_TRACED: "the curve stopped before the end of its window: see its `stopped`",
}


@dataclass(frozen=True, eq=False)
class AdaptiveResult:
    """setting: the one chosen, or where the search ended; curve: traced with it; estimate: of that curve, None where it
    was not traced; tried: all settings in turn
    """

    status: AdaptiveStatus
    setting: Setting
    estimate: ErrorEstimate | None
    curve: ResponseCurve
    tried: tuple[Setting, ...]


def adaptive(
    system: NonlinearSystem, request: CurveRequest, tolerance: Tolerance, limits: Limits | None = None
) -> AdaptiveResult:
    """Trace with the first setting, then move the points around the peak from setting to setting, each time raising
    what contributes more than a third of the tolerance, and trace with the setting that meets it.

    The peak is that of the first of the request's points.
    """
    limits = limits or Limits()
    setting, tried = _without_idle_cycles(system, limits.start), []
    while True:
        tried.append(setting)
        traced = with_setting(system, setting)
        *_, curve = trace(traced, request)
        if not curve.complete:
            return AdaptiveResult(AdaptiveStatus.NOT_TRACED, setting, None, curve, tuple(tried))
        estimate = estimate_error(traced, request, curve)
        if tolerance.share(estimate) <= 1:
            return AdaptiveResult(AdaptiveStatus.MET, setting, estimate, curve, tuple(tried))
        peak = CheckedPoints.of(traced, request, curve, request.points[0]).only_peak()
        finer = _refined(peak, setting, tolerance, limits)
        if finer is None:
            return AdaptiveResult(AdaptiveStatus.LIMITS_REACHED, setting, estimate, curve, tuple(tried))
        setting = _search(peak, finer, tolerance, limits, tried)


def _search(
    peak: CheckedPoints, setting: Setting, tolerance: Tolerance, limits: Limits, tried: list[Setting]
) -> Setting:
    """From setting to setting around the peak, until the tolerance is met, the limits are reached, or the points
    cannot follow."""
    while True:
        moved = peak.moved_to(setting)
        if moved is None or tolerance.share(moved.deviation(all_finer)) <= 1:
            return setting
        finer = _refined(moved, setting, tolerance, limits)
        if finer is None:
            return setting
        tried.append(setting)
        peak, setting = moved, finer


def _refined(peak: CheckedPoints, setting: Setting, tolerance: Tolerance, limits: Limits) -> Setting | None:
    """The setting with everything refined that contributes more than a third of the tolerance, or else most of all;
    None where the limits do not allow any of it, or not what alone exceeds the tolerance."""
    contributions: list[tuple[float, Refinement]] = [
        (tolerance.share(peak.deviation(more_harmonics)), _two_more_harmonics),
        (tolerance.share(peak.deviation(twice_the_samples)), twice_the_samples),
    ]
    if setting.cycles is not None:
        contributions.append((tolerance.share(peak.deviation(one_more_cycle)), one_more_cycle))
    possible = [(share, refine) for share, refine in contributions if limits.allow(refine(setting))]
    exhausted = [share for share, refine in contributions if not limits.allow(refine(setting))]
    if not possible or max(exhausted, default=0.0) > 1:
        return None
    threshold = min(1 / 3, max(share for share, _ in possible))
    refined = setting
    for share, refine in possible:
        if share >= threshold and limits.allow(refine(refined)):
            refined = refine(refined)
    return refined


def _two_more_harmonics(setting: Setting) -> Setting:
    return more_harmonics(setting, further=2)


def _without_idle_cycles(system: NonlinearSystem, setting: Setting) -> Setting:
    """Cycles are left out of the setting where no law has any."""
    return setting if setting_of(system).cycles is not None else Setting(setting.orders, setting.time_samples, None)
