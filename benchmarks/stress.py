"""Is every curve complete, and is its peak the highest resonance? 280 curves at `small` size.

    .venv/bin/python benchmarks/stress.py                  (all; goes on where it was interrupted)
    .venv/bin/python benchmarks/stress.py --first 30       (a mixed sample: the design is in random order)
    .venv/bin/python benchmarks/stress.py --again          (those that are not complete, once more)

Two modes; mu 0.1-1.2, kt and kn 1e3-1e7 N/mm^3, each on its own, all even in the logarithm (Latin hypercube). 240
curves with a pull of 50-5000 N and a force from 0.01 N to the pull, at most 100 N; 40 with a pull of 50-100 N and a
force beyond it, up to 100 N. The finite element model is the same for all of them.

The window follows from the linear system. A mode's resonance lies between three: all contacts stuck, all sliding
without friction (kt = 0), and the blades free of the damper. It reaches from 5 % below the lowest to 5 % above the
highest, so that the whole resonance is traced, whatever the force makes of it. Where the other mode lies between
these, its resonance is traced too.

Complete is as in hbm/continuation/completeness.py. Two checks look for a higher peak than a complete curve reports:
the curve traced from the other end, and the resonance followed in the force up to this one. A peak that is more than 1
% below what they find is false.

A curve that has taken longer than its limit counts as not complete. Processor time is what is limited, so that a busy
machine does not change the outcome; the checks have a limit of their own. Written: results/stress.jsonl, one line a
curve, and results/stress.json {"within_pull", "beyond_pull": {"curves", "complete", "checked", "false_peaks"},
"not_complete": [...], "false_peaks": [...]}.
"""

import os

from updamp.parallel.resources import thread_limits

# One thread, before numpy and JAX are loaded, here and in every worker.
os.environ.update(thread_limits(1))

import json
import time
from collections.abc import Iterable, Iterator, Mapping, Sequence
from concurrent.futures import ProcessPoolExecutor, as_completed
from dataclasses import asdict, dataclass, field, replace
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
from updamp.hbm.resonance.conditions import PhaseResonance
from updamp.hbm.resonance.resonance_curve import ResonanceRequest, trace_resonance
from updamp.model.build import rig_model
from updamp.model.rig_files import load_rig

ROOT = Path(__file__).parents[1]
RIG = ROOT / "rigs" / "pesaresi2017.toml"
MODES = {"OOP": -1.0, "IP": 1.0}  # sign of the left tip's motion against the right one's
# Lowest and highest; the force reaches up to the pull, or from there up to the highest.
FORCE, PULL, PULL_BELOW_FORCE = (0.01, 100.0), (50.0, 5000.0), (50.0, 100.0)
RANGES = {"mu": (0.1, 1.2), "kt_N_per_mm3": (1e3, 1e7), "kn_N_per_mm3": (1e3, 1e7)}
WITHIN, BEYOND, SEED = 240, 40, 65925990
MARGIN = 0.05  # of the window, beyond the lowest and the highest linear frequency
FALSE = 0.01  # below a peak that a check has found, relative


@dataclass(frozen=True)
class StressCase:
    """One curve."""

    mode: str
    force_N: float  # noqa: N815
    mu: float
    kt_N_per_mm3: float  # noqa: N815
    kn_N_per_mm3: float  # noqa: N815
    pull_N: float  # noqa: N815

    @property
    def within_pull(self) -> bool:
        return self.force_N <= self.pull_N


@dataclass(frozen=True)
class Outcome:
    """What became of a case. reason: why it is not complete, "" if it is; seconds: of processor time

    peak_mm_per_N, peak_Hz: of the curve; checks: by name, the peak [mm/N] that each check has found, where it found one
    """

    case: StressCase
    complete: bool
    reason: str
    window_Hz: tuple[float, float]  # noqa: N815
    points: int
    gaps: int
    iterations: int
    seconds: float
    peak_mm_per_N: float = float("nan")  # noqa: N815
    peak_Hz: float = float("nan")  # noqa: N815
    checks: Mapping[str, float] = field(default_factory=dict)

    @property
    def false_peak(self) -> bool:
        return self.complete and any(peak > (1 + FALSE) * self.peak_mm_per_N for peak in self.checks.values())


def design() -> tuple[StressCase, ...]:
    """All cases, in an order in which any first part is mixed."""
    rng = np.random.default_rng(SEED)
    cases = [*_cases(rng, WITHIN, within=True), *_cases(rng, BEYOND, within=False)]
    return tuple(cases[i] for i in rng.permutation(len(cases)))


def _cases(rng: np.random.Generator, count: int, within: bool) -> Iterator[StressCase]:
    shares = qmc.LatinHypercube(len(RANGES) + 2, rng=rng).random(count)
    for i, (of_force, of_pull, *others) in enumerate(shares):
        pull = _between(PULL if within else PULL_BELOW_FORCE, of_pull)
        force = _between((FORCE[0], min(pull, FORCE[1])) if within else (pull, FORCE[1]), of_force)
        values = (_between(ends, share) for ends, share in zip(RANGES.values(), others, strict=True))
        yield StressCase(tuple(MODES)[i % len(MODES)], force, *values, pull)


def _between(ends: tuple[float, float], share: float) -> float:
    """Even in the logarithm, to four digits."""
    return float(f"{ends[0] * (ends[1] / ends[0]) ** share:.4g}")


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
    tip = rig.response_point
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
    """limit: of processor time [s], of the curve and of each check"""
    started = time.process_time()
    system, request = system_of(case, reduced)
    curve = _traced(system, request, limit)
    outcome = _outcome(case, request, curve, time.process_time() - started, limit)
    if not outcome.complete:
        return outcome
    other = _traced(system, replace(request, upwards=False), limit)
    checks = {"other end": 1e3 * other.peak(request.points[0])[1] if len(other) else None}
    checks["followed in force"] = _followed(system, request, limit)
    return replace(outcome, checks={name: peak for name, peak in checks.items() if peak is not None})


def _traced(system: NonlinearSystem, request: CurveRequest, limit: float) -> ResponseCurve:
    """As far as the processor time goes [s]."""
    started = time.process_time()
    for curve in trace(system, request):
        if curve.complete or curve.stopped or time.process_time() - started > limit:
            break
    return curve


def _followed(system: NonlinearSystem, request: CurveRequest, limit: float) -> float | None:
    """Highest receptance [mm/N] of the resonances at the request's force within its window, None where none was met."""
    started, (point,) = time.process_time(), request.points
    excited = next(name for name in system.free.points if system.free.row(name) == request.excitation.row)
    forces = (min(0.01, request.excitation.force / 2), request.excitation.force)
    asked = ResonanceRequest(request.mode, excited, point, request.window, forces, PhaseResonance())
    curve = None
    try:
        for curve in trace_resonance(system, asked):
            if curve.complete or curve.stopped or time.process_time() - started > limit:
                break
    except ValueError:  # no mode of the stuck structure lies in the window
        return None
    if curve is None or not len(curve):
        return None
    low, high = request.window
    met = np.isclose(curve.force, forces[1]) & (curve.frequency > low) & (curve.frequency < high)
    return 1e3 * float(np.abs(curve.receptance[met]).max()) if met.any() else None


def _outcome(case: StressCase, request: CurveRequest, curve: ResponseCurve, seconds: float, limit: float) -> Outcome:
    reason = curve.stopped
    if not curve.complete and not reason:
        at = f"{curve.frequency[-1]:.2f} Hz" if len(curve) else "the first point"
        reason = f"time: {limit:g} s were not enough; {len(curve)} points, at {at}"
    points, gaps = len(curve), int(curve.after_gap.sum())
    frequency, peak = curve.peak(request.points[0]) if points else (np.nan, np.nan)
    iterations = int(curve.iterations.sum())
    return Outcome(
        case, curve.complete, reason, request.window, points, gaps, iterations, round(seconds, 2), 1e3 * peak, frequency
    )


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
    """Cases not on file, and with `again` those that are not complete."""
    return [case for case in cases if case not in known or (again and not known[case].complete)]


def summary(outcomes: Iterable[Outcome]) -> dict[str, Any]:
    outcomes = list(outcomes)
    missing = [{**asdict(o.case), "reason": o.reason} for o in outcomes if not o.complete]
    wrong = [{**asdict(o.case), "peak_mm_per_N": o.peak_mm_per_N, "checks": o.checks} for o in outcomes if o.false_peak]
    return {
        "within_pull": _counts([o for o in outcomes if o.case.within_pull]),
        "beyond_pull": _counts([o for o in outcomes if not o.case.within_pull]),
        "not_complete": missing,
        "false_peaks": wrong,
    }


def _counts(outcomes: Sequence[Outcome]) -> dict[str, int]:
    return {
        "curves": len(outcomes),
        "complete": sum(o.complete for o in outcomes),
        "checked": sum(len(o.checks) > 0 for o in outcomes),
        "false_peaks": sum(o.false_peak for o in outcomes),
    }


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
    limit: Annotated[float, typer.Option(help="processor time a curve [s], and a check")] = 120.0,
    again: Annotated[bool, typer.Option(help="trace once more what is not complete")] = False,
    fresh: Annotated[bool, typer.Option(help="forget what is on file")] = False,
    out: Annotated[Path, typer.Option(help="folder of stress.json and stress.jsonl")] = ROOT / "results",
) -> None:
    """Trace the curves, write the results, print how many are complete and the reasons of the others."""
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
                failed = sum(not known[case].complete for case in cases if case in known)
                progress.update(bar, advance=1, description=f"curves ({failed} not complete)")
    outcomes = [known[case] for case in cases]
    (out / "stress.json").write_text(json.dumps(summary(outcomes), indent=2) + "\n")
    show(console, outcomes)


def show(console: Console, outcomes: Sequence[Outcome]) -> None:
    found = summary(outcomes)
    for name in ("within_pull", "beyond_pull"):
        n = found[name]
        console.print(
            f"force {name.replace('_', ' the ')}: {n['complete']} of {n['curves']} curves complete, "
            f"{n['checked']} checked, {n['false_peaks']} false peaks"
        )
    seconds = sorted(o.seconds for o in outcomes)
    console.print(f"processor time a curve: median {seconds[len(seconds) // 2]:.1f} s, longest {seconds[-1]:.0f} s")
    if not (found["not_complete"] or found["false_peaks"]):
        return
    table = Table("mode", "force", *RANGES, "pull", "reason", show_lines=False)
    for outcome in outcomes:
        if not outcome.complete or outcome.false_peak:
            mode, *values = asdict(outcome.case).values()
            seen = ", ".join(f"{name}: {peak:.5g}" for name, peak in outcome.checks.items())
            reason = outcome.reason or f"peak {outcome.peak_mm_per_N:.5g} mm/N, but {seen}"
            table.add_row(mode, *(f"{v:.3g}" for v in values), reason)
    console.print(table)


if __name__ == "__main__":
    typer.run(main)
