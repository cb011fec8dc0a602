"""Stated values against the model's: for tests of which no curves are at hand."""

from collections.abc import Callable, Sequence

import numpy as np

from updamp.comparison.comparison import FeatureComparison, Finding
from updamp.measurement.measurement import Feature

RESONANCE, SHIFT = "resonance_frequency", "resonance_frequency_shift"
# Resonance [Hz] of a mode at a force [N], which is nan for the structure without damper; nan where it is not known.
Resonances = Callable[[str, float], float]
# Of a stated value that the model misses: this many standard deviations count.
_LIMIT = 3.0
# In the name of a mode: the excited blade by itself.
WITHOUT_DAMPER = "without damper"


def compare_features(features: Sequence[Feature], resonance: Resonances) -> tuple[FeatureComparison, ...]:
    """raises: ValueError for a quantity that the model has no value for"""
    return tuple(_compared(f, features, resonance) for f in features)


def needed(features: Sequence[Feature]) -> tuple[tuple[str, float], ...]:
    """(mode, force) of the curves that the features need, those without damper left out."""
    found = [(f.mode, f.force) for f in features if np.isfinite(f.force)]
    return tuple(dict.fromkeys([*found, *((f.mode, lowest_force(features, f.mode)) for f in features if _shifts(f))]))


def lowest_force(features: Sequence[Feature], mode: str) -> float:
    """What a shift of a mode's resonance refers to."""
    return min(f.force for f in features if f.mode == mode and np.isfinite(f.force))


def _shifts(feature: Feature) -> bool:
    return feature.quantity == SHIFT


def _compared(feature: Feature, features: Sequence[Feature], resonance: Resonances) -> FeatureComparison:
    if feature.quantity not in (RESONANCE, SHIFT):
        raise ValueError(
            f"feature quantity '{feature.quantity}': the model answers to {RESONANCE} and {SHIFT}; leave this one out"
        )
    model = resonance(feature.mode, feature.force)
    if _shifts(feature):
        model = abs(model / resonance(feature.mode, lowest_force(features, feature.mode)) - 1)
    return FeatureComparison(
        feature.quantity, feature.mode, feature.force, feature.value, feature.lower, feature.upper, model,
        model / feature.value - 1, feature.relative_uncertainty,
    )  # fmt: skip


def feature_findings(compared: Sequence[FeatureComparison]) -> tuple[Finding, ...]:
    """What is not known or beyond a bound first, then by how many of its standard deviations a value is missed."""
    found = [finding for f in compared for finding in _findings_of(f)]
    return tuple(sorted(found, key=lambda f: -abs(f.significance) if np.isfinite(f.significance) else -np.inf))


def _findings_of(f: FeatureComparison) -> list[Finding]:
    """Of a bound how far it is missed is not known in standard deviations: none is stated."""
    level = f.force if np.isfinite(f.force) else None
    at = f" at {f.force:g} N" if level is not None else ""
    name, unit = ("resonance", " Hz") if f.quantity == RESONANCE else ("shift of the resonance", "")

    def finding(text: str, relative: float, significance: float = float("nan")) -> Finding:
        return Finding(f"{f.mode}: {text}", f.mode, level, "frequency", "", relative, significance)

    if np.isnan(f.model):
        return [finding(f"{name}{at} is not known, since the model's curve is not complete", float("nan"))]
    found = []
    if abs(f.relative) > _LIMIT * f.relative_uncertainty:
        side = "high" if f.relative > 0 else "low"
        sizes = f"{f.model:.4g}{unit}, stated {f.measured:.4g}{unit} within {100 * f.relative_uncertainty:.2g} %"
        text = f"{name} {100 * abs(f.relative):.2g} % {side}{at} ({sizes})"
        found.append(finding(text, f.relative, f.relative / f.relative_uncertainty))
    low, high = f.model < f.lower, f.model > f.upper
    if low or high:
        bound, beyond = (f.lower, "below") if low else (f.upper, "above")
        found.append(finding(f"{name}{at} is {f.model:.4g}{unit}, {beyond} the stated {bound:.4g}{unit}",
                             f.model / bound - 1))  # fmt: skip
    return found
