"""Colours that the colour-blind can tell apart: Okabe and Ito (2008), "Color Universal Design"."""

BLUE, VERMILLION, GREEN, PURPLE = "#0072B2", "#D55E00", "#009E73", "#CC79A7"
ORANGE, SKY, BLACK, GREY = "#E69F00", "#56B4E9", "#1a1a1a", "#8a8f98"

LEVELS = (BLUE, VERMILLION, GREEN, PURPLE, ORANGE, SKY, BLACK)  # in turn, where force levels are drawn together

# Dark to light, evenly: viridis (van der Walt and Smith 2015) short of its yellow, for more levels than that.
MANY_LEVELS = ("#440154", "#414487", "#2a788e", "#22a884", "#7ad151", "#d8b500")

MEASURED, BEFORE, AFTER, BAND = BLACK, VERMILLION, BLUE, "rgba(138,143,152,0.30)"
FOR_SCRIPTS = {
    "levels": LEVELS,
    "many": MANY_LEVELS,
    "measured": MEASURED,
    "before": BEFORE,
    "after": AFTER,
    "band": BAND,
}

# From 1 on, what scatter does not explain; evenly spaced in the logarithm from 1/2 to 2, and from there to
# the largest.
RESIDUAL_SCALE = (
    (0, "#f4f5f7"),
    (1 / 6, "#e3e6ea"),
    (1 / 3, "#f6d9a8"),
    (0.5, "#E69F00"),
    (0.75, "#D55E00"),
    (1, "#6b1d00"),
)
# White in the middle: cosines, signatures.
TWO_SIDED_SCALE = ((0, VERMILLION), (0.5, "#ffffff"), (1, BLUE))
