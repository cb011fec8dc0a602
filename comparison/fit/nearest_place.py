"""The places along a branch that measured points lie nearest to: compiled, since a fit asks for them by the thousand.

First on many short straight lines, then by finer and finer looks around; a gradient would go astray where contacts
begin to slip. All of the branch is tried, whichever part a sweep would be on: a sweep may leave a part before its fold,
when something disturbs it, and one that begins in a hysteresis may begin on either part.
"""

from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from updamp.hbm.contact.compiled.keeping import inner, kept

Floats = NDArray[np.float64]

# Where the place is looked for, in widths, and how often again at half the distance, on either side of the nearest one.
_AROUND, _LOOKS = np.linspace(-1, 1, 9), 8
_TINY = float(np.finfo(float).tiny)


class MovedCurve(NamedTuple):
    """A branch moved to first order, with cubics between its places.

    coefficients: (4, n - 1, 2 or 3, m) the highest power first: of the state (logarithm of the frequency, then real
        and imaginary part of each amplitude), of its change by the whole shift, and, where it has a curve, by a unit of
        the force or of the level that is held
    places: (n,); unit: (m,) what a unit of these does to what is observed where it has none
    least: amplitude below which there is none
    """

    coefficients: Floats
    places: Floats
    unit: Floats
    least: float


@kept
def nearest_places(curve: MovedCurve, ends: Any, followed: Any, seen: Any, of_drive: Any, weights: Any) -> Any:
    """(n,) places along the branch.

    ends: (k + 1,) places that are all but straight lines apart; followed: (k,) whether the branch was, from one to the
        next. Lines, not places: where frequencies are known far better than places are close, the place whose frequency
        happens to be the nearest may be on another part of the branch.
    seen: (n, m) logarithms of frequency and amplitudes, phases; of_drive: (n,) what the change by a unit of the force
        or level is taken times; weights: (m,) one over the deviations, 0 for what was not observed
    """
    n, m = seen.shape
    moved = np.empty(curve.coefficients.shape[2:])
    value, drive = np.empty((len(ends), m)), np.empty((len(ends), m))
    for i in range(len(ends)):
        _look(curve, ends[i], moved, value[i], drive[i])
    found, off, ahead = np.empty(n), np.empty(m), np.empty(m)
    line = 0
    for t in range(n):
        point, share_of_drive = seen[t], of_drive[t]
        place, width, line = _on_lines(ends, followed, value, drive, point, share_of_drive, weights, off, ahead, line)
        low, high = _around(line, ends, followed)
        middle, best = place, np.inf
        for share in _AROUND:
            tried = min(max(middle + width * share, low), high)
            distance = _distance_from(curve, tried, moved, off, ahead, point, share_of_drive, weights)
            if distance < best:
                place, best = tried, distance
        apart = width * (_AROUND[1] - _AROUND[0])
        for _ in range(_LOOKS):
            middle, apart = place, apart / 2
            for side in (-apart, apart):
                tried = min(max(middle + side, low), high)
                distance = _distance_from(curve, tried, moved, off, ahead, point, share_of_drive, weights)
                if distance < best:
                    place, best = tried, distance
        found[t] = place
    return found


@inner
def _around(line: int, ends: Any, followed: Any) -> tuple[float, float]:
    """Places that are looked at about a line: on it and two more on either side, where the branch was followed"""
    first, last = line, line
    for _ in range(2):
        first -= 1 if first > 0 and followed[first - 1] else 0
        last += 1 if last < len(followed) - 1 and followed[last + 1] else 0
    return ends[first], ends[last + 1]


@inner
def _distance_from(
    curve: MovedCurve, place: float, moved: Any, off: Any, ahead: Any, seen: Any, of_drive: float, weights: Any
) -> float:
    """Squared distance from a place"""
    _look(curve, place, moved, off, ahead)
    return _distance(off, ahead, seen, of_drive, weights)


@inner
def _look(curve: MovedCurve, place: float, moved: Any, value: Any, drive: Any) -> None:
    """Writes (m,) what is observed at a place, and what a unit of the force or level does to it; moved: for the
    states"""
    c, places = curve.coefficients, curve.places
    s = min(max(int(np.searchsorted(places, place, side="right")) - 1, 0), len(places) - 2)
    x = place - places[s]
    for q in range(moved.shape[0]):
        for j in range(moved.shape[1]):
            moved[q, j] = ((c[0, s, q, j] * x + c[1, s, q, j]) * x + c[2, s, q, j]) * x + c[3, s, q, j]
    has_drive = len(moved) > 2
    value[0], drive[0] = moved[0, 0] + moved[1, 0], moved[2, 0] if has_drive else curve.unit[0]
    for j in range(1, len(value), 2):
        real, imaginary = moved[0, j], moved[0, j + 1]
        square = real * real + imaginary * imaginary
        if square < curve.least * curve.least:
            real, imaginary, square = curve.least, 0.0, curve.least * curve.least
        of_log, of_phase = _relative(moved[1, j], moved[1, j + 1], real, imaginary, square)
        value[j], value[j + 1] = np.log(square) / 2 + of_log, np.arctan2(imaginary, real) + of_phase
        if has_drive:
            drive[j], drive[j + 1] = _relative(moved[2, j], moved[2, j + 1], real, imaginary, square)
        else:
            drive[j], drive[j + 1] = curve.unit[j], curve.unit[j + 1]


@inner
def _relative(a: float, b: float, real: float, imaginary: float, square: float) -> tuple[float, float]:
    """Real and imaginary part of (a + i b) / (real + i imaginary)"""
    return (a * real + b * imaginary) / square, (b * real - a * imaginary) / square


@inner
def _on_lines(
    ends: Any,
    followed: Any,
    value: Any,
    drive: Any,
    seen: Any,
    of_drive: float,
    weights: Any,
    off: Any,
    ahead: Any,
    guess: int,
) -> tuple[float, float, int]:
    """The nearest place on the lines from each of `ends` to the next, how long its line is along the branch, and which
    that is. guess: a line that may be near: only those whose frequencies are no farther off than it need a look."""
    best, share = _on_line(guess, value, drive, seen, of_drive, weights, off, ahead)
    found, bound = guess, best if followed[guess] else np.inf
    best = np.inf
    last = _frequency_off(0, value, drive, seen, of_drive, weights)
    for i in range(len(followed)):
        first, last = last, _frequency_off(i + 1, value, drive, seen, of_drive, weights)
        least = 0.0 if first * last <= 0 else min(first * first, last * last)
        if not followed[i] or least > min(best, bound):
            continue
        distance, along = _on_line(i, value, drive, seen, of_drive, weights, off, ahead)
        if distance < best:
            best, found, share = distance, i, along
    width = ends[found + 1] - ends[found]
    return ends[found] + share * width, width, found


@inner
def _on_line(
    i: int, value: Any, drive: Any, seen: Any, of_drive: float, weights: Any, off: Any, ahead: Any
) -> tuple[float, float]:
    """Squared distance from a line, and the share of it where it is nearest"""
    _write_off(value[i], drive[i], seen, of_drive, weights, off)
    _write_off(value[i + 1], drive[i + 1], seen, of_drive, weights, ahead)
    square = product = length = 0.0
    for j in range(len(off)):
        turn = _turn(j, weights)
        change = _within_turn(ahead[j] - off[j], turn)
        start = _within_turn(off[j] + change / 2, turn) - change / 2
        square += start * start
        product += start * change
        length += change * change
    share = min(max(-product / max(length, _TINY), 0.0), 1.0)
    return square + share * (2 * product + share * length), share


@inner
def _distance(value: Any, drive: Any, seen: Any, of_drive: float, weights: Any) -> float:
    """Squared"""
    total = 0.0
    for j in range(len(seen)):
        if weights[j] != 0:
            off = _within_turn((seen[j] - value[j] - of_drive * drive[j]) * weights[j], _turn(j, weights))
            total += off * off
    return total


@inner
def _write_off(value: Any, drive: Any, seen: Any, of_drive: float, weights: Any, off: Any) -> None:
    """How far a point of the run is off, by `weights`; 0 what was not observed."""
    for j in range(len(seen)):
        off[j] = (seen[j] - value[j] - of_drive * drive[j]) * weights[j] if weights[j] != 0 else 0.0


@inner
def _frequency_off(i: int, value: Any, drive: Any, seen: Any, of_drive: float, weights: Any) -> float:
    """At one of many places: rows (m,) of `value` and `drive` would take longer to make than this"""
    return (seen[0] - value[i, 0] - of_drive * drive[i, 0]) * weights[0] if weights[0] != 0 else 0.0


@inner
def _turn(j: int, weights: Any) -> float:
    """What a turn is, 0 but for phases."""
    return 2 * np.pi * weights[j] if j > 0 and j % 2 == 0 else 0.0


@inner
def _within_turn(off: float, turn: float) -> float:
    """Phases to the nearest turn"""
    return off if turn == 0 or abs(off) < turn / 2 else off - turn * np.rint(off / turn)
