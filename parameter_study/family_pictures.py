"""What can be drawn of a family of curves: one function each, and a line in `PICTURES`."""

from collections.abc import Callable, Iterable, Iterator, Mapping
from dataclasses import dataclass
from functools import partial
from pathlib import Path
from types import MappingProxyType

from updamp.hbm.continuation.response_curve import ResponseCurve
from updamp.parameter_study.families import CurveName, Family
from updamp.parameter_study.findings.damper_motion import mean_lift, mean_opening
from updamp.parameter_study.solved_study import SolvedStudy, UnknownResultError, loop_at
from updamp.pictures import faces, force_loops, kinematics, mean_position, variants
from updamp.pictures.mean_position import MeanPosition
from updamp.pictures.variants import DrawnCurve, PeakPoint


@dataclass(frozen=True)
class FamilyPicture:
    """name: of the file, without its ending; caption: below it on the page; draw: writes the file"""

    name: str
    caption: str
    draw: Callable[[Path], None]


Pictures = Callable[[SolvedStudy, Family], Iterator[FamilyPicture]]


def known(solved: SolvedStudy, names: Iterable[CurveName]) -> dict[CurveName, ResponseCurve]:
    """Of the curves that are there, complete or not."""
    return {name: curve for name in names if (curve := solved.curves.get(name)) is not None and len(curve) > 1}


def complete(solved: SolvedStudy, names: Iterable[CurveName]) -> dict[CurveName, ResponseCurve]:
    return {name: curve for name, curve in known(solved, names).items() if curve.complete}


def groups(family: Family) -> Iterator[tuple[str, dict[str, CurveName]]]:
    """Curves that are drawn over each other, label -> curve, with what they have in common: the variants of a mode at
    each force; the forces of the only variant."""
    for mode in family.modes:
        own = [name for name in family.curves() if name.mode == mode]
        if len(family.variants) == 1:
            yield f"{mode}, {family.variants[0]}", {f"{name.force:g} N": name for name in own}
            continue
        for force in family.forces:
            yield f"{mode} at {force:g} N", {name.variant: name for name in own if name.force == force}


def responses(solved: SolvedStudy, family: Family) -> Iterator[FamilyPicture]:
    for title, names in groups(family):
        curves = known(solved, names.values())
        labelled = {label: _drawn_curve(solved, name, curves[name]) for label, name in names.items() if name in curves}
        if labelled:
            by_force = len(family.variants) == 1
            draw = partial(variants.variant_responses, title=title, curves=labelled, in_order=by_force)
            yield FamilyPicture(_file(family, "responses", title), f"Receptances, {title}; dots: peaks.", draw)


def _drawn_curve(solved: SolvedStudy, name: CurveName, curve: ResponseCurve) -> DrawnCurve:
    peak = solved.peak_of(name, curve)
    return DrawnCurve(curve, solved.point(name.variant), (peak.frequency, peak.receptance))


def against_test(solved: SolvedStudy, family: Family) -> Iterator[FamilyPicture]:
    """With the resonances that a test found."""
    for mode in family.modes:
        curves = known(solved, (name for name in family.curves() if name.mode == mode))
        labelled = {
            f"{name.variant}, {name.force:g} N": _drawn_curve(solved, name, curve) for name, curve in curves.items()
        }
        marks = [(f"measured, {m.force:g} N", m.frequency) for m in solved.study.measured if m.mode == mode]
        if labelled and marks:
            draw = partial(variants.variant_responses, title=f"{mode}: model and test", curves=labelled, measured=marks)
            yield FamilyPicture(
                _file(family, "against_test", mode), f"{mode}; dashed: resonances that the test found.", draw
            )


def peaks_against_force(solved: SolvedStudy, family: Family) -> Iterator[FamilyPicture]:
    for mode in family.modes:
        peaks: dict[str, list[PeakPoint]] = {}
        for name, curve in known(solved, (n for n in family.curves() if n.mode == mode)).items():
            peak = solved.peak_of(name, curve)
            point = PeakPoint(name.force, peak.frequency, peak.receptance, curve.complete)
            peaks.setdefault(name.variant, []).append(point)
        if peaks:
            draw = partial(variants.peaks_against_force, title=f"{mode}: peak against force", peaks=peaks)
            yield FamilyPicture(
                _file(family, "peaks", mode), f"{mode}; hollow: read off a curve that is not complete.", draw
            )


def damper_motion(solved: SolvedStudy, family: Family) -> Iterator[FamilyPicture]:
    """At the lowest and at the highest force of the first variant."""
    for force in dict.fromkeys((min(family.forces), max(family.forces))):
        curves = complete(solved, (CurveName(family.variants[0], mode, force) for mode in family.modes))
        places = [(curve, solved.peak_of(name, curve).place) for name, curve in curves.items()]
        if places:
            draw = partial(kinematics.damper_kinematics, rig=solved.rig, curves=places)
            yield FamilyPicture(
                _file(family, "damper_motion", f"{force:g} N"), f"The damper at the peak, {force:g} N.", draw
            )


def contact_states(solved: SolvedStudy, family: Family) -> Iterator[FamilyPicture]:
    """Of the first variant."""
    variant = family.variants[0]
    for mode in family.modes:
        names = complete(solved, (CurveName(variant, mode, force) for force in family.forces))
        states = {name.force: solved.states(name) for name in names}
        if states:
            draw = partial(
                faces.contact_states, rig=solved.rig, contacts=solved.patches(variant), mode=mode, states=states
            )
            yield FamilyPicture(_file(family, "contact_states", mode), f"{mode}: over a period at the peak.", draw)


def loops(solved: SolvedStudy, family: Family) -> Iterator[FamilyPicture]:
    """Of all named contacts, at each force of the first variant."""
    for force in family.forces:
        for mode in family.modes:
            name = CurveName(family.variants[0], mode, force)
            try:
                drawn = [loop_at(solved, name, place.name) for place in solved.study.contacts]
            except UnknownResultError:
                continue
            draw = partial(force_loops.force_loops, title=f"{mode} at {force:g} N: force loops", loops=drawn)
            caption = (
                f"{mode}, {force:g} N. Left: tangential force over displacement; right: both forces over a period, the "
                "friction limit grey."
            )
            yield FamilyPicture(_file(family, "force_loops", f"{mode} {force:g} N"), caption, draw)


def mean_positions(solved: SolvedStudy, family: Family) -> Iterator[FamilyPicture]:
    """Of the first variant, where the mean position is among the harmonics."""
    for mode in family.modes:
        names = (CurveName(family.variants[0], mode, force) for force in family.forces)
        curves = {
            name.force: MeanPosition(
                curve.frequency, mean_lift(curve), mean_opening(curve), solved.peak_of(name, curve).place
            )
            for name, curve in complete(solved, names).items()
            if 0 in curve.orders
        }
        if curves:
            draw = partial(mean_position.mean_positions, title=mode, curves=curves)
            yield FamilyPicture(
                _file(family, "mean_position", mode), f"{mode}: against rest; dots: at the peaks.", draw
            )


def _file(family: Family, picture: str, of: str) -> str:
    return "_".join((family.name, picture, "".join(c if c.isalnum() or c in ".-" else "_" for c in of))).strip("_")


def pressure(solved: SolvedStudy, family: Family) -> Iterator[FamilyPicture]:
    """At rest, of each variant."""
    for variant in family.variants:
        try:
            rest, contacts = solved.rest(variant), solved.patches(variant)
        except UnknownResultError:
            continue
        if len(rest.normal_force) == len(contacts):  # a lumped damper has one contact a face
            draw = partial(faces.pressure, contacts=contacts, rest=rest)
            yield FamilyPicture(_file(family, "pressure", variant), f"Pressure at rest, {variant}.", draw)


PICTURES: Mapping[str, Pictures] = MappingProxyType(
    {
        "responses": responses,
        "against_test": against_test,
        "peaks_against_force": peaks_against_force,
        "damper_motion": damper_motion,
        "contact_states": contact_states,
        "force_loops": loops,
        "mean_position": mean_positions,
        "pressure": pressure,
    }
)
