"""The rig of Pesaresi et al. (2017) with residual flexibility, from the stages of a run: a curve, and all ten."""

import time
from dataclasses import dataclass
from pathlib import Path
from tempfile import TemporaryDirectory

import numpy as np

from updamp.benchmarks.harmonic_balance.measure import clocked, counting, in_a_process
from updamp.hbm.continuation.curve import trace
from updamp.hbm.continuation.response_curve import ResponseCurve
from updamp.model.rig_files import load_rig
from updamp.rig.rig import Rig
from updamp.workflow import store
from updamp.workflow.curve_jobs import CurveJob, curve_problem
from updamp.workflow.job_pool import JobEnd, JobOutcome, run_all

RIG = Path(__file__).parents[2] / "rigs" / "pesaresi2017.toml"
MODE, FORCE = "OOP", 9.6  # of the curve whose points are timed


@dataclass(frozen=True)
class CurveCost:
    """Of one curve traced as `updamp run` does, energies and observed points included, in one thread.

    point_s: median processor seconds; mean_point_s: of all that was spent on the curve, over its points
    """

    mode: str
    force_N: float  # noqa: N815  units are written as they are printed
    point_s: float
    point_wall_s: float
    mean_point_s: float
    points: int
    newton_median: float
    krylov_mean: float
    evaluations_mean: float
    unknowns: int
    active_rows: int
    complete: bool
    stopped: str


@dataclass(frozen=True)
class AllCurves:
    """All curves of the study: wall time [s], from the first worker's start to the last curve's file.

    curves: name -> points, seconds in its worker, gaps, and why it is not complete ("" if it is)
    """

    seconds: float
    workers: int
    curves: dict[str, dict[str, float | int | str]]


def stages_of(run: Path) -> tuple[Path, Path] | None:
    """Files of the finite elements and of the static contact; None where the folder does not have them."""
    files = run / "stages" / "finite_elements.h5", run / "stages" / "static_contact.h5"
    return files if all(file.is_file() for file in files) else None


def jobs(stages: tuple[Path, Path], folder: Path, rig: Rig) -> tuple[CurveJob, ...]:
    """Every curve of the rig's study, largest force first, as a run orders them."""
    found = [
        CurveJob(rig, mode, force, "bench", *stages, folder / f"curve_{mode}_{force:g}N.h5")
        for mode in rig.study.modes
        for force in rig.study.force_levels
    ]
    return tuple(sorted(found, key=lambda job: -job.force))


def curve_cost(stages: tuple[Path, Path], rig: Rig, mode: str = MODE, force: float = FORCE) -> CurveCost:
    system, request = curve_problem(CurveJob(rig, mode, force, "bench", *stages, Path("not written")))
    next(trace(system, request))  # compiles
    seconds: list[tuple[float, float]] = []
    with counting() as counts:
        for curve, processor, wall in clocked(trace(system, request)):
            if len(curve) > len(seconds):  # the last one says only that the curve is complete
                seconds.append((processor, wall))
    point, point_wall = np.median(seconds, axis=0)
    return CurveCost(
        mode=mode,
        force_N=force,
        point_s=float(point),
        point_wall_s=float(point_wall),
        mean_point_s=sum(processor for processor, _ in seconds) / len(curve),
        points=len(curve),
        newton_median=float(np.median(curve.iterations)),
        krylov_mean=counts.krylov_iterations / len(curve),
        evaluations_mean=counts.evaluations / len(curve),
        unknowns=curve.displacement[0].size,
        active_rows=int(curve.active.max()),
        complete=curve.complete,
        stopped=curve.stopped,
    )


def all_curves(stages: tuple[Path, Path], rig: Rig, workers: int) -> AllCurves:
    """Traced anew in so many processes of one thread each, as `updamp run` does, in a folder that is thrown away."""
    with TemporaryDirectory() as folder:
        start = time.perf_counter()
        outcomes = run_all(jobs(stages, Path(folder), rig), workers, lambda *_: None, lambda _: None)
        seconds = time.perf_counter() - start
        return AllCurves(seconds, workers, {outcome.job.name: _account(outcome) for outcome in outcomes})


def _account(outcome: JobOutcome) -> dict[str, float | int | str]:
    if outcome.end is not JobEnd.FINISHED:
        return {"points": 0, "seconds": 0.0, "gaps": 0, "problem": outcome.message}
    curve = store.read(outcome.job.output, ResponseCurve)
    return {"points": len(curve), "seconds": curve.seconds, "gaps": len(curve.gaps()), "problem": curve.stopped}


def point_cost(stages: tuple[Path, Path]) -> CurveCost:
    """Of the curve whose points are timed, in a process of one thread."""
    return in_a_process(1, curve_cost, stages, load_rig(RIG))
