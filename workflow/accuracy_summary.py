"""What a run says of a curve's numerical error: for summary.json and the table."""

from collections.abc import Mapping
from dataclasses import asdict
from typing import Any

from updamp.hbm.analysis.finer_curve import curve_error
from updamp.hbm.analysis.finer_points import PointErrors
from updamp.hbm.continuation.response_curve import ResponseCurve
from updamp.workflow.products import Products

NOTHING = 1e-4  # percent or hertz, below which the table says 0
THREE = ("peak_percent", "resonance_hertz", "flank_percent")


def numerical_error(products: Products, curve: ResponseCurve, point: str) -> dict[str, Any]:
    """What four harmonics more change in the curve; `samples` and `cycles`: what twice the samples and one more cycle
    do; `not_known`: why a part is not, "" otherwise. None where there is no number.
    """
    same = (curve.mode, curve.force)
    finer = next((one.product for one in products.finer if (one.product.mode, one.product.force) == same), None)
    points = next((one.product for one in products.point_errors if (one.product.mode, one.product.force) == same), None)
    entry: dict[str, Any] = {"orders": None, "complete": False}
    if len(curve) and finer is not None and len(finer):
        entry = asdict(curve_error(curve, finer, point))
    for name in ("samples", "cycles"):
        entry[name] = dict(zip(THREE, getattr(points, name), strict=True)) if points is not None else None
    reasons = [_of_the_finer_curve(curve, finer), _of_the_points(points)]
    return {**_without_nan(entry), "not_known": "; ".join(reason for reason in reasons if reason)}


def _of_the_finer_curve(curve: ResponseCurve, finer: ResponseCurve | None) -> str:
    if not len(curve):
        return "not known: the curve has no point"
    if not curve.complete:
        return "not known: the curve is not complete, and was not traced with more harmonics"
    if finer is None or not len(finer):
        return "not known: the curve with more harmonics failed" + (f" ({finer.stopped})" if finer is not None else "")
    if not finer.complete:
        return f"not known: the curve with more harmonics is not complete ({finer.stopped})"
    return ""


def _of_the_points(points: PointErrors | None) -> str:
    if points is None:
        return "not known for samples and cycles: their computation failed"
    return f"not known for samples and cycles: {points.reason}" if points.reason else ""


def _without_nan(entry: Mapping[str, Any]) -> dict[str, Any]:
    """NaN is no JSON."""
    return {
        name: _without_nan(value) if isinstance(value, Mapping) else None if value != value else value
        for name, value in entry.items()
    }


def error_cells(error: Mapping[str, Any] | None) -> tuple[str, str]:
    """Of the peak's height [%] and frequency [Hz]; of a finer curve that is not complete the peak may be another."""
    if error is None or error.get("peak_percent") is None:
        return ("", "") if error is None else ("not known", "")
    mark = "" if error["complete"] else "?"
    return f"{_short(error['peak_percent'])}{mark}", f"{_short(error['resonance_hertz'])}{mark}"


def _short(value: float) -> str:
    """Two digits, none beyond the third decimal."""
    short = f"{value:+.2g}" if abs(value) >= 0.01 else f"{value:+.3f}"
    return short if abs(value) >= NOTHING and float(short) else "0"
