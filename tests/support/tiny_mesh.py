"""A mesh preset for the virtual rig as coarse as it can be."""

TINY = {
    "width": 4, "face": 2, "platform_outer": 1, "platform_inner": 1, "platform_height": 2, "stem_thickness": 1,
    "stem_below_excitation": 2, "stem_below_platform": 1, "stem_above_platform": 4, "stem_top": 1,
    "damper_across": 2, "damper_apex": 1, "damper_base": 1, "contact_elements": 36,
}  # fmt: skip
# As it stands in a rig file.
TINY_PRESET = "\n[mesh.tiny]\n" + "".join(f"{name} = {value}\n" for name, value in TINY.items())
