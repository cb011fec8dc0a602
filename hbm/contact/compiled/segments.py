"""What one segment between two samples does to a slider, with derivatives: the scalars of `event_march.py`.

A segment is six numbers (u0, u1, du0, du1, p0, p1), as in `event_march._Segment`: positions of the spring's
end and their slopes a sample, compressions, at its start (0) and end (1). Derivatives come in the same
order. Names, branches and formulas are those of `event_march.py`.
"""

from typing import Any

from updamp.hbm.contact.compiled.keeping import inner

U0, U1, DU0, DU1, P0, P1, W0, W1 = range(8)
N_CORNER = 8

# Trial forces this close to the limit (relative) are at it.
_AT_LIMIT = 1e-9


@inner
def positive(p: float) -> float:
    return p if p > 0 else 0.0


@inner
def positive_slope(p: float) -> float:
    """Of `positive`: the mean of both sides at 0, as JAX has it."""
    return 1.0 if p > 0 else (0.5 if p == 0 else 0.0)


@inner
def turned(s: Any, sign: float) -> Any:
    """Seen from the other side where sign is -1."""
    return sign * s[0], sign * s[1], sign * s[2], sign * s[3], s[4], s[5]


@inner
def crosses(s: Any) -> bool:
    """Whether the contact opens or closes."""
    return (s[P0] > 0) != (s[P1] > 0)


@inner
def closing_and_opening(s: Any) -> Any:
    """Share of the segment after which the contact closes (0 where it does not) and opens (1)."""
    if not crosses(s):
        return 0.0, 1.0
    share = s[P0] / (s[P0] - s[P1])
    return (share, 1.0) if s[P1] > 0 else (0.0, share)


@inner
def crossing_slopes(s: Any) -> Any:
    """Derivatives of that share by p0 and p1, where there is one."""
    width = s[P0] - s[P1]
    return -s[P1] / (width * width), s[P0] / (width * width)


@inner
def end_of(s: Any, ratio: float) -> float:
    """Where the slider is pushed to if nothing turns or closes within the segment."""
    return s[U1] - ratio * positive(s[P1])


@inner
def _relative_slopes(s: Any, ratio: float) -> Any:
    """Slopes at both ends of the trial force's distance to its limit."""
    limits_slope = ratio * (positive(s[P1]) - positive(s[P0]))
    return s[DU0] - limits_slope, s[DU1] - limits_slope


@inner
def _highest(s: Any, ratio: float) -> float:
    if s[P0] <= 0 and s[P1] > 0:
        return s[U0] + s[P0] / (s[P0] - s[P1]) * (s[U1] - s[U0])
    slope0, slope1 = _relative_slopes(s, ratio)
    end = end_of(s, ratio)
    if not (slope0 > 0 and slope1 < 0):
        return end
    share = slope0 / (slope0 - slope1)
    blend = share * share * (3 - 2 * share)
    left = s[U0] - ratio * positive(s[P0]) + slope0 * share / 2
    right = end - slope1 * (1 - share) / 2
    return (1 - blend) * left + blend * right


@inner
def push(s: Any, ratio: float) -> float:
    """The position up to which a segment pushes the slider; where the contact closes in it, where the slider starts."""
    limit1 = ratio * positive(s[P1])
    return min(max(_highest(s, ratio), s[U1] - limit1), s[U1] + limit1)


@inner
def push_slopes(s: Any, ratio: float) -> Any:
    """Derivatives of `push`."""
    highest, limit1 = _highest(s, ratio), ratio * positive(s[P1])
    by_limit1 = ratio * positive_slope(s[P1])
    if highest < s[U1] - limit1:
        return 0.0, 1.0, 0.0, 0.0, 0.0, -by_limit1
    if highest > s[U1] + limit1:
        return 0.0, 1.0, 0.0, 0.0, 0.0, by_limit1
    if s[P0] <= 0 and s[P1] > 0:
        share, move, (by_p0, by_p1) = s[P0] / (s[P0] - s[P1]), s[U1] - s[U0], crossing_slopes(s)
        return 1 - share, share, 0.0, 0.0, move * by_p0, move * by_p1
    slope0, slope1 = _relative_slopes(s, ratio)
    if not (slope0 > 0 and slope1 < 0):
        return 0.0, 1.0, 0.0, 0.0, 0.0, -by_limit1
    return _top_slopes(s, ratio, slope0, slope1)


@inner
def _top_slopes(s: Any, ratio: float, slope0: float, slope1: float) -> Any:
    """Where the slope falls through zero."""
    width = slope0 - slope1
    share = slope0 / width
    blend = share * share * (3 - 2 * share)
    left = s[U0] - ratio * positive(s[P0]) + slope0 * share / 2
    right = end_of(s, ratio) - slope1 * (1 - share) / 2
    by_share = 6 * share * (1 - share) * (right - left) + (1 - blend) * slope0 / 2 + blend * slope1 / 2
    by_slope0 = (1 - blend) * share / 2 - by_share * slope1 / (width * width)
    by_slope1 = -blend * (1 - share) / 2 + by_share * slope0 / (width * width)
    by_limits = by_slope0 + by_slope1  # which both fall where the limit rises from start to end
    by_p0 = ratio * positive_slope(s[P0]) * (by_limits - (1 - blend))
    by_p1 = -ratio * positive_slope(s[P1]) * (by_limits + blend)
    return 1 - blend, blend, by_slope0, by_slope1, by_p0, by_p1


@inner
def beyond_limit(s: Any, ratio: float, slider: float) -> float:
    """By how much the force would pass the upper limit at the end of the segment, or where it opens, if it stuck."""
    _, opening = closing_and_opening(s)
    if opening < 1:
        return s[U0] + opening * (s[U1] - s[U0]) - slider
    return push(s, ratio) - slider


@inner
def has_corner(s: Any, ratio: float, slider: float, up: float, down: float) -> bool:
    """up, down: where the segment pushes to."""
    if crosses(s):
        return True
    reach = (1 - _AT_LIMIT) * ratio * s[P0]
    force = s[U0] - slider
    return (up > slider and force < reach) or (down < slider and -force < reach)
