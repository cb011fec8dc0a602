"""Every number that steers how a curve is put together from segments; those of single steps are in
hbm/continuation/corrector.py, those of ways on where a step fails in hbm/continuation/recovery.
"""

from dataclasses import dataclass, field

from updamp.hbm.continuation.completeness import CompletenessLimits


@dataclass(frozen=True)
class CurveOptions:
    """from_one_end: so many points are traced from one end alone, as many as most curves have; then from both in turn.
        A branch that goes on as it should costs no more that way; one that was lost at a kink is met from the other end
    connecting: where segments from both ends cover the window, so many points more are spent, from where they turn
        back, on what connects them, and as many on each further start. It may be long: a hysteresis with many contacts
        that change their states on the way between its folds
    most_starts: of further segments, where those from both ends do not meet
    start_lengths: beyond an open end, in units of arc, at which starts are looked for; start_shares: and at fixed
        frequencies so far ahead of it, as shares of the window
    same_start: starts closer than this are the same one [arc]: below the shortest step on the far side of a kink
    points_at_extreme: at most so many are solved at the top of the peak and at a fold where a sweep jumps, each where a
        spline through those before it expects it. Beside a sharp fold it takes ten; elsewhere a point is there after
        one or two
    at_extreme: how far the extreme may lie from where the spline expects it [arc]: half an ordinary step
    there: how close to it a point is at it, as a share of the length of the points about it: what is read is off by the
        square of it beside a smooth extreme; on a flank that ends in a kink 1e-3 were 0.3 % of the height
    limits: of the gaps in a complete curve
    """

    from_one_end: int = 200
    connecting: int = 150
    most_starts: int = 12
    start_lengths: tuple[float, ...] = (0.03, 0.1, 0.2, 0.4)
    start_shares: tuple[float, ...] = (0.0025, 0.005, 0.01, 0.02, 0.04, 0.08, 0.16, 0.32)
    same_start: float = 1e-4
    points_at_extreme: int = 20
    at_extreme: float = 0.1
    there: float = 1e-4
    limits: CompletenessLimits = field(default_factory=CompletenessLimits)
