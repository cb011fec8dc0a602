"""The thickness of the blades, `blade.thickness`."""

from updamp.effects.wrong_dimension import wrong_dimension

# About the same mid-plane: frequencies of bending grow as the thickness does, those along the width hardly do, which
# tells it from another Young's modulus.
EFFECT = wrong_dimension(
    "blade_thickness",
    "the blades are thicker or thinner than the rig file says",
    0.1,
    "0.14 mm of 7 mm: ISO 2768-c allows 0.5 mm where nothing is stated",
)
