"""Findings: each is met by curves that behave as the paper says, and fails by curves that do not."""

from dataclasses import dataclass, field

import numpy as np
import pytest

from updamp.parameter_study.families import CurveName
from updamp.parameter_study.findings import (
    contact_stiffness,
    damper_models,
    damper_motion,
    harmonics,
    levels,
    pressure,
)
from updamp.parameter_study.findings.finding import checked
from updamp.parameter_study.findings.pesaresi2017 import PESARESI_2017
from updamp.parameter_study.findings.pesaresi_names import FORCES, SPLITS, STIFFNESSES
from updamp.parameter_study.mode_peak import Peak
from updamp.parameter_study.solved_study import UnknownResultError


@dataclass
class Peaks:
    """Peaks by variant, mode and force, as a solved study has them: (frequency [Hz], receptance [mm/N])."""

    known: dict[tuple[str, str, float], tuple[float, float]] = field(default_factory=dict)

    def peak(self, name: CurveName) -> Peak:
        key = (name.variant, name.mode, name.force)
        if key not in self.known:
            raise UnknownResultError(f"{name.label}: not traced yet")
        frequency, receptance = self.known[key]
        return Peak(frequency, 1e-3 * receptance, 0)


def at_all_levels(variant: str, mode: str, receptances, frequency: float = 440.0) -> dict:
    return {(variant, mode, f): (frequency, r) for f, r in zip(FORCES, receptances, strict=True)}


def split(at_3_84, at_17) -> Peaks:
    return Peaks(
        {
            (variant, "OOP", force): (440.0, value)
            for force, values in ((3.84, at_3_84), (17.0, at_17))
            for variant, value in zip(SPLITS, values, strict=True)
        }
    )


UNEVEN, FLAT = (0.0125, 0.011, 0.009, 0.007, 0.0045), (0.01, 0.009, 0.0082, 0.0085, 0.0088)
STIFF = [(436.0 + 4 * x, 0.0125 - 0.001 * x) for x in (0, 0.5, 0.8, 0.9, 0.97, 1.0)]
SOFT = [(436.0 + 4 * x, 0.0125 - 0.001 * x) for x in (0, 0.01, 0.02, 0.2, 0.5, 1.0)]


def stiffnesses(values) -> Peaks:
    return Peaks({(name, "OOP", 3.84): value for name, value in zip(STIFFNESSES, values, strict=True)})


def ip_harmonics(few: float, many: float, mean: float) -> Peaks:
    names = ("harmonics 1-3", "harmonics 1-10", "harmonics 0-3")
    return Peaks({(name, "IP", 9.6): (f, 0.01) for name, f in zip(names, (few, many, mean), strict=True)})


def asymmetric(low: float, high: float, frequency: float = 440.0) -> Peaks:
    known = {("50/50", "OOP", f): (440.0, 0.01) for f in (3.84, 17.0)}
    changed = {("asymmetric", "OOP", f): (frequency, v) for f, v in ((3.84, low), (17.0, high))}
    return Peaks(known | changed)


def models(mode: str, film, uniform, lumped) -> Peaks:
    return Peaks(
        at_all_levels("film", mode, film)
        | at_all_levels("50/50", mode, uniform)
        | at_all_levels("lumped", mode, lumped)
    )


OOP_FILM, OOP_UNIFORM = (0.0125, 0.009, 0.0066, 0.006, 0.0058), (0.0125, 0.0122, 0.011, 0.009, 0.008)
OOP_LUMPED = (0.0125, 0.0125, 0.0124, 0.0100, 0.0090)
IP_FILM, IP_UNIFORM = (0.0095, 0.0085, 0.008, 0.0076, 0.0075), (0.0095, 0.0098, 0.011, 0.009, 0.008)
LINEAR = (0.0095,) * 5

CASES = [
    (levels.oop_peak_falls, Peaks(at_all_levels("film", "OOP", OOP_FILM)), True),
    (levels.oop_peak_falls, Peaks(at_all_levels("film", "OOP", (0.0125, 0.0122, 0.012, 0.011, 0.009))), False),
    (levels.oop_peak_falls,
     Peaks(at_all_levels("film", "OOP", OOP_FILM) | {("film", "OOP", 17.0): (435.0, 0.0058)}), False),
    (levels.above_the_test, Peaks({("film", "OOP", 0.096): (440.0, 0.01), ("film", "IP", 0.096): (424.0, 0.01)}), True),
    (levels.above_the_test,
     Peaks({("film", "OOP", 0.096): (440.0, 0.01), ("film", "IP", 0.096): (400.0, 0.01)}), False),
    (pressure.uneven_pressure_damps, split(UNEVEN, FLAT), True),
    (pressure.uneven_pressure_damps, split(FLAT, FLAT), False),
    (pressure.uneven_pressure_damps, split((0.0125, 0.0125, 0.012, 0.011, 0.01), FLAT), False),
    (pressure.lowest_at_80_20, split(UNEVEN, FLAT), True),
    (pressure.lowest_at_80_20, split(UNEVEN, tuple(reversed(FLAT))), True),
    (pressure.lowest_at_80_20, split(FLAT, UNEVEN), False),
    (pressure.asymmetry_matters_at_low_force, asymmetric(0.007, 0.009), True),
    (pressure.asymmetry_matters_at_low_force, asymmetric(0.009, 0.007), False),
    (pressure.asymmetry_matters_at_low_force, asymmetric(0.007, 0.009, 434.0), False),
    (contact_stiffness.stiffness_matters_when_low, stiffnesses(STIFF), True),
    (contact_stiffness.stiffness_matters_when_low, stiffnesses(SOFT), False),
    (contact_stiffness.stiffness_matters_when_low, stiffnesses([(f, 0.02 - r) for f, r in STIFF]), False),
    (harmonics.mean_position_softens_ip, ip_harmonics(424.0, 423.9, 415.0), True),
    (harmonics.mean_position_softens_ip, ip_harmonics(424.0, 420.0, 415.0), False),
    (harmonics.mean_position_softens_ip, ip_harmonics(424.0, 424.0, 424.0), False),
    (damper_models.film_is_best_in_oop, models("OOP", OOP_FILM, OOP_UNIFORM, OOP_LUMPED), True),
    (damper_models.film_is_best_in_oop, models("OOP", OOP_UNIFORM, OOP_FILM, OOP_LUMPED), False),
    (damper_models.film_is_best_in_oop, models("OOP", (*OOP_FILM[:1], 0.0124, 0.0123, 0.01, 0.006), OOP_UNIFORM,
                                               OOP_LUMPED), False),
    (damper_models.uniform_rises_in_ip, models("IP", IP_FILM, IP_UNIFORM, LINEAR), True),
    (damper_models.uniform_rises_in_ip, models("IP", IP_FILM, IP_FILM, LINEAR), False),
    (damper_models.uniform_rises_in_ip, models("IP", IP_FILM, IP_UNIFORM, IP_UNIFORM), False),
]  # fmt: skip


@pytest.mark.parametrize(("finding", "solved", "met"), CASES)
def test_a_finding_is_met_or_not(finding, solved, met):
    found = finding(solved)
    assert found.met is met or found.met == met
    assert found.updamp
    assert all(np.isfinite(value) for value in found.numbers.values())


def test_what_is_not_traced_is_not_known():
    found = [checked(finding, Peaks()) for finding in PESARESI_2017 if finding.number in (1, 5, 6, 7, 8, 9, 11, 12, 13)]
    assert all(one.met is None for one in found)
    assert all(one.updamp.startswith("not known: ") and "not traced yet" in one.updamp for one in found)


def test_corners_in_phase_are_translation_and_in_antiphase_rolling():
    from support.curves import softening_curve

    class OneCurve:
        def curve(self, name):
            return softening_curve(name.mode, softening=1.0)

        def peak_of(self, name, curve):  # noqa: ARG002
            return Peak(420.0, 1e-5, 100)

    rolling = damper_motion.corner_motion(OneCurve(), CurveName("film", "IP", 1.0))
    assert rolling.phase == pytest.approx(180)
    assert rolling.rotation == pytest.approx(2.0)
    assert damper_motion.corner_motion(OneCurve(), CurveName("film", "OOP", 1.0)).rotation == pytest.approx(1 / 6)
