"""The angle of the platforms' undersides and the damper's faces, `platform.underside_angle`."""

from updamp.effects.wrong_dimension import wrong_dimension

# Relative too: of faces at 20 degrees a change of 0.02 is 0.4 degrees.
EFFECT = wrong_dimension(
    "face_angle",
    "the faces of damper and platforms are steeper or flatter than the rig file says",
    0.1,
    "0.4 degrees of 20: ISO 2768-c allows 1 degree on a side of 10 to 50 mm where nothing is stated",
)
