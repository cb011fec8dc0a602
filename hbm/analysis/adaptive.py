"""Harmonics added to a curve while they change its peak: whole curves are traced, until two in turn agree.

Points solved again near a curve do not tell where contacts open: there the branch moves by many half-widths, and
Newton's method finds none from the coarser one's points.
"""

from collections.abc import Callable
from dataclasses import dataclass
from enum import Enum

import numpy as np

from updamp.hbm.analysis.finer_curve import curve_error
from updamp.hbm.analysis.settings import Setting
from updamp.hbm.continuation.completeness import half_width
from updamp.hbm.continuation.response_curve import ResponseCurve

FURTHER, HIGHEST = 2, 11  # orders added at a time, and the highest that is tried
HALF_WIDTHS = 0.1  # by which the resonance may move where the peak's height has settled


class AdaptiveStatus(Enum):
    """What became of the search."""

    MET = "further harmonics move the peak by no more than the tolerance"
    HIGHEST_REACHED = "the highest harmonics that are tried still move the peak by more than the tolerance"
    FINER_NOT_TRACED = "the curve with further harmonics is not complete: whether the tolerance is met is not known"
    NOT_TRACED = "the first curve is not complete"


@dataclass(frozen=True, eq=False)
class AdaptiveResult:
    """curve: the coarsest that meets the tolerance, or the finest complete one; None where tracing was interrupted
    tried: harmonics in turn; status: None where tracing was interrupted
    """

    curve: ResponseCurve | None
    tried: tuple[tuple[int, ...], ...]
    status: AdaptiveStatus | None


def adaptive(
    traced_with: Callable[[tuple[int, ...]], ResponseCurve | None],
    orders: tuple[int, ...],
    point: str,
    tolerance: float,
    highest: int = HIGHEST,
) -> AdaptiveResult:
    """traced_with: harmonics -> their curve, None after an interruption; orders: the first ones
    tolerance: of the height of the peak at `point`, as a share of it

    raises: ValueError where the tolerance is not positive
    """
    if not tolerance > 0:
        raise ValueError(f"tolerance = {tolerance}: a share of the peak above 0, such as 0.01")
    tried, curve = [orders], traced_with(orders)
    if curve is None or not curve.complete:
        return AdaptiveResult(curve, tuple(tried), AdaptiveStatus.NOT_TRACED if curve is not None else None)
    while tried[-1][-1] + FURTHER <= highest:
        tried.append(further(tried[-1]))
        finer = traced_with(tried[-1])
        if finer is None:
            return AdaptiveResult(None, tuple(tried), None)
        if not finer.complete:
            return AdaptiveResult(curve, tuple(tried), AdaptiveStatus.FINER_NOT_TRACED)
        if agree(curve, finer, point, tolerance):
            return AdaptiveResult(curve, tuple(tried), AdaptiveStatus.MET)
        curve = finer
    return AdaptiveResult(curve, tuple(tried), AdaptiveStatus.HIGHEST_REACHED)


def further(orders: tuple[int, ...]) -> tuple[int, ...]:
    return (*orders, *range(orders[-1] + 1, orders[-1] + FURTHER + 1))


def agree(curve: ResponseCurve, finer: ResponseCurve, point: str, tolerance: float) -> bool:
    """Whether the peak's height changes by no more than the tolerance and its frequency by little of the half-width."""
    error = curve_error(curve, finer, point)
    size = np.abs(curve.receptance(point))
    near = abs(error.resonance_hertz) <= HALF_WIDTHS * half_width(curve.frequency, size)
    return near and abs(error.peak_percent) <= 100 * tolerance


def with_orders(setting: Setting, orders: tuple[int, ...]) -> Setting:
    """The setting with these harmonics, samples raised where further ones need it."""
    if orders == setting.orders:
        return setting
    return Setting(orders, max(setting.time_samples, 4 * orders[-1]), setting.cycles)
