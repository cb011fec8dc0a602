"""What a curve is asked for with, and what is kept of every point while it is traced."""

import time
from collections.abc import Sequence
from dataclasses import dataclass, field, replace
from typing import Any

import numpy as np

from updamp.hbm.continuation.branch import BranchPoint
from updamp.hbm.continuation.completeness import CompletenessLimits
from updamp.hbm.continuation.predictor_corrector import ContinuationOptions
from updamp.hbm.continuation.response_curve import ResponseCurve
from updamp.hbm.newton import observe
from updamp.hbm.problem.linear_model import LinearModel
from updamp.hbm.problem.system import Excitation, NonlinearSystem


@dataclass(frozen=True)
class CurveOptions:
    """Every number that steers how a curve is put together from segments; those of single steps are in
    hbm/continuation/corrector.py, those of ways on where a step fails in hbm/continuation/recovery.

    from_one_end: so many points are traced from one end alone, as many as most curves have; then from both in turn.
        A branch that goes on as it should costs no more that way; one that was lost at a kink is met from the other end
    connecting: where segments from both ends cover the window, so many points more are spent, from where they turn
        back, on what connects them, and as many either way on each further start. It may be long: a hysteresis with
        many contacts that change their states on the way between its folds, or a sharp resonance of nearly free blades,
        from either side of which it comes in steps of 0.02. With 150 three curves of the stress grid ended there that
        are complete with 600 (benchmarks/harmonic_balance/NOTES.md)
    most_starts: of further segments, where those from both ends do not meet; from_starts: so many points either way on
        all of them together
    start_lengths: beyond an open end, in units of arc, at which starts are looked for; start_shares: and at fixed
        frequencies so far ahead of it, as shares of the window
    same_start: starts closer than this are the same one [arc]: below the shortest step on the far side of a kink
    points_at_extreme: at most so many are solved at the top of the peak and at a fold where a sweep jumps, each where a
        spline through those before it expects it, on the plane across the chord between its neighbours. Beside a sharp
        fold it takes ten; elsewhere a point is there after one or two
    there: how close to it a point is at it, as a share of the length of the points about it: what is read is off by the
        square of it beside a smooth extreme; on a flank that ends in a kink 1e-3 were 0.3 % of the height
    settled_at: so many points, spread over the curve, at which laws with a memory are asked whether they have settled
    limits: of the gaps in a complete curve
    detached: so many points at most either way on a branch beside the curve, traced from a solution that the curve does
        not have: as many in all as `connecting`, for what is found there need not lead anywhere
    """

    from_one_end: int = 200
    connecting: int = 600
    most_starts: int = 12
    from_starts: int = 1800
    start_lengths: tuple[float, ...] = (0.03, 0.1, 0.2, 0.4)
    start_shares: tuple[float, ...] = (0.0025, 0.005, 0.01, 0.02, 0.04, 0.08, 0.16, 0.32)
    same_start: float = 1e-4
    points_at_extreme: int = 20
    there: float = 1e-4
    settled_at: int = 8
    limits: CompletenessLimits = field(default_factory=CompletenessLimits)
    detached: int = 300


@dataclass(frozen=True, eq=False)
class CurveRequest:
    """What to trace: a branch through `window` [Hz] at constant force, observed at named points.

    mode: its name in the study; upwards: start at the lower end of the window
    options: of its branches; assembly: of what is put together from them
    told: points whose peaks are told, the first observed one where none is named: a point is solved at the top of each,
        and whether the window holds the resonance is asked at the first

    raises: ValueError for a window that does not rise from a positive frequency, a force that is not positive, no
        point, a point told that is not observed, and names given as one string
    """

    mode: str
    excitation: Excitation
    window: tuple[float, float]
    points: tuple[str, ...]
    upwards: bool = True
    options: ContinuationOptions = field(default_factory=ContinuationOptions)
    assembly: CurveOptions = field(default_factory=CurveOptions)
    told: tuple[str, ...] = ()

    def __post_init__(self) -> None:
        force = self.excitation.force
        refuse_window(self.window)
        if not 0 < force < np.inf:
            raise ValueError(f"force = {force:g} N: a curve needs a positive one")
        _refuse_string("points", self.points)
        _refuse_string("told", self.told)
        if not self.peaks_at:
            raise ValueError("points: at least one is needed, at which the peak is told")
        if missing := [point for point in self.told if point not in self.points]:
            raise ValueError(f"told: '{missing[0]}' is not observed; points are {', '.join(self.points)}")

    @property
    def peaks_at(self) -> tuple[str, ...]:
        return self.told or self.points[:1]


def _refuse_string(what: str, names: Any) -> None:
    """Its letters would be taken for names."""
    if isinstance(names, str):
        raise ValueError(f"{what} = '{names}': a tuple of names is needed, such as {(names,)}")


def refuse_window(window: tuple[float, float]) -> None:
    """raises: ValueError for a window [Hz] that does not rise from a positive frequency"""
    if np.shape(window) != (2,):
        raise ValueError(f"window = {window}: two frequencies in Hz are needed, a lower and a higher one")
    low, high = window
    if not 0 < low < high < np.inf:
        raise ValueError(f"window = {low:g} to {high:g} Hz: a lower and a higher frequency are needed, above 0")


def observed_points(model: LinearModel) -> tuple[str, ...]:
    """Names of all points of a rig but those that the force acts on."""
    return tuple(name for name in model.points if ".excitation." not in name)


class Records:
    """Columns of the curve, one entry a point."""

    def __init__(self, system: NonlinearSystem, request: CurveRequest, started: float) -> None:
        self.system, self.request, self.started = system, request, started
        self.rows = np.array([system.free.row(p) for p in request.points])
        self.columns: dict[str, list[Any]] = {name: [] for name in COLUMNS}

    def __len__(self) -> int:
        return len(self.columns["frequency"])

    @property
    def seconds(self) -> float:
        """Since the trace has begun."""
        return time.perf_counter() - self.started

    def add(self, point: BranchPoint) -> None:
        equation, excitation = point.solution.equation, self.request.excitation
        rows = np.append(self.rows, excitation.row)
        response = observe.response(equation, excitation, rows)
        assert point.solution.jacobian is not None, "a converged solution carries its Jacobian"
        entry: dict[str, Any] = {
            "frequency": point.frequency,
            "displacement": point.x,
            "response": response[:-1],
            "work_in": observe.work_in(self.system, excitation, response[-1]),
            "friction_loss": float(observe.friction_loss(self.system, point.x, point.w).sum()),
            "material_loss": observe.material_loss(equation, excitation),
            "iterations": point.solution.iterations,
            "error": equation.error,
            "active": point.solution.jacobian.n_active,
            "after_gap": point.after_gap,
        }
        for name, value in entry.items():
            self.columns[name].append(value)

    def cut(self, length: int) -> None:
        """Forget what follows the first `length` points."""
        for values in self.columns.values():
            del values[length:]

    def curve(self, complete: bool = False, stopped: str = "") -> ResponseCurve:
        columns = {name: np.array(values) for name, values in self.columns.items()}
        return replace(
            empty_curve(self.request, self.system),
            **columns,  # type: ignore[arg-type]
            complete=complete,
            stopped=stopped,
            seconds=self.seconds,
        )


def put_together(first: Records, parts: Sequence[tuple[Records, bool, bool]]) -> ResponseCurve:
    """One curve of several records: (records, whether the other way round, whether a gap lies before them); none where
    no point was found. first: those whose time is counted"""
    whole = Records(first.system, first.request, first.started)
    for records, backwards, gap in parts:
        way = slice(None, None, -1 if backwards else 1)
        # a gap comes before the point that follows it, in the other direction before the one that it follows
        columns = {**records.columns, "after_gap": [gap and len(whole) > 0, *records.columns["after_gap"][1:][way]]}
        for name, values in columns.items():
            whole.columns[name].extend(values if name == "after_gap" else values[way])
    return replace(whole.curve(), seconds=first.seconds)


COLUMNS = (
    "frequency", "displacement", "response", "work_in", "friction_loss", "material_loss",
    "iterations", "error", "active", "after_gap",
)  # fmt: skip


def with_point(
    system: NonlinearSystem, request: CurveRequest, curve: ResponseCurve, point: BranchPoint, before: int
) -> ResponseCurve:
    """The curve with one more point, before the one of that number."""
    added = Records(system, request, 0.0)
    added.add(point)
    columns = {name: np.insert(getattr(curve, name), before, added.columns[name][0], axis=0) for name in COLUMNS}
    return replace(curve, **columns)


def without_point(curve: ResponseCurve, place: int) -> ResponseCurve:
    """The curve without the point of that number"""
    return replace(curve, **{name: np.delete(getattr(curve, name), place, axis=0) for name in COLUMNS})


def empty_curve(request: CurveRequest, system: NonlinearSystem) -> ResponseCurve:
    none = np.zeros(0)
    columns: dict[str, Any] = dict.fromkeys(COLUMNS, none)
    columns |= {"iterations": none.astype(int), "active": none.astype(int), "after_gap": none.astype(bool)}
    return ResponseCurve(
        mode=request.mode,
        force=request.excitation.force,
        orders=system.harmonics.orders,
        points=request.points,
        **columns,
        complete=False,
        stopped="",
        seconds=0.0,
    )
