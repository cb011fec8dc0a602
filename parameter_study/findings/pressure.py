"""Findings about how the pressure is spread over the faces."""

from itertools import pairwise

from updamp.parameter_study.families import CurveName
from updamp.parameter_study.findings.finding import Measured, mm, percent
from updamp.parameter_study.findings.pesaresi_names import ASYMMETRIC, HIGHEST, MEDIUM, OOP, SPLITS, UNIFORM
from updamp.parameter_study.solved_study import SolvedStudy

REACH = (0.5, 0.8)  # of the reduction: "up to 65 %", to 15 points
LITTLE = 0.01  # of the frequency


def uneven_pressure_damps(solved: SolvedStudy) -> Measured:
    peaks = _split_peaks(solved, MEDIUM)
    falling = all(one > other for one, other in pairwise(peaks.values()))
    reduction = 1 - min(peaks.values()) / peaks[UNIFORM]
    return Measured(
        f"{_listed(peaks)} mm/N; lowest {percent(-reduction)} against 50/50",
        falling and REACH[0] <= reduction <= REACH[1],
        {"largest reduction": reduction, "falls throughout": float(falling), **peaks},
    )


def lowest_at_80_20(solved: SolvedStudy) -> Measured:
    spread = {force: _spread(_split_peaks(solved, force)) for force in (MEDIUM, HIGHEST)}
    peaks = _split_peaks(solved, HIGHEST)
    lowest = min(peaks, key=peaks.__getitem__)
    return Measured(
        f"{_listed(peaks)} mm/N; lowest at {lowest}; spread {spread[HIGHEST]:.0%} of 50/50 against "
        f"{spread[MEDIUM]:.0%} at 3.84 N",
        lowest == "80/20" and spread[HIGHEST] < spread[MEDIUM],
        {"spread at 17 N": spread[HIGHEST], "spread at 3.84 N": spread[MEDIUM], **peaks},
    )


def asymmetry_matters_at_low_force(solved: SolvedStudy) -> Measured:
    change, shift = {}, {}
    for force in (MEDIUM, HIGHEST):
        one, other = (solved.peak(CurveName(variant, OOP, force)) for variant in (ASYMMETRIC, UNIFORM))
        change[force], shift[force] = one.receptance / other.receptance - 1, one.frequency / other.frequency - 1
    words = "; ".join(f"{f:g} N: peak {percent(change[f])}, resonance {percent(shift[f], 2)}" for f in change)
    return Measured(
        f"against 50/50: {words}",
        abs(change[MEDIUM]) > abs(change[HIGHEST]) and max(map(abs, shift.values())) < LITTLE,
        {f"peak at {f:g} N": v for f, v in change.items()} | {f"resonance at {f:g} N": v for f, v in shift.items()},
    )


def _split_peaks(solved: SolvedStudy, force: float) -> dict[str, float]:
    """variant -> [m/N], from even to uneven"""
    return {variant: solved.peak(CurveName(variant, OOP, force)).receptance for variant in SPLITS}


def _spread(peaks: dict[str, float]) -> float:
    return (max(peaks.values()) - min(peaks.values())) / peaks[UNIFORM]


def _listed(peaks: dict[str, float]) -> str:
    return ", ".join(f"{variant} {mm(peak)}" for variant, peak in peaks.items())
