"""Findings about peaks against force with the lumped damper, uniform pressure and the film's pressure."""

from updamp.parameter_study.families import CurveName
from updamp.parameter_study.findings.finding import Measured, mm, percent, share
from updamp.parameter_study.findings.pesaresi_names import (
    FILM,
    FORCES,
    FOURTH,
    HIGHEST,
    IP,
    LOWEST,
    LUMPED,
    MEDIUM,
    OOP,
    SECOND,
    UNIFORM,
)
from updamp.parameter_study.solved_study import SolvedStudy

FIRST_DROP = 0.7  # of the whole drop that has come at 3.84 N, for the first drop to be sharp
CONSTANT = 0.15  # change of the peak from 9.6 to 17 N
RISES = 0.02  # of the low-force peak
LINEAR = 0.05  # change of the peak over all levels
DAMPED = (SECOND, MEDIUM, FOURTH, HIGHEST)  # levels at which something slips


def film_is_best_in_oop(solved: SolvedStudy) -> Measured:
    peaks = {variant: _peaks(solved, variant, OOP) for variant in (FILM, UNIFORM, LUMPED)}
    film, uniform, lumped = peaks.values()
    first = (film[LOWEST] - film[MEDIUM]) / (film[LOWEST] - film[HIGHEST])
    excess = {force: lumped[force] / film[force] - 1 for force in DAMPED}
    most = max(excess, key=excess.__getitem__)
    too_little = all(uniform[force] > film[force] for force in DAMPED)
    words = "; ".join(f"{variant} {_listed(one)}" for variant, one in peaks.items())
    return Measured(
        f"{words} mm/N; {share(first)} of the film's drop by 3.84 N; lumped {percent(excess[most])} at {most:g} N",
        film[HIGHEST] < film[LOWEST] and first >= FIRST_DROP and too_little and min(excess.values()) > 0
        and most <= MEDIUM,
        {"drop by 3.84 N": first, "uniform above film": float(too_little), "lumped most above film at [N]": most,
         "least excess of lumped": min(excess.values())},
    )  # fmt: skip


def uniform_rises_in_ip(solved: SolvedStudy) -> Measured:
    peaks = {variant: _peaks(solved, variant, IP) for variant in (FILM, UNIFORM, LUMPED)}
    film, uniform, lumped = peaks.values()
    constant = film[HIGHEST] / film[FOURTH] - 1
    rise = max(uniform[SECOND], uniform[MEDIUM], uniform[FOURTH]) / uniform[LOWEST] - 1
    change = max(abs(lumped[force] / lumped[LOWEST] - 1) for force in FORCES)
    words = "; ".join(f"{variant} {_listed(one)}" for variant, one in peaks.items())
    return Measured(
        f"{words} mm/N; film {percent(constant)} from 9.6 to 17 N, uniform rises {percent(rise)}, lumped changes by "
        f"{share(change)}",
        abs(constant) <= CONSTANT and rise > RISES and change <= LINEAR,
        {"film from 9.6 to 17 N": constant, "rise of uniform": rise, "change of lumped": change},
    )


def _peaks(solved: SolvedStudy, variant: str, mode: str) -> dict[float, float]:
    """force -> [m/N]"""
    return {force: solved.peak(CurveName(variant, mode, force)).receptance for force in FORCES}


def _listed(peaks: dict[float, float]) -> str:
    return ", ".join(mm(peak) for peak in peaks.values())
