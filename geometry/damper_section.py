"""Blocks of the wedge damper: a triangle with a small flat on top and vertical flats at the bottom corners."""

from updamp.geometry.extruded_blocks import Block, CrossSection
from updamp.rig.rig import MeshDivisions, Rig


def damper_section(rig: Rig, divisions: MeshDivisions) -> CrossSection:
    """Levels from the bottom up; between "face bottom" and "face top" lie the two contact faces."""
    damper, face_top, face_bottom = rig.damper, rig.face_top, rig.face_bottom
    levels = {"face bottom": face_bottom, "face top": face_top}
    between = [divisions.face]
    if damper.base_height > 0:
        levels = {"base": (face_bottom[0], face_bottom[1] - damper.base_height)} | levels
        between.insert(0, divisions.damper_base)
    if damper.apex_height > 0:
        levels["apex"] = (damper.apex_flat / 2, face_top[1] + damper.apex_height)
        between.append(divisions.damper_apex)
    names = list(levels)
    blocks = tuple(
        Block((f"left {low}", f"right {low}", f"right {high}", f"left {high}"), divisions.damper_across, up)
        for low, high, up in zip(names[:-1], names[1:], between, strict=True)
    )
    points = {f"left {name}": (-x, y) for name, (x, y) in levels.items()}
    points |= {f"right {name}": point for name, point in levels.items()}
    return CrossSection(
        name="damper",
        points=points,
        blocks=blocks,
        sides={
            "contact_left": (("left face bottom", "left face top"),),
            "contact_right": (("right face bottom", "right face top"),),
        },
        marks={"corner_left": f"left {names[0]}", "corner_right": f"right {names[0]}"},
        ends=("end_back", "end_front"),
    )
