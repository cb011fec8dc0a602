"""The damper's mass from its dimensions and its density."""

from updamp.rig.rig import Rig


def damper_mass(rig: Rig) -> float:
    """Of the base, of what lies between the faces, and of the apex above them [kg]"""
    damper, (wide, low), (narrow, high) = rig.damper, rig.face_bottom, rig.face_top
    base, faces = 2 * wide * damper.base_height, (wide + narrow) * (high - low)
    apex = (narrow + damper.apex_flat / 2) * damper.apex_height
    return rig.damper_material.density * rig.blade.width * (base + faces + apex)
