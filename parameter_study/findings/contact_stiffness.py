"""The finding about contact stiffness."""

from itertools import pairwise

from updamp.parameter_study.families import CurveName
from updamp.parameter_study.findings.finding import Measured, mm, share
from updamp.parameter_study.findings.pesaresi_names import MEDIUM, OOP, STATED_STIFFNESS, STIFFNESSES
from updamp.parameter_study.solved_study import SolvedStudy

CHANGE = (0.005, 0.02)  # of the frequency: "about 1 %"
READING = 0.01  # of a peak: what nobody would see in a figure


def stiffness_matters_when_low(solved: SolvedStudy) -> Measured:
    peaks = {name: solved.peak(CurveName(name, OOP, MEDIUM)) for name in STIFFNESSES}
    softest, stiffest = peaks[STIFFNESSES[0]], peaks[STIFFNESSES[-1]]
    change = stiffest.frequency / softest.frequency - 1
    low_end = (peaks[STATED_STIFFNESS].frequency - softest.frequency) / (stiffest.frequency - softest.frequency)
    sizes = [peak.receptance for peak in peaks.values()]
    larger = sizes[0] > sizes[-1] and all(stiffer < (1 + READING) * softer for softer, stiffer in pairwise(sizes))
    words = ", ".join(f"{name[2:]}: {p.frequency:.2f} Hz, {mm(p.receptance)} mm/N" for name, p in peaks.items())
    return Measured(
        f"frequency rises by {100 * change:.2f} %, {share(low_end)} of it below 6e4 N/mm^3 ({words})",
        CHANGE[0] <= change <= CHANGE[1] and low_end > 0.5 and larger,
        {"change of the frequency": change, "share below 6e4": low_end, "lower stiffness, larger peak": float(larger)},
    )
