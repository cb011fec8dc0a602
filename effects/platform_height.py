"""The height of the platforms above the roots, `platform.top`."""

from updamp.effects.wrong_dimension import wrong_dimension

# Platforms, damper and contacts are higher or lower on the blades, which are as long as they were.
EFFECT = wrong_dimension(
    "platform_height",
    "the platforms are higher or lower on the blades than the rig file says",
    0.1,
    "1 mm of 50 mm: where a root is held is not where the drawing measures from",
)
