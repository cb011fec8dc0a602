"""The length of the damper's faces, `damper.face_length`."""

from updamp.effects.wrong_dimension import wrong_dimension

# Face, platform and contact elements over them are longer or shorter: the preload stays, and is spread over another
# area, which has as much more or less contact stiffness.
EFFECT = wrong_dimension(
    "face_length",
    "the damper's faces are longer or shorter than the rig file says",
    0.2,
    "0.1 mm of 5 mm: chamfers and worn edges, where the faces end but do not bear",
)
