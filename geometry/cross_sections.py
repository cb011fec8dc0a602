"""Blocks of the cross sections: the right-hand blade, a stem with a platform on its inner side; the wedge damper."""

from updamp.geometry.extruded_blocks import Block, CrossSection
from updamp.rig.mesh_divisions import MeshDivisions
from updamp.rig.rig import Rig

Point = tuple[float, float]

JUNCTION, TOP, RESPONSE = 2, 3, 4  # levels of the blade's stem; 0 is the root, 1 the excitation


def blade_section(rig: Rig, divisions: MeshDivisions) -> CrossSection:
    """The platform is split above the ends of the damper's face by vertical cuts.

    Vertical, because the platform's sharpest corner, between underside and stem, measures 90 deg minus the angle of
    the underside wherever the cuts are; upright cuts are nowhere sharper and keep the top rectangular.
    """
    stem_points, stem = _stem(rig, divisions)
    platform_points, platform, contact = _platform(rig, divisions)
    return CrossSection(
        name="blade",
        points=stem_points | platform_points,
        blocks=stem + platform,
        sides={"root": (("inner 0", "outer 0"),), "contact": (contact,)},
        marks={"excitation": "outer 1", "tip": f"outer {RESPONSE}", "platform": "top 0"},
    )


def _stem(rig: Rig, divisions: MeshDivisions) -> tuple[dict[str, Point], tuple[Block, ...]]:
    middle, half = rig.blade.axis_offset, rig.blade.thickness / 2
    levels = (0.0, rig.excitation.height, rig.junction_height, rig.platform.top, rig.response_height, rig.blade.height)
    between = (
        divisions.stem_below_excitation,
        divisions.stem_below_platform,
        divisions.platform_height,
        divisions.stem_above_platform,
        divisions.stem_top,
    )
    points = {f"inner {i}": (middle - half, y) for i, y in enumerate(levels)}
    points |= {f"outer {i}": (middle + half, y) for i, y in enumerate(levels)}
    blocks = tuple(
        Block((f"inner {i}", f"outer {i}", f"outer {i + 1}", f"inner {i + 1}"), divisions.stem_thickness, up)
        for i, up in enumerate(between)
    )
    return points, blocks


def _platform(rig: Rig, divisions: MeshDivisions) -> tuple[dict[str, Point], tuple[Block, ...], tuple[str, str]]:
    """Points, blocks from the inner edge outwards, and the edge that the damper touches."""
    start, end = rig.damper.face_start, rig.damper.face_start + rig.damper.face_length
    splits, between = [start, end], [divisions.face, divisions.platform_outer]
    if start > 0:
        splits, between = [0.0, *splits], [divisions.platform_inner, *between]
    below = [rig.underside_point(s) for s in splits]
    points = {f"under {i}": point for i, point in enumerate(below)}
    points |= {f"top {i}": (x, rig.platform.top) for i, (x, _) in enumerate(below)}
    under = [*(f"under {i}" for i in range(len(splits))), f"inner {JUNCTION}"]
    top = [*(f"top {i}" for i in range(len(splits))), f"inner {TOP}"]
    blocks = tuple(
        Block((under[i], under[i + 1], top[i + 1], top[i]), across, divisions.platform_height)
        for i, across in enumerate(between)
    )
    return points, blocks, (under[len(splits) - 2], under[len(splits) - 1])


def damper_section(rig: Rig, divisions: MeshDivisions) -> CrossSection:
    """A triangle with a small flat on top and vertical flats at the bottom corners.

    Levels from the bottom up; between "face bottom" and "face top" lie the two contact faces."""
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
