"""Can the rig be built? Each problem is one sentence: the key, its value, what would be allowed."""

from collections.abc import Iterator
from itertools import islice
from math import radians, tan

from updamp.rig.dimensions import DIMENSIONS
from updamp.rig.pressure import FePressure
from updamp.rig.rig import Rig

FLATTEST = tan(radians(15))  # underside that a rig file may state


def buildable(rig: Rig) -> list[str]:
    """Problems of the geometry, empty if it can be built; without the platform's arm nothing else can be judged."""
    problems = list(islice(_platform(rig), 1))
    problems = problems or [*_heights(rig), *_faces(rig), *_apex(rig), *_base(rig), *_rounding(rig)]
    return [*problems, *_dimensions_as_effects(rig)]


def _mm(length: float) -> str:
    return f"{length * 1e3:.6g} mm"


def _stem_inside(rig: Rig) -> float:
    return rig.blade.axis_offset - rig.blade.thickness / 2


def _platform(rig: Rig) -> Iterator[str]:
    """The first that is found: the others follow from it."""
    blade, platform = rig.blade, rig.platform
    if _stem_inside(rig) <= platform.gap / 2:
        yield (
            f"blade.axis_offset = {_mm(blade.axis_offset)}: the stem must stand outside the gap, which needs more "
            f"than thickness / 2 + gap / 2 = {_mm(blade.thickness / 2 + platform.gap / 2)}"
        )
    if platform.top >= blade.height:
        yield f"platform.top = {_mm(platform.top)}: must be below the blade's tip, {_mm(blade.height)}"
    if platform.edge_thickness >= platform.top:
        yield (
            f"platform.edge_thickness = {_mm(platform.edge_thickness)}: must be less than the height of the "
            f"platform's top, {_mm(platform.top)}"
        )
    if rig.junction_height <= 0:
        steepest = (platform.top - platform.edge_thickness - rig.excitation.height) / (
            _stem_inside(rig) - platform.gap / 2
        )
        flatter = f", or an underside_angle whose tangent is below {steepest:.4g}" if steepest > FLATTEST else ""
        yield (
            f"platform.top = {_mm(platform.top)}: the underside would reach below the root (to "
            f"{_mm(rig.junction_height)}); allowed is more than {_mm(_lowest_top(rig))}, so that the excitation has "
            f"room below it{flatter}"
        )


def _lowest_top(rig: Rig) -> float:
    """Of the platform, with the excitation just below the junction of its underside and the stem. [m]"""
    return rig.platform.top - rig.junction_height + rig.excitation.height


def _heights(rig: Rig) -> Iterator[str]:
    junction = rig.junction_height
    if rig.excitation.height >= junction:
        yield (
            f"excitation.height = {_mm(rig.excitation.height)}: must be below the junction of the platform's "
            f"underside and the stem, {_mm(junction)}; or raise platform.top above {_mm(_lowest_top(rig))}"
        )
    if rig.response_height <= rig.platform.top:
        yield (
            f"response.below_top = {_mm(rig.response.below_top)}: must be above the platform, so less than "
            f"{_mm(rig.blade.height - rig.platform.top)} below the blade's top"
        )


def _faces(rig: Rig) -> Iterator[str]:
    start, length, underside = rig.damper.face_start, rig.damper.face_length, rig.underside_length
    if start >= underside:
        yield (
            f"damper.face_start = {_mm(start)}: the faces do not touch; the platform's underside is only "
            f"{_mm(underside)} long"
        )
    elif start + length >= underside:
        yield (
            f"damper.face_length = {_mm(length)}: the damper would be wider ({_mm(2 * rig.face_bottom[0])}) than the "
            f"space between the blades ({_mm(2 * _stem_inside(rig))}); allowed is less than {_mm(underside - start)}"
        )


def _apex(rig: Rig) -> Iterator[str]:
    """Above the faces the damper must be flatter than the underside, or it would enter the platforms."""
    damper, (half_width, _) = rig.damper, rig.face_top
    if damper.apex_height == 0:
        return
    if damper.apex_flat >= 2 * half_width:
        yield (
            f"damper.apex_flat = {_mm(damper.apex_flat)}: the apex would enter the platforms; allowed is less than "
            f"the width at the upper end of the faces, {_mm(2 * half_width)}"
        )
        return
    highest = (half_width - damper.apex_flat / 2) * tan(rig.platform.underside_angle)
    if damper.apex_height >= highest:
        yield (
            f"damper.apex_height = {_mm(damper.apex_height)}: the apex would enter the platforms; allowed is less "
            f"than {_mm(highest)}, or 0 for none"
        )


def _base(rig: Rig) -> Iterator[str]:
    lower_end = rig.face_bottom[1]
    if lower_end - rig.damper.base_height <= 0 < lower_end:
        yield (
            f"damper.base_height = {_mm(rig.damper.base_height)}: the damper would reach below the root; allowed is "
            f"less than {_mm(lower_end)}"
        )


def _rounding(rig: Rig) -> Iterator[str]:
    pressure = rig.contact.pressure
    if not isinstance(pressure, FePressure):
        return
    profile = pressure.profile
    if profile.edge_rounding > rig.damper.face_length / 2:
        yield (
            f"contact.pressure.profile.edge_rounding = {_mm(profile.edge_rounding)}: at most half the face, "
            f"{_mm(rig.damper.face_length / 2)}"
        )


def _dimensions_as_effects(rig: Rig) -> Iterator[str]:
    """A dimension that a diagnosis found to be other than stated: the whole rig follows from where it is stated."""
    for effect in rig.effects:
        change = effect.values.get("change", 0.0)
        if effect.name in DIMENSIONS and change:
            dimension = DIMENSIONS[effect.name]
            yield (
                f"effects: {effect.name} with change = {change:.4g}: a dimension is stated where it stands, not as an "
                f"effect: take this one out and write {dimension.text(rig, change)} in place of {dimension.text(rig)}"
            )
