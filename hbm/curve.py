"""Trace a response curve: continuation, with what is to be kept of every point."""

import time
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, field, replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from updamp.hbm import energy, observe
from updamp.hbm.branch import BranchPoint, branch_point
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
    last: BranchPoint | None = resume[-1] if resume else None
    try:
        for last in continue_branch(
            system, request.excitation, request.window, request.options, request.upwards, resume
        ):
            records.add(last)
            yield records.curve()
    except BranchStoppedError as stop:
        yield from _from_the_other_end(system, request, records, last, str(stop))
        return
    yield records.curve(complete=not (reason := _unfinished(request, records.curve())), stopped=reason)


# Arc between the ends of two pieces up to which they count as one branch: about two ordinary steps.
_JOINT = 0.4
# And from which on there is nothing left between them.
_MET = 0.03


def _from_the_other_end(
    system: NonlinearSystem, request: CurveRequest, records: "_Records", stuck: BranchPoint | None, reason: str
) -> Iterator[ResponseCurve]:
    """Where the branch cannot go on, it is traced backwards from the far end of the window until both pieces meet.

    The second piece is handed out when it is joined to the first; if the two do not meet, it is kept too and the
    curve says why it stopped.
    """
    if stuck is None:
        yield records.curve(stopped=reason)
        return
    second, nearest = _Records(system, request, None, records.started), np.inf
    try:
        for point in continue_branch(system, request.excitation, request.window, request.options, not request.upwards):
            apart = stuck.distance(point)
            if nearest < _JOINT and apart > nearest:
                break
            second.add(point)
            nearest = apart
            if nearest < _MET:
                break
            yield records.curve()
    except BranchStoppedError as stop:
        reason = f"{reason}. From the other end: {stop}"
    joined = nearest < _JOINT
    yield records.joined(second, complete=joined, stopped="" if joined else reason)


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
        # A gap of the second piece comes before the point that follows it in its own direction.
        second.columns["after_gap"] = [True, *second.columns["after_gap"][1:]]
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
