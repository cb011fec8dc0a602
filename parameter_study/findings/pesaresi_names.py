"""Names of variants and contacts, and levels, that the findings of Pesaresi et al. (2017) ask a study for."""

from updamp.parameter_study.families import CurveName

OOP, IP = "OOP", "IP"
FILM, UNIFORM, LUMPED, ASYMMETRIC = "film", "50/50", "lumped", "asymmetric"
SPLITS = (UNIFORM, "70/30", "80/20", "90/10", "100/0")  # rising share of the central area
STIFFNESSES = ("k 5e3", "k 2e4", "k 6e4", "k 2e5", "k 1e6", "k 1e7")  # N/mm^3, rising
STATED_STIFFNESS = "k 6e4"
ODD_NAMES = ("harmonics 1-3", "harmonics 1-10")
WITH_MEAN = "harmonics 0-3"
LOWEST, SECOND, MEDIUM, FOURTH, HIGHEST = FORCES = (0.096, 0.96, 3.84, 9.6, 17.0)  # N
CENTRES, UPPER, LOWER = ("A2", "B2"), "A1", "A3"  # of the faces; of the edges of one of them
EDGES = ("A1", "A3", "A4", "A5", "A6", "B1", "B3")


def film(mode: str, force: float) -> CurveName:
    return CurveName(FILM, mode, force)
