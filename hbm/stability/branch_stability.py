"""Which points of a curve are stable, unstable, or not known to be either.

Not every point is computed. Where nothing slips or separates the response is the stuck structure's. The other points
fall into parts, without gap or turning point inside. Between two turning points an odd number of real exponents grows:
where the determinant at a point in the middle says so too, the whole part is unstable; but for the turning point at its
end, which may lie beyond the fold and is a part of its own. Of the other parts the middle and the ends are computed,
and points halfway between computed ones, the longest pieces first and those with ends that differ before others, until
the curve's share of points is used up: a number and no time, or what is known would depend on the machine. The rest is
taken to be as the two computed points around it. So what is assumed is that stability does not change twice between two
computed points that agree, and that no branch crosses between two turning points. Of a small system all points of these
parts are computed: a Duffing oscillator's stability may change from one to the next.
"""

import time
from collections.abc import Callable, Iterator
from dataclasses import dataclass
from enum import IntEnum
from itertools import pairwise

import numpy as np
from numpy.typing import NDArray

from updamp.hbm.continuation.response_curve import ResponseCurve
from updamp.hbm.continuation.sweeps import turning_points
from updamp.hbm.problem.system import NonlinearSystem
from updamp.hbm.stability.stability import stability

Floats = NDArray[np.float64]
Integers = NDArray[np.int64]

SHARE = 6  # at most one of so many of the curve's points is computed,
LEAST = 8  # but so many in any case, and all of a system
WHOLE = 100  # with so many modes times coefficients at most, where a point takes 5 to 20 ms
NOT_COMPUTED = "not computed: the curve's share of points was used up elsewhere"
SINGULAR = "a matrix has no inverse, as where nothing but sliding contacts holds the mean position"
DIFFERENT = "between two points that differ, with none computed between them"


class State(IntEnum):
    """Of one point."""

    UNKNOWN = 0
    STABLE = 1
    UNSTABLE = 2


@dataclass(frozen=True, eq=False)
class BranchStability:
    """Of the points of one curve, in their order.

    state: (n,) a `State`; computed: (n,) whether at this very point
    growth: (n,) largest real part of the exponents [1/s]; not a number where it was not computed, and where all decay
    faster than exponents are looked for (strip.py)
    reasons: why points are unknown; why: (n,) which of these it is, -1 for points that are known
    seconds: wall time spent
    """

    mode: str
    force: float
    state: Integers
    computed: NDArray[np.bool_]
    growth: Floats
    reasons: tuple[str, ...]
    why: Integers
    seconds: float

    def share(self, state: State) -> float:
        """Of the points, 0 to 1"""
        return float(np.mean(self.state == state)) if len(self.state) else 0.0

    def ranges(self, frequency: Floats, state: State) -> Floats:
        """(n, 2) lowest and highest frequency [Hz] of each run of points in this state, along the branch."""
        is_it = np.concatenate([[False], self.state == state, [False]])
        starts, ends = np.flatnonzero(is_it[1:] & ~is_it[:-1]), np.flatnonzero(is_it[:-1] & ~is_it[1:])
        runs = [frequency[start:end] for start, end in zip(starts, ends, strict=True)]
        return np.array([[run.min(), run.max()] for run in runs]).reshape(-1, 2)


@dataclass(frozen=True)
class Judgement:
    """state; growth [1/s], not a number where none was computed; reason: why unknown, "" otherwise"""

    state: State
    growth: float
    reason: str = ""


@dataclass(frozen=True)
class Part:
    """Consecutive points from start to last (included) that may slip or separate, without turning point or gap.

    against: whether it lies between turning points; None where that is not known: beyond a gap, and of the turning
        point at which a branch turns forward again, on whichever side of the fold it lies
    """

    start: int
    last: int
    against: bool | None


def between_turning_points(frequency: Floats) -> NDArray[np.bool_]:
    """(n,) True on the parts of a branch that run against its beginning: unstable, whatever the exponents say.

    A branch is entered on a part that a sweep can follow, as in hbm/continuation/sweeps.py. Points at which it turns
    count as past.
    """
    parity = np.zeros(len(frequency), dtype=np.int64)
    for place in turning_points(frequency):
        parity[place + 1 :] += 1
    against: NDArray[np.bool_] = parity % 2 == 1
    return against


def parts_of(curve: ResponseCurve) -> tuple[Part, ...]:
    """Without turning point or gap inside; `Part.against` says where a turning point is a part of its own."""
    against, turns = between_turning_points(curve.frequency), set(turning_points(curve.frequency))
    forward = {i for i in turns if against[i]}
    known = int(np.flatnonzero(curve.after_gap)[0]) if curve.after_gap.any() else len(curve)
    breaks = {i + 1 for i in turns} | forward | set(np.flatnonzero(curve.after_gap))
    found: list[list[int]] = []
    for i in np.flatnonzero(curve.active > 0):
        if found and found[-1][-1] == i - 1 and i not in breaks:
            found[-1].append(int(i))
        else:
            found.append([int(i)])
    runs = ((run, run[0] < known and run[0] not in forward) for run in found)
    return tuple(Part(run[0], run[-1], bool(against[run[0]]) if tells else None) for run, tells in runs)


def point_stability(system: NonlinearSystem, curve: ResponseCurve, place: int, against: bool | None) -> Judgement:
    """Whatever cannot be computed is unknown, with the reason."""
    try:
        with np.errstate(all="ignore"):
            found = stability(system, curve.displacement[place], 2 * np.pi * curve.frequency[place], against=against)
    except np.linalg.LinAlgError as error:
        return Judgement(State.UNKNOWN, np.nan, f"{SINGULAR} ({error})")
    except Exception as error:  # of a law, a factorisation, memory: no branch is lost by one of its points
        return Judgement(State.UNKNOWN, np.nan, f"{type(error).__name__}: {error}")
    growth = found.decisive.real
    if not found.trusted or found.stable is None:
        return Judgement(State.UNKNOWN, growth, found.reason)
    return Judgement(State.STABLE if found.stable else State.UNSTABLE, growth)


def branch_stability(
    system: NonlinearSystem,
    curve: ResponseCurve,
    point: str,
    report: Callable[[float], None] = lambda _: None,
) -> BranchStability:
    """Of all points of a curve traced on `system`.

    point: where the peak is taken, which is computed first; report: takes the share done, 0 to 1
    raises: ValueError where the curve is of other harmonics or contacts than the system; whatever `report` does
    """
    shape = (system.free.n_relative, system.harmonics.n_coefficients)
    if curve.orders != system.harmonics.orders or curve.displacement.shape[1:] != shape:
        raise ValueError(
            f"the curve has harmonics {curve.orders} and displacements {curve.displacement.shape[1:]}, the system "
            f"{system.harmonics.orders} and {shape}: give the system that it was traced on"
        )
    parts, most, began = parts_of(curve), most_computed(system, curve), time.perf_counter()
    known: dict[int, Judgement] = {}
    stuck = np.flatnonzero(curve.active == 0)
    if len(stuck):
        first = point_stability(system, curve, int(stuck[0]), None)
        known |= {int(i): first for i in stuck}
    peak = int(np.abs(curve.receptance(point)).argmax()) if len(curve) else None
    computed = {int(i) for i in stuck}
    for done, (part, place) in enumerate(_next_places(parts, known, peak)):
        if done >= most:
            break
        report(done / most)
        known[place] = point_stability(system, curve, place, part.against)
        computed.add(place)
    judged = [_judged(i, parts, known) for i in range(len(curve))]
    return _collected(curve, judged, computed, time.perf_counter() - began)


def most_computed(system: NonlinearSystem, curve: ResponseCurve) -> int:
    """Points at most, without those at which nothing slips or separates."""
    small = len(system.free.omega_squared) * system.harmonics.n_coefficients <= WHOLE
    return len(curve) if small else max(LEAST, len(curve) // SHARE)


def _next_places(parts: tuple[Part, ...], known: dict[int, Judgement], peak: int | None) -> Iterator[tuple[Part, int]]:
    """The peak, then always the point from which most is expected, with what is known by then."""
    yield from ((part, peak) for part in parts if peak is not None and part.start <= peak <= part.last)
    while True:
        wanted = [(*entry, part) for part in parts for entry in _worth(part, known)]
        if not wanted:
            return
        *_, place, part = max(wanted, key=lambda entry: entry[:3])
        yield part, place


def _worth(part: Part, known: dict[int, Judgement]) -> Iterator[tuple[bool, int, int]]:
    """(untold, points, place): so many points are not known without it; those that two equal neighbours tell come
    after all others."""
    inside = _inside(part, known)
    if not inside:
        yield True, part.last - part.start + 1, (part.start + part.last) // 2
        return
    if _unstable_throughout(part, known):
        return
    for end, nearest in ((part.start, inside[0]), (part.last, inside[-1])):
        if end != nearest:
            yield True, abs(end - nearest), end
    for a, b in pairwise(inside):
        if b - a > 1:
            yield known[a].state != known[b].state, b - a, (a + b) // 2


def _inside(part: Part, known: dict[int, Judgement]) -> list[int]:
    return sorted(place for place in known if part.start <= place <= part.last)


def _unstable_throughout(part: Part, known: dict[int, Judgement]) -> bool:
    """Between turning points, confirmed by what was computed."""
    inside = _inside(part, known)
    return part.against is True and bool(inside) and all(known[i].state is State.UNSTABLE for i in inside)


def _judged(place: int, parts: tuple[Part, ...], known: dict[int, Judgement]) -> Judgement:
    """A point that was not computed is as the computed ones around it on its part, if these agree."""
    if place in known:
        return known[place]
    part = next(part for part in parts if part.start <= place <= part.last)
    inside = _inside(part, known)
    if _unstable_throughout(part, known):
        return Judgement(State.UNSTABLE, np.nan)
    before, after = [i for i in inside if i < place][-1:], [i for i in inside if i > place][:1]
    if not before or not after:
        return Judgement(State.UNKNOWN, np.nan, NOT_COMPUTED)
    one, other = known[before[0]], known[after[0]]
    if one.state != other.state:
        return Judgement(State.UNKNOWN, np.nan, DIFFERENT)
    return Judgement(one.state, np.nan, one.reason)


def _collected(curve: ResponseCurve, judged: list[Judgement], computed: set[int], seconds: float) -> BranchStability:
    reasons = tuple(dict.fromkeys(one.reason for one in judged if one.reason))
    return BranchStability(
        mode=curve.mode,
        force=curve.force,
        state=np.array([int(one.state) for one in judged], dtype=np.int64),
        computed=np.array([i in computed for i in range(len(judged))], dtype=bool),
        growth=np.array([one.growth for one in judged], dtype=np.float64),
        reasons=reasons,
        why=np.array([reasons.index(one.reason) if one.reason else -1 for one in judged], dtype=np.int64),
        seconds=seconds,
    )
