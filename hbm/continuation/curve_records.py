"""What is kept of every point of a curve while it is traced."""

import time
from collections.abc import Sequence
from dataclasses import dataclass, field, replace
from typing import Any

import numpy as np

from updamp.hbm.continuation.branch import BranchPoint
from updamp.hbm.continuation.curve_options import CurveOptions
from updamp.hbm.continuation.predictor_corrector import ContinuationOptions
from updamp.hbm.continuation.response_curve import ResponseCurve
from updamp.hbm.newton import observe
from updamp.hbm.problem.system import Excitation, NonlinearSystem


@dataclass(frozen=True, eq=False)
class CurveRequest:
    """What to trace: a branch through `window` [Hz] at constant force, observed at named points.

    mode: its name in the study; upwards: start at the lower end of the window
    options: of its branches; assembly: of what is put together from them
    """

    mode: str
    excitation: Excitation
    window: tuple[float, float]
    points: tuple[str, ...]
    upwards: bool = True
    options: ContinuationOptions = field(default_factory=ContinuationOptions)
    assembly: CurveOptions = field(default_factory=CurveOptions)


class Records:
    """Columns of the curve, one entry a point."""

    def __init__(
        self, system: NonlinearSystem, request: CurveRequest, started: float, earlier: ResponseCurve | None = None
    ) -> None:
        self.system, self.request, self.started = system, request, started
        self.rows = np.array([system.free.row(p) for p in request.points])
        self.earlier = earlier
        self.columns: dict[str, list[Any]] = {name: [] for name in COLUMNS}
        if earlier is not None:
            for name in COLUMNS:
                self.columns[name].extend(getattr(earlier, name))

    def __len__(self) -> int:
        return len(self.columns["frequency"])

    @property
    def seconds(self) -> float:
        """Since the trace has begun, with those of an earlier session."""
        before = self.earlier.seconds if self.earlier is not None else 0.0
        return before + time.perf_counter() - self.started

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


def empty_curve(request: CurveRequest, system: NonlinearSystem) -> ResponseCurve:
    none = np.zeros(0)
    return ResponseCurve(
        request.mode, request.excitation.force, system.harmonics.orders, request.points,
        none, none, none, none, none, none, none.astype(int), none, none.astype(int), none.astype(bool), False, "", 0.0,
    )  # fmt: skip
