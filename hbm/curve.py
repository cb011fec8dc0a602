"""Trace a response curve: continuation, with what is to be kept of every point."""

import time
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, field, replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from updamp.hbm import energy, observe
from updamp.hbm.branch import BranchPoint, branch_point
from updamp.hbm.bridge import AHEAD, Bridge
from updamp.hbm.continuation import BranchStoppedError, ContinuationOptions, continue_branch
from updamp.hbm.response_curve import ResponseCurve
from updamp.hbm.system import Excitation, NonlinearSystem

Floats = NDArray[np.float64]


@dataclass(frozen=True, eq=False)
class CurveRequest:
    """What to trace: a branch through `window` [Hz] at constant force, seen at named points.

    mode: its name in the study; upwards: start at the lower end of the window
    """

    mode: str
    excitation: Excitation
    window: tuple[float, float]
    points: tuple[str, ...]
    upwards: bool = True
    options: ContinuationOptions = field(default_factory=ContinuationOptions)


def trace(
    system: NonlinearSystem, request: CurveRequest, resume_from: ResponseCurve | None = None
) -> Iterator[ResponseCurve]:
    """The curve so far, after every point; the last one handed out is `complete` or says why it `stopped`.

    resume_from: an interrupted curve of the same system and request; only what follows it is solved
    raises: nothing; a branch that cannot go on ends the curve with its sentence in `stopped`
    """
    started = time.perf_counter()
    earlier = resume_from
    if earlier is not None and (earlier.complete or earlier.stopped):
        yield earlier
        return
    resume = _last_points(system, request, earlier) if earlier is not None and len(earlier) >= 2 else ()
    records = _Records(system, request, earlier if resume else None, started)
    first = _Ends(1.0 if request.upwards else -1.0, resume)
    try:
        for point in continue_branch(
            system, request.excitation, request.window, request.options, request.upwards, resume
        ):
            records.add(first.seen(point))
            yield records.curve()
        reason = _unfinished(request, records.curve())
    except BranchStoppedError as stop:
        reason = str(stop)
    if reason and len(records.curve()) < request.options.max_points:
        yield from _from_the_other_end(system, request, records, first, reason)
    else:
        yield records.curve(complete=not reason, stopped=reason)


# Arc between the ends of two pieces up to which they count as one branch: about two ordinary steps.
_JOINT = 0.4
# And from which on there is nothing left between them.
_MET = 0.03


class _Ends:
    """The last point of a piece that runs in the direction `sign`, and the one that came furthest; None at first."""

    def __init__(self, sign: float, points: Sequence[BranchPoint] = ()) -> None:
        self.sign = sign
        self.last: BranchPoint | None = None
        self.furthest: BranchPoint | None = None
        for point in points:
            self.seen(point)

    def seen(self, point: BranchPoint) -> BranchPoint:
        self.last = point
        if self.furthest is None or self.sign * (point.w - self.furthest.w) > 0:
            self.furthest = point
        return point


def _from_the_other_end(
    system: NonlinearSystem, request: CurveRequest, records: "_Records", first: _Ends, reason: str
) -> Iterator[ResponseCurve]:
    """Where the branch cannot go on, it is traced backwards from the far end of the window until both pieces meet.

    The second piece is handed out when it is joined to the first. Where both stop with frequencies between them that
    neither came to, these are crossed by new starts (hbm/bridge.py); where even that fails, the curve says why.
    """
    second, backwards = _Records(system, request, None, records.started), _Ends(-first.sign)
    nearest = np.inf
    try:
        for point in continue_branch(system, request.excitation, request.window, request.options, not request.upwards):
            apart = first.last.distance(point) if first.last is not None else np.inf
            if nearest < _JOINT and apart > nearest:
                break
            second.add(backwards.seen(point))
            nearest = apart
            if nearest < _MET:
                break
            yield records.curve()
        reason = f"{reason}. From the other end it ended at {point.frequency:.2f} Hz"
    except BranchStoppedError as stop:
        reason = f"{reason}. From the other end: {stop}"
    complete = nearest < _JOINT
    if not complete:
        yield from _across(system, request, records, second, (first, backwards))
        # a start no further ahead is known already: the other piece's end
        complete = _covered(request, first, backwards, AHEAD[-1])
    yield records.joined(second, complete=complete, stopped="" if complete else reason)


def _across(
    system: NonlinearSystem, request: CurveRequest, records: "_Records", second: "_Records", ends: tuple[_Ends, _Ends]
) -> Iterator[ResponseCurve]:
    """New starts between two pieces: from the first one's end on, and if they do not come to the second one's, from
    there on towards the first.
    """
    for growing, other, of in ((ends[0], ends[1], records), (ends[1], ends[0], second)):
        if growing.furthest is None or _covered(request, *ends):
            continue
        until = other.furthest.w if other.furthest is not None else 2 * np.pi * _limit(request, growing.sign)
        bridge = Bridge(system, request.excitation, request.window, request.options, growing.sign, until)
        for point in bridge.points(growing.furthest):
            of.add(growing.seen(point))
            yield records.curve()


def _limit(request: CurveRequest, sign: float) -> float:
    """End of the window in that direction [Hz]"""
    return request.window[1] if sign > 0 else request.window[0]


def _covered(request: CurveRequest, first: _Ends, second: _Ends, but_for: float = 0.0) -> bool:
    """Whether the pieces leave out no more than a share of the window between them."""
    places = [
        2 * np.pi * _limit(request, -end.sign) if end.furthest is None else end.furthest.w for end in (first, second)
    ]
    width = 2 * np.pi * (request.window[1] - request.window[0])
    return first.sign * (places[1] - places[0]) <= but_for * width


def _unfinished(request: CurveRequest, curve: ResponseCurve) -> str:
    """Why a branch that ended did not go through the window, "" if it did."""
    (low, high), last = request.window, curve.frequency[-1]
    if low <= last <= high:
        return f"the end of the window was not reached in {request.options.max_points} points: raise max_points"
    if (last > high) != request.upwards:
        return f"the branch came back to {last:.2f} Hz, where it began: widen the window there or take smaller steps"
    return ""


def _last_points(system: NonlinearSystem, request: CurveRequest, curve: ResponseCurve) -> Sequence[BranchPoint]:
    """The last two points of a stored curve as points of a branch, tangents computed anew."""
    scale_w = request.options.scale_w(request.window)
    places = [(curve.displacement[i], 2 * np.pi * curve.frequency[i]) for i in (-2, -1)]
    onwards = (places[1][0] - places[0][0], places[1][1] - places[0][1])
    return [branch_point(system, request.excitation, x, w, scale_w, onwards) for x, w in places]


class _Records:
    """Columns of the curve, one entry a point."""

    def __init__(
        self, system: NonlinearSystem, request: CurveRequest, earlier: ResponseCurve | None, started: float
    ) -> None:
        self.system, self.request, self.started = system, request, started
        self.rows = np.array([system.free.row(p) for p in request.points])
        self.earlier = earlier
        self.columns: dict[str, list[Any]] = {name: [] for name in COLUMNS}
        if earlier is not None:
            for name in COLUMNS:
                self.columns[name].extend(getattr(earlier, name))

    def add(self, point: BranchPoint) -> None:
        equation, excitation = point.solution.equation, self.request.excitation
        rows = np.append(self.rows, excitation.row)
        response = observe.response(equation, excitation, rows)
        assert point.solution.jacobian is not None, "a converged solution carries its Jacobian"
        entry: dict[str, Any] = {
            "frequency": point.frequency,
            "displacement": point.x,
            "response": response[:-1],
            "work_in": energy.work_in(self.system, excitation, response[-1]),
            "friction_loss": float(energy.friction_loss(self.system, point.x, point.w).sum()),
            "material_loss": energy.material_loss(equation, excitation),
            "iterations": point.solution.iterations,
            "error": equation.error,
            "active": point.solution.jacobian.n_active,
            "after_gap": point.after_gap,
        }
        for name, value in entry.items():
            self.columns[name].append(value)

    def joined(self, second: "_Records", complete: bool, stopped: str = "") -> ResponseCurve:
        """This piece, and after it the second one the other way round."""
        if not second.columns["after_gap"]:
            return self.curve(complete, stopped)
        # A gap of the second piece comes before the point that follows it in its own direction.
        second.columns["after_gap"] = [bool(self.columns["after_gap"]), *second.columns["after_gap"][1:]]
        gaps = np.roll(second.columns["after_gap"], -1)
        for name in COLUMNS:
            self.columns[name].extend(reversed(second.columns[name]) if name != "after_gap" else gaps[::-1])
        return self.curve(complete, stopped)

    def curve(self, complete: bool = False, stopped: str = "") -> ResponseCurve:
        before = self.earlier.seconds if self.earlier is not None else 0.0
        columns = {name: np.array(values) for name, values in self.columns.items()}
        return replace(
            _empty(self.request, self.system),
            **columns,  # type: ignore[arg-type]
            complete=complete,
            stopped=stopped,
            seconds=before + time.perf_counter() - self.started,
        )


COLUMNS = (
    "frequency", "displacement", "response", "work_in", "friction_loss", "material_loss",
    "iterations", "error", "active", "after_gap",
)  # fmt: skip


def _empty(request: CurveRequest, system: NonlinearSystem) -> ResponseCurve:
    none = np.zeros(0)
    return ResponseCurve(
        request.mode, request.excitation.force, system.harmonics.orders, request.points,
        none, none, none, none, none, none, none.astype(int), none, none.astype(int), none.astype(bool), False, "", 0.0,
    )  # fmt: skip
