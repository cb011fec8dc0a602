"""What following a resonance hands on: peak receptance, frequency and damping against force and amplitude."""

import time
from collections import deque
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, fields, replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from updamp.hbm.contact.law import FrictionLaw
from updamp.hbm.continuation.curve_records import refuse_window
from updamp.hbm.harmonics import Harmonics
from updamp.hbm.newton import observe
from updamp.hbm.newton.observe import ContactState
from updamp.hbm.problem.mirror import Mirror
from updamp.hbm.problem.system import NonlinearSystem
from updamp.hbm.resonance.backbone import ResonancePoint, follow_resonance
from updamp.hbm.resonance.conditions import ResonanceCondition
from updamp.hbm.resonance.equivalent_damping import damping_ratio_from_phase, loss_factor, stored_energy
from updamp.hbm.resonance.resonance import ResonanceProblem, ResonanceState
from updamp.hbm.resonance.resonance_steps import ResonanceOptions, ResonanceStoppedError

Floats = NDArray[np.float64]
Integers = NDArray[np.int64]


@dataclass(frozen=True, eq=False)
class ResonanceRequest:
    """What to follow: one mode's resonance, as observed at `point`, under a force at `excited`, both named.

    window: [Hz] where it lies at a small force; forces: [N], met exactly, from the first to the last
    start, mode_frequency: see `follow_resonance`

    raises: ValueError for a window that does not rise from a positive frequency
    """

    mode: str
    excited: str
    point: str
    window: tuple[float, float]
    forces: Sequence[float]
    condition: ResonanceCondition
    options: ResonanceOptions | None = None
    start: ResonanceState | None = None
    mode_frequency: float | None = None

    def __post_init__(self) -> None:
        refuse_window(self.window)


@dataclass(frozen=True, eq=False)
class ResonanceCurve:
    """A resonance against force, its points in the order in which they were met.

    force: (n,) [N]; frequency: (n,) [Hz]
    response: (n, n_coefficients) displacement of `point` [m], ordered as in hbm/harmonics.py
    displacement: (n, n_relative, n_coefficients) at the contacts [m]
    loss_factor: (n,) from energy; damping_from_phase: (n,) ratio, nan where not defined (see
    hbm/resonance/equivalent_damping.py); work_in, friction_loss: (n,) [J]
    states: (n, 4) number of contacts in each ContactState; all zero where a law has none
    asked_for: (n,) whether the force is one of the request
    turning: (n,) whether the force turned round since the point before
    active, iterations, error, complete, stopped, seconds: as in ResponseCurve
    """

    mode: str
    point: str
    orders: tuple[int, ...]
    force: Floats
    frequency: Floats
    response: Floats
    displacement: Floats
    loss_factor: Floats
    damping_from_phase: Floats
    work_in: Floats
    friction_loss: Floats
    states: Integers
    asked_for: NDArray[np.bool_]
    turning: NDArray[np.bool_]
    active: Integers
    iterations: Integers
    error: Floats
    complete: bool
    stopped: str
    seconds: float

    def __len__(self) -> int:
        return len(self.force)

    def amplitude(self, k: int = 1) -> NDArray[np.complex128]:
        """(n,) complex amplitude of harmonic k [m]"""
        return Harmonics(self.orders).amplitude(self.response, k)

    @property
    def receptance(self) -> NDArray[np.complex128]:
        """(n,) first harmonic over force [m/N]"""
        return self.amplitude() / self.force

    @property
    def damping_ratio(self) -> Floats:
        """(n,) half the loss factor"""
        return self.loss_factor / 2

    def passes(self, force: float) -> Integers:
        """Places of the points at a force of the request [N], each time that it was passed."""
        return np.flatnonzero(self.asked_for.astype(bool) & np.isclose(self.force, force, rtol=1e-9))

    def at_forces(self) -> "ResonanceCurve":
        """The points at the forces that were asked for."""
        columns: dict[str, Any] = {name: getattr(self, name)[self.asked_for] for name in COLUMNS}
        return replace(self, **columns)


COLUMNS = tuple(
    f.name
    for f in fields(ResonanceCurve)
    if f.name not in ("mode", "point", "orders", "complete", "stopped", "seconds")
)


def trace_resonance(system: NonlinearSystem, request: ResonanceRequest) -> Iterator[ResonanceCurve]:
    """The curve so far, after every point; the last one handed out is `complete` or says why it `stopped`.

    Of a problem that is its own mirror image half is solved, as in `hbm.continuation.curve.trace`.

    raises: KeyError for a name the model has not; ValueError as `follow_resonance`. A resonance that cannot be
    followed on is not raised: it ends the curve with its sentence in `stopped`
    """
    started = time.perf_counter()
    problem, start, mirror = _to_solve(system, request)
    rows: list[dict[str, Any]] = []
    n, n_coefficients = system.free.n_relative, system.harmonics.n_coefficients
    shapes = {"response": (n_coefficients,), "displacement": (n, n_coefficients), "states": (len(ContactState),)}

    def curve(complete: bool = False, stopped: str = "") -> ResonanceCurve:
        columns: dict[str, Any] = {
            name: np.reshape([row[name] for row in rows], (len(rows), *shapes.get(name, ()))) for name in COLUMNS
        }
        columns |= {name: columns[name].astype(bool) for name in ("asked_for", "turning")}
        seconds = time.perf_counter() - started
        head = (request.mode, request.point, system.harmonics.orders)
        return ResonanceCurve(*head, **columns, complete=complete, stopped=stopped, seconds=seconds)

    points = follow_resonance(
        problem, request.condition, request.window, request.forces, request.options, start, request.mode_frequency
    )
    try:
        for point in points:
            row = _row(problem.system, point)
            x = mirror.whole(point.solution.x) if mirror is not None else point.solution.x
            rows.append(row | {"displacement": x, "states": _states(system, x, point.solution.w)})
            yield curve()
    except ResonanceStoppedError as stop:
        yield curve(stopped=str(stop))
        return
    reached = bool(rows[-1]["asked_for"]) and np.isclose(rows[-1]["force"], request.forces[-1])
    forces = [row["force"] for row in rows]
    yield curve(complete=bool(reached), stopped="" if reached else _why_short(forces, request))


def _to_solve(
    system: NonlinearSystem, request: ResonanceRequest
) -> tuple[ResonanceProblem, ResonanceState | None, Mirror | None]:
    """The problem, or the half of it that is driven; where it begins; and what makes the whole of a half again"""
    start, driven = request.start, system.half_driven_at(system.free.row(request.excited))
    solved, mirror = driven or (system, None)
    if mirror is not None and start is not None:
        start = replace(start, z=mirror.halved(start.z))
    excited, observed = solved.free.row(request.excited), solved.free.row(request.point)
    whole = system if mirror is not None else None
    return ResonanceProblem(solved, excited, observed, whole=whole), start, mirror


def _why_short(forces: Sequence[float], request: ResonanceRequest) -> str:
    """forces: of the points in their order [N], of which the last one that is asked for is not reached"""
    first, last = forces[0], forces[-1]
    if (last - first) * (request.forces[-1] - first) <= 0:
        farthest = max(forces, key=lambda force: abs(force - first))
        return f"the resonance turned back in force, beyond {farthest:.4g} N"
    options = request.options or ResonanceOptions()
    return f"max_points = {options.max_points} were used up at {last:.4g} N; allow for more of them"


def whole_resonance(system: NonlinearSystem, request: ResonanceRequest) -> ResonanceCurve:
    """What `trace_resonance` ends with; nothing else of it is kept. raises: as `trace_resonance`"""
    (whole,) = deque(trace_resonance(system, request), maxlen=1)
    return whole


def _row(system: NonlinearSystem, point: ResonancePoint) -> dict[str, Any]:
    solution = point.solution
    excitation, equation = solution.excitation, solution.equation
    excited = observe.response(equation, excitation, np.array([excitation.row]))[0]
    work, stored = observe.work_in(system, excitation, excited), stored_energy(equation, excitation)
    return {
        "force": solution.force,
        "frequency": solution.frequency,
        "response": solution.response,
        "loss_factor": loss_factor(work, stored),
        "damping_from_phase": damping_ratio_from_phase(solution),
        "work_in": work,
        "friction_loss": float(observe.friction_loss(system, solution.x, solution.w).sum()),
        "asked_for": point.asked_for,
        "turning": point.turning,
        "active": solution.linearised.jacobian.n_active,
        "iterations": solution.iterations,
        "error": solution.error,
    }


def _states(system: NonlinearSystem, x: Floats, w: float) -> Integers:
    if not all(isinstance(group.law, FrictionLaw) for group in system.groups):
        return np.zeros(len(ContactState), dtype=np.int64)
    return np.bincount(observe.contact_states(system, x, w), minlength=len(ContactState))
