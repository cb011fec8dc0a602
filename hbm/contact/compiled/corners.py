"""What a segment's path holds beyond its chord, as integral and first moment, with derivatives by hand.

Formulas are those of `event_march._between_samples` and `_between_contacts`.
"""

from typing import Any

from updamp.hbm.contact.compiled.keeping import inner
from updamp.hbm.contact.compiled.segments import (
    DU1,
    P0,
    P1,
    U0,
    U1,
    W0,
    W1,
    beyond_limit,
    closing_and_opening,
    crosses,
    crossing_slopes,
    positive,
    positive_slope,
    push_slopes,
    turned,
)


@inner
def _triangle(before: float, over: float, end: float) -> Any:
    """Integral and moment between path and chord, where the limit is passed: see `event_march._corner`."""
    if not over > 0:
        return 0.0, 0.0
    share = -before / (over - before)
    return end * over * share / 2, end * end * over * share * (1 + share) / 6


@inner
def _triangle_slopes(before: float, over: float, end: float) -> Any:
    """Derivatives of the integral by before, over and end, then those of the moment; over > 0."""
    width = over - before
    share = -before / width
    by_before, by_over = -over / (width * width), before / (width * width)
    moment, by_share = share * (1 + share) / 6, (1 + 2 * share) / 6
    return (
        (end * over * by_before / 2, end * (share + over * by_over) / 2, over * share / 2),
        (
            end * end * over * by_share * by_before,
            end * end * (moment + over * by_share * by_over),
            2 * end * over * moment,
        ),
    )


@inner
def corner(s: Any, ratio: float, w0: float, w1: float) -> Any:
    """Integral and moment of a tangential path, over kt; w0, w1: where the slider stands at the start and the end."""
    closing, opening = closing_and_opening(s)
    limit0, force0, force1 = ratio * positive(s[P0]), s[U0] - w0, s[U1] - w1
    up = _triangle(force0 - limit0, beyond_limit(s, ratio, w0), opening)
    down = _triangle(-force0 - limit0, beyond_limit(turned(s, -1.0), ratio, -w0), opening)
    integral = up[0] - down[0] - (1 - opening) * force0 / 2 - closing * force1 / 2
    moment = up[1] - down[1] - (1 - opening * opening) * force0 / 6 - closing * (1 + closing) * force1 / 6
    return integral, moment


@inner
def corner_slopes(s: Any, ratio: float, w0: float, w1: float, by: Any) -> None:
    """Writes derivatives of integral and moment into by, (2, N_CORNER): by the segment's numbers, by w0 and by w1."""
    by[:] = 0.0
    closing, opening = closing_and_opening(s)
    force0, force1 = s[U0] - w0, s[U1] - w1
    by_crossing = _add_slips(s, ratio, w0, opening, by)
    before = (1 - opening) / 2, (1 - opening * opening) / 6
    after = closing / 2, closing * (1 + closing) / 6
    opens = force0 / 2, opening * force0 / 3
    closes = -force1 / 2, -(1 + 2 * closing) * force1 / 6
    for q in range(2):
        by[q, U0] -= before[q]
        by[q, W0] += before[q]
        by[q, U1] -= after[q]
        by[q, W1] += after[q]
    if crosses(s):
        by_p0, by_p1 = crossing_slopes(s)
        for q in range(2):
            by_share = closes[q] if s[P1] > 0 else opens[q] + by_crossing[q]
            by[q, P0] += by_share * by_p0
            by[q, P1] += by_share * by_p1


@inner
def _add_slips(s: Any, ratio: float, w0: float, opening: float, by: Any) -> Any:
    """What passing either limit adds; returns the derivatives by the share after which the contact opens."""
    limit0, by_limit0 = ratio * positive(s[P0]), ratio * positive_slope(s[P0])
    integral_by_opening, moment_by_opening = 0.0, 0.0
    for sign in (1.0, -1.0):
        seen = turned(s, sign)
        over = beyond_limit(seen, ratio, sign * w0)
        if not over > 0:
            continue
        slopes = _triangle_slopes(sign * (s[U0] - w0) - limit0, over, opening)
        for q in range(2):
            by_before, by_over, _ = slopes[q]
            by[q, U0] += by_before
            by[q, P0] -= sign * by_before * by_limit0
            by[q, W0] -= by_before + by_over
            if opening < 1:
                by[q, U0] += by_over * (1 - opening)
                by[q, U1] += by_over * opening
            else:
                pushes = push_slopes(seen, ratio)
                for k in range(DU1 + 1):
                    by[q, k] += by_over * pushes[k]
                for k in range(P0, P1 + 1):
                    by[q, k] += sign * by_over * pushes[k]
        integral_by_opening += sign * slopes[0][2] + slopes[0][1] * (s[U1] - s[U0])
        moment_by_opening += sign * slopes[1][2] + slopes[1][1] * (s[U1] - s[U0])
    return integral_by_opening, moment_by_opening


@inner
def contact_corner(p0: float, p1: float) -> Any:
    """Integral and moment of the normal path, over kn, where the contact opens or closes."""
    share = p0 / (p0 - p1)
    if p1 > 0:
        return -share * p1 / 2, -share * (1 + share) * p1 / 6
    return -(1 - share) * p0 / 2, -(1 - share * share) * p0 / 6


@inner
def contact_corner_slopes(p0: float, p1: float) -> Any:
    """Derivatives of the integral by p0 and p1, and those of the moment."""
    width = p0 - p1
    share, by_p0, by_p1 = p0 / width, -p1 / (width * width), p0 / (width * width)
    if p1 > 0:
        integral, moment = -p1 / 2, -(1 + 2 * share) * p1 / 6
        return (integral * by_p0, integral * by_p1 - share / 2), (
            moment * by_p0, moment * by_p1 - share * (1 + share) / 6,
        )  # fmt: skip
    integral, moment = p0 / 2, share * p0 / 3
    return (integral * by_p0 - (1 - share) / 2, integral * by_p1), (
        moment * by_p0 - (1 - share * share) / 6, moment * by_p1,
    )  # fmt: skip
