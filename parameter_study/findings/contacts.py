"""Findings about single contacts: their states over a period, and their force loops."""

import numpy as np
from numpy.typing import NDArray

from updamp.fem.contact_places import distance_from_centre
from updamp.hbm.newton.observe import ContactState
from updamp.parameter_study.families import CurveName
from updamp.parameter_study.findings.finding import Measured, share
from updamp.parameter_study.findings.pesaresi_names import (
    CENTRES,
    EDGES,
    FORCES,
    HIGHEST,
    IP,
    LOWER,
    OOP,
    SECOND,
    UPPER,
    film,
)
from updamp.parameter_study.solved_study import SolvedStudy, loop_at

GONE = 0.01  # of the area
IN_PHASE, ANTIPHASE = 45.0, 135.0  # degrees: at most, at least


def edges_slip_first(solved: SolvedStudy) -> Measured:
    levels = [film(OOP, force) for force in FORCES]
    name = next((n for n in levels if _slipping(solved, n).any()), levels[-1])
    far = distance_from_centre(solved.patches(name.variant))
    slips = _slipping(solved, name)
    stuck_there = solved.states(name) == ContactState.STUCK
    inside, outside = (float(far[which].mean()) if which.any() else 0.0 for which in (stuck_there, slips))
    stuck = {force: _stuck_area(solved, force) for force in (SECOND, HIGHEST)}
    return Measured(
        f"OOP slips first at {name.force:g} N, mean distance from the centre {outside:.2f}, where it sticks "
        f"{inside:.2f}; IP: {share(stuck[SECOND])} of the area stuck at 0.96 N, {share(stuck[HIGHEST])} at 17 N",
        bool(outside > inside) and stuck[SECOND] > GONE and stuck[HIGHEST] <= GONE,
        {"slipping, distance from the centre": outside, "stuck, distance from the centre": inside,
         "IP stuck area at 0.96 N": stuck[SECOND], "IP stuck area at 17 N": stuck[HIGHEST]},
    )  # fmt: skip


def loops_from_centre_to_edge(solved: SolvedStudy) -> Measured:
    centres = [loop_at(solved, film(OOP, HIGHEST), contact).state for contact in CENTRES]
    edges = [loop_at(solved, film(mode, HIGHEST), contact).state for mode in (OOP, IP) for contact in EDGES]
    opening = sum(state is ContactState.SEPARATING for state in edges)
    apart = {mode: _edges_apart(solved, mode) for mode in (OOP, IP)}
    words = ", ".join(f"{mode} tangential {t:.0f}, normal {n:.0f}" for mode, (t, n) in apart.items())
    stuck = all(state is ContactState.STUCK for state in centres)
    return Measured(
        f"centres in OOP at 17 N {'stuck' if stuck else 'not all stuck'}; {opening} of {len(edges)} edge contacts "
        f"separate; A1 against A3, degrees apart: {words}",
        stuck and opening > 0 and any(t <= IN_PHASE and n >= ANTIPHASE for t, n in apart.values()),
        {"centres stuck": float(stuck), "edge contacts that separate": opening}
        | {f"{mode} tangential apart [degrees]": t for mode, (t, _) in apart.items()}
        | {f"{mode} normal apart [degrees]": n for mode, (_, n) in apart.items()},
    )  # fmt: skip


def _edges_apart(solved: SolvedStudy, mode: str) -> tuple[float, float]:
    """First harmonics of A1 and A3 at the highest force: tangential, normal [degrees]"""
    upper, lower = (loop_at(solved, film(mode, HIGHEST), contact) for contact in (UPPER, LOWER))
    tangential, normal = (_apart(upper.first_harmonic(d), lower.first_harmonic(d)) for d in (0, 2))
    return tangential, normal


def _slipping(solved: SolvedStudy, name: CurveName) -> NDArray[np.bool_]:
    """(n_contacts,) whether a contact slips, or opens for part of the period"""
    return np.isin(solved.states(name), (ContactState.STICK_SLIP, ContactState.SEPARATING))


def _stuck_area(solved: SolvedStudy, force: float) -> float:
    """Share of both faces in IP."""
    name = film(IP, force)
    area = solved.patches(name.variant).area
    return float(area[solved.states(name) == ContactState.STUCK].sum() / area.sum())


def _apart(one: complex, other: complex) -> float:
    """[degrees], 0 to 180"""
    return float(abs(np.degrees(np.angle(one * np.conj(other)))))
