"""Phases without jumps: each curve unwrapped along its points, then shifted as a whole by turns of 360 degrees."""

from collections import defaultdict
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from updamp.comparison.comparison import CurvePair, ModelCurve

Floats = NDArray[np.float64]
Complex = NDArray[np.complex128]


@dataclass(frozen=True, eq=False)
class CurvePhases:
    """Of one `CurvePair` [degrees]: measured, one array a repeat; before and after, of the model."""

    measured: tuple[Floats, ...]
    before: Floats
    after: Floats


def phases_of(curves: Sequence[CurvePair]) -> tuple[CurvePhases, ...]:
    """The measured curves of a mode at a channel lie beside each other, about a middle within half a turn of zero; the
    model's lie beside them."""
    middles: dict[tuple[str, str], float] = defaultdict(lambda: float("nan"))
    found = []
    for curve in curves:
        measured = []
        for each in curve.measured:
            known = each.receptance if each.has_phase else np.full(len(each.frequency), np.nan + 0j)
            phase = unwrapped_phase(known, np.argsort(each.frequency, kind="stable"))
            phase = phase - turns(_middle(phase) - np.nan_to_num(middles[curve.mode, curve.channel]))
            if np.isnan(middles[curve.mode, curve.channel]):
                middles[curve.mode, curve.channel] = _middle(phase)
            measured.append(phase)
        branches = [_beside(branch, curve, measured) for branch in (curve.before, curve.after)]
        found.append(CurvePhases(tuple(measured), *branches))
    return tuple(found)


def unwrapped_phase(receptance: Complex, order: NDArray[np.int64] | slice = slice(None)) -> Floats:
    """Phases of (n,) [degrees], never more than half a turn from one to the next in this order; nan where the
    receptance is zero or not known, which the next one is unwrapped across"""
    phase = np.full(len(receptance), np.nan)
    along = np.arange(len(receptance))[order]
    known = along[np.isfinite(receptance[along]) & (receptance[along] != 0)]
    phase[known] = np.degrees(np.unwrap(np.angle(receptance[known])))
    return phase


def turns(phase: float) -> float:
    """What of a phase is whole turns [degrees]; zero where it is not known"""
    return 360.0 * round(phase / 360.0) if np.isfinite(phase) else 0.0


def _middle(phase: Floats) -> float:
    known = phase[np.isfinite(phase)]
    return float(known.min() + known.max()) / 2 if len(known) else float("nan")


def _beside(branch: ModelCurve, curve: CurvePair, measured: Sequence[Floats]) -> Floats:
    """Of the model, shifted to where it is nearest to the measured phases at the same frequencies."""
    phase = unwrapped_phase(branch.receptance)
    known = np.flatnonzero(np.isfinite(phase))
    if len(known) == 0 or not measured:
        return phase - turns(_middle(phase))
    differences = [
        phase[known[np.argmin(np.abs(branch.frequency[known, None] - each.frequency), axis=0)]] - values
        for each, values in zip(curve.measured, measured, strict=True)
    ]
    together = np.concatenate(differences)
    return phase - turns(float(np.mean(together[np.isfinite(together)])) if np.isfinite(together).any() else np.nan)
