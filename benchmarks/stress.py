"""Does every curve finish? 208 curves over the corners and the inside of what a user might ask for, at `small` size.

    .venv/bin/python benchmarks/stress.py                  (all; goes on where it was interrupted)
    .venv/bin/python benchmarks/stress.py --first 30       (a mixed sample: the design is in random order)
    .venv/bin/python benchmarks/stress.py --again          (those that did not finish, once more)

Two modes x force 0.01-100 N x mu 0.1-1.2 x kt, kn 1e3-1e7 N/mm^3 (each on its own) x pull 50-5000 N: all 64 corners,
and 72 points a mode of a Latin hypercube, even in the logarithm. The finite element model is the same for all of them.

The window follows from the linear system. A mode's resonance lies between three: all contacts stuck, all sliding
without friction (kt = 0), and the blades free of the damper. It reaches from 5 % below the lowest to 5 % above the
highest, so that the whole resonance is traced, whatever the force makes of it. Where the other mode lies between
these, its resonance is traced too.

A curve that has taken longer than its limit counts as not finished. Processor time is what is limited, so that a busy
machine does not change what finishes. Written: results/stress.jsonl, one line a curve, and results/stress.json
{"curves", "finished", "unfinished": [{mode, force_N, ..., reason}]}.
"""

import os

from updamp.parallel.resources import thread_limits

# One thread, before numpy and JAX are loaded, here and in every worker.
os.environ.update(thread_limits(1))

import itertools
import json
import time
from collections.abc import Iterable, Iterator, Sequence
from concurrent.futures import ProcessPoolExecutor, as_completed
from dataclasses import asdict, dataclass
from multiprocessing import get_context
from pathlib import Path
from typing import Annotated, Any

import numpy as np
import typer
from rich.console import Console
from rich.progress import BarColumn, MofNCompleteColumn, Progress, TextColumn, TimeElapsedColumn
from rich.table import Table
from scipy.stats import qmc

from updamp.fem.finite_element_model import finite_element_model
from updamp.fem.reduced_model import ReducedModel
from updamp.fem.static_contact.static_contact import static_contact
from updamp.geometry.build_mesh import build_mesh
from updamp.hbm.continuation.curve import CurveRequest, trace
from updamp.hbm.continuation.response_curve import ResponseCurve
from updamp.hbm.problem.linear_model import LinearModel, stuck_on
from updamp.hbm.problem.system import NonlinearSystem
from updamp.model.build import rig_model
from updamp.model.rig_files import load_rig

ROOT = Path(__file__).parents[1]
RIG = ROOT / "rigs" / "pesaresi2017.toml"
MODES = {"OOP": -1.0, "IP": 1.0}  # sign of the left tip's motion against the right one's
RANGES = {
    "force_N": (0.01, 100.0),
    "mu": (0.1, 1.2),
    "kt_N_per_mm3": (1e3, 1e7),
    "kn_N_per_mm3": (1e3, 1e7),
    "pull_N": (50.0, 5000.0),
}
INSIDE, SEED = 72, 20261122  # points of the hypercube a mode
MARGIN = 0.05  # of the window, beyond the lowest and the highest linear frequency


@dataclass(frozen=True)
class StressCase:
    """One curve."""

    mode: str
    force_N: float  # noqa: N815
    mu: float
    kt_N_per_mm3: float  # noqa: N815
    kn_N_per_mm3: float  # noqa: N815
    pull_N: float  # noqa: N815


@dataclass(frozen=True)
class Outcome:
    """What became of a case; reason: why it did not finish, "" if it did; seconds: of processor time"""

    case: StressCase
    finished: bool
    reason: str
    window_Hz: tuple[float, float]  # noqa: N815
    points: int
    gaps: int
    iterations: int
    seconds: float


def design() -> tuple[StressCase, ...]:
    """All cases, in an order in which any first part is mixed."""
    rng = np.random.default_rng(SEED)
    corners = [StressCase(mode, *values) for mode in MODES for values in itertools.product(*RANGES.values())]
    low, high = np.log10(np.array(list(RANGES.values())).T)
    inside = [
        StressCase(mode, *(float(f"{10**v:.4g}") for v in row))
        for mode in MODES
        for row in qmc.scale(qmc.LatinHypercube(len(RANGES), rng=rng).random(INSIDE), low, high)
    ]
    cases = [*corners, *inside]
    return tuple(cases[i] for i in rng.permutation(len(cases)))


# --- one curve ---


def system_of(case: StressCase, reduced: ReducedModel) -> tuple[NonlinearSystem, CurveRequest]:
    rig = load_rig(
        RIG,
        {
            "contact.friction_coefficient": case.mu,
            "contact.tangential_stiffness": f"{case.kt_N_per_mm3} N/mm^3",
            "contact.normal_stiffness": f"{case.kn_N_per_mm3} N/mm^3",
            "load.pull": f"{case.pull_N} N",
        },
    )
    model = rig_model(reduced, static_contact(reduced, rig), rig)
    tip = f"blade_{rig.excitation.blade}.tip.x"
    requested = CurveRequest(case.mode, model.excited_by(case.force_N), window(model.system, case.mode), (tip,))
    return model.system, requested


def window(system: NonlinearSystem, mode: str) -> tuple[float, float]:
    """[Hz], around the mode stuck, sliding without friction, and free of the damper."""
    sliding = system.reference_stiffness.copy()
    for group in system.groups:
        sliding[group.rows[:, :2]] = 0.0
    models = (system.stuck, stuck_on(system.free, sliding), system.free)
    frequencies = [bending_frequency(model, MODES[mode]) for model in models]
    return (1 - MARGIN) * min(frequencies), (1 + MARGIN) * max(frequencies)


def bending_frequency(model: LinearModel, sign: float) -> float:
    """[Hz] of the mode that makes up most of what both tips yield to forces alike (sign 1) or opposite (-1)."""
    left, right = (model.phi[model.row(f"blade_{side}.tip.x")] for side in ("left", "right"))
    return float(model.frequencies[np.argmax((right + sign * left) ** 2 / model.omega_squared)])


def run_case(case: StressCase, reduced: ReducedModel, limit: float) -> Outcome:
    """limit: of processor time [s]"""
    started, curve, over = time.process_time(), None, False
    system, request = system_of(case, reduced)
    for curve in trace(system, request):
        if curve.complete or curve.stopped:
            break
        over = time.process_time() - started > limit
        if over:
            break
    assert curve is not None, "a trace hands out at least one curve"
    return _outcome(case, request.window, curve, limit if over else None, time.process_time() - started)


def _outcome(
    case: StressCase, window: tuple[float, float], curve: ResponseCurve, limit: float | None, seconds: float
) -> Outcome:
    reason = curve.stopped
    if limit is not None:
        at = f"{curve.frequency[-1]:.2f} Hz" if len(curve) else "the first point"
        reason = f"time: {limit:g} s were not enough; {len(curve)} points, at {at}"
    points, gaps = len(curve), int(curve.after_gap.sum())
    return Outcome(case, curve.complete, reason, window, points, gaps, int(curve.iterations.sum()), round(seconds, 2))


# --- many curves, and what is kept of them ---


def read_outcomes(path: Path) -> dict[StressCase, Outcome]:
    """Those on file; the last one counts where a case was traced again. A line cut short is passed over."""
    outcomes: dict[StressCase, Outcome] = {}
    if path.exists():
        for line in path.read_text().splitlines():
            try:
                entry = json.loads(line)
            except json.JSONDecodeError:  # the run was interrupted as it wrote
                continue
            case = StressCase(**entry.pop("case"))
            outcomes[case] = Outcome(case, **{**entry, "window_Hz": tuple(entry["window_Hz"])})
    return outcomes


def append_outcome(path: Path, outcome: Outcome) -> None:
    path.parent.mkdir(parents=True, exist_ok=True)
    cut_short = path.exists() and path.read_bytes()[-1:] not in (b"", b"\n")
    with path.open("a") as file:
        file.write(("\n" if cut_short else "") + json.dumps(asdict(outcome)) + "\n")


def to_do(cases: Sequence[StressCase], known: dict[StressCase, Outcome], again: bool) -> list[StressCase]:
    """Cases not on file, and with `again` those that did not finish."""
    return [case for case in cases if case not in known or (again and not known[case].finished)]


def summary(outcomes: Iterable[Outcome]) -> dict[str, Any]:
    outcomes = list(outcomes)
    unfinished = [{**asdict(o.case), "reason": o.reason} for o in outcomes if not o.finished]
    return {"curves": len(outcomes), "finished": len(outcomes) - len(unfinished), "unfinished": unfinished}


def run_all(cases: Sequence[StressCase], reduced: ReducedModel, limit: float, jobs: int) -> Iterator[Outcome]:
    """Outcomes as they come; an error in a case is its reason."""
    if jobs == 1:
        for case in cases:
            yield _safely(case, reduced, limit)
        return
    with ProcessPoolExecutor(jobs, mp_context=get_context("spawn")) as pool:
        for future in as_completed([pool.submit(_safely, case, reduced, limit) for case in cases]):
            yield future.result()


def _safely(case: StressCase, reduced: ReducedModel, limit: float) -> Outcome:
    try:
        return run_case(case, reduced, limit)
    except Exception as error:
        return Outcome(case, False, f"{type(error).__name__}: {error}", (0.0, 0.0), 0, 0, 0, 0.0)


# --- the terminal ---


def main(
    first: Annotated[int | None, typer.Option(help="only the first of the design")] = None,
    jobs: Annotated[int, typer.Option(help="curves at the same time")] = 1,
    limit: Annotated[float, typer.Option(help="processor time a curve [s]")] = 300.0,
    again: Annotated[bool, typer.Option(help="trace once more what did not finish")] = False,
    fresh: Annotated[bool, typer.Option(help="forget what is on file")] = False,
    out: Annotated[Path, typer.Option(help="folder of stress.json and stress.jsonl")] = ROOT / "results",
) -> None:
    """Trace the curves, write the results, print the share that finished and the reasons of the others."""
    console, record = Console(width=160), out / "stress.jsonl"
    if fresh:
        record.unlink(missing_ok=True)
    cases = design()[:first]
    known = read_outcomes(record)
    left = to_do(cases, known, again)
    if left:
        rig = load_rig(RIG)
        reduced = finite_element_model(build_mesh(rig, "small"), rig).reduced
        columns = (TextColumn("{task.description}"), BarColumn(), MofNCompleteColumn(), TimeElapsedColumn())
        with Progress(*columns, console=console, transient=True) as progress:
            bar = progress.add_task("curves", total=len(cases), completed=len(cases) - len(left))
            for outcome in run_all(left, reduced, limit, jobs):
                append_outcome(record, outcome)
                known[outcome.case] = outcome
                failed = sum(not known[case].finished for case in cases if case in known)
                progress.update(bar, advance=1, description=f"curves ({failed} not finished)")
    outcomes = [known[case] for case in cases]
    (out / "stress.json").write_text(json.dumps(summary(outcomes), indent=2) + "\n")
    show(console, outcomes)


def show(console: Console, outcomes: Sequence[Outcome]) -> None:
    finished = sum(o.finished for o in outcomes)
    seconds, points = sum(o.seconds for o in outcomes), sum(o.points for o in outcomes)
    console.print(
        f"{finished} of {len(outcomes)} curves finished ({finished / len(outcomes):.1%}), "
        f"{sum(o.gaps > 0 for o in outcomes if o.finished)} of them with jumps; "
        f"{points} points, {seconds / 60:.1f} minutes of processor time"
    )
    if finished == len(outcomes):
        return
    table = Table("mode", *RANGES, "reason", show_lines=False)
    for outcome in outcomes:
        if not outcome.finished:
            values = asdict(outcome.case)
            table.add_row(values.pop("mode"), *(f"{v:.3g}" for v in values.values()), outcome.reason)
    console.print(table)


if __name__ == "__main__":
    typer.run(main)
