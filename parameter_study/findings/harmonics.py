"""The finding about the harmonics kept."""

from updamp.parameter_study.families import CurveName
from updamp.parameter_study.findings.finding import Measured, mm
from updamp.parameter_study.findings.pesaresi_names import FOURTH, IP, ODD_NAMES, WITH_MEAN
from updamp.parameter_study.solved_study import SolvedStudy

NEARLY = 0.2  # what 1-10 change of 1-3, over what the mean position changes


def mean_position_softens_ip(solved: SolvedStudy) -> Measured:
    names = (*ODD_NAMES, WITH_MEAN)
    peaks = {name: solved.peak(CurveName(name, IP, FOURTH)) for name in names}
    few, many, mean = (peaks[name] for name in names)
    apart, softened = abs(many.frequency - few.frequency), few.frequency - mean.frequency
    words = ", ".join(
        f"{name.removeprefix('harmonics ')}: {p.frequency:.2f} Hz, {mm(p.receptance)} mm/N" for name, p in peaks.items()
    )
    return Measured(
        f"IP at 9.6 N: {words}",
        softened > 0 and apart < NEARLY * softened,
        {"1-10 from 1-3 [Hz]": apart, "0-3 below 1-3 [Hz]": softened},
    )
