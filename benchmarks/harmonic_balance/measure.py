"""What harmonic balance costs: seconds of an evaluation, seconds and iterations of a point of a branch."""

import time
from collections.abc import Callable, Iterable, Iterator
from concurrent.futures import ProcessPoolExecutor
from contextlib import contextmanager
from dataclasses import dataclass
from multiprocessing import get_context
from typing import Any, ParamSpec, TypeVar
from unittest.mock import patch

import numpy as np

from updamp.hbm.continuation.branch import BranchPoint
from updamp.hbm.continuation.continuation import BranchStoppedError, ContinuationOptions, continue_branch
from updamp.hbm.newton import active_forces, newton
from updamp.hbm.newton.krylov import gmres
from updamp.hbm.problem.system import Excitation, NonlinearSystem
from updamp.parallel.resources import environment, thread_limits

Item = TypeVar("Item")


@dataclass
class Counts:
    """evaluations of the residual with tangents; Krylov solves and the products with the operator they took"""

    evaluations: int = 0
    krylov_solves: int = 0
    krylov_iterations: int = 0


@dataclass(frozen=True)
class Cost:
    """Of one residual with the Jacobian's tangents, and of one converged point (medians); seconds of processor time.

    evaluation_s: at the point of the branch with most active rows
    mean_point_s: all that was spent on the branch, failed correctors too, over its points
    newton, krylov, evaluations: iterations a point, medians and means over the branch
    active_rows: most on the branch; stopped: why the branch ended early, "" if it did not
    """

    evaluation_s: float
    evaluation_wall_s: float
    point_s: float
    point_wall_s: float
    mean_point_s: float
    points: int
    newton_median: float
    newton_mean: float
    krylov_mean: float
    evaluations_mean: float
    unknowns: int
    active_rows: int
    solver: str
    stopped: str


def branch_cost(
    system: NonlinearSystem,
    excitation: Excitation,
    window: tuple[float, float],
    repeats: int = 21,
    max_points: int = 1500,
) -> Cost:
    """Continue the branch through `window` [Hz] and take its measure; what compiles is compiled before."""
    next(continue_branch(system, excitation, window))
    options = ContinuationOptions(max_points=max_points)
    found: list[tuple[BranchPoint, float, float]] = []
    stopped = ""
    with counting() as counts:
        try:
            found.extend(clocked(continue_branch(system, excitation, window, options)))
        except BranchStoppedError as stop:
            stopped = str(stop)
    points = [point for point, _, _ in found]
    active = [_jacobian(point).n_active for point in points]
    busiest = points[int(np.argmax(active))]
    evaluation = evaluation_seconds(system, excitation, busiest, repeats)
    seconds = np.array([(processor, wall) for _, processor, wall in found])
    iterations = [point.solution.iterations for point in points]
    return Cost(
        *evaluation,
        point_s=float(np.median(seconds[:, 0])),
        point_wall_s=float(np.median(seconds[:, 1])),
        mean_point_s=float(seconds[:, 0].mean()),
        points=len(points),
        newton_median=float(np.median(iterations)),
        newton_mean=float(np.mean(iterations)),
        krylov_mean=counts.krylov_iterations / len(points),
        evaluations_mean=counts.evaluations / len(points),
        unknowns=busiest.x.size,
        active_rows=max(active),
        solver=type(_jacobian(busiest).forces).__name__,
        stopped=stopped,
    )


def evaluation_seconds(
    system: NonlinearSystem, excitation: Excitation, point: BranchPoint, repeats: int
) -> tuple[float, float]:
    """Median processor and wall seconds of one residual with its Jacobian, factorised where it is one to factorise."""

    def work() -> None:
        equation = newton.evaluate(system, excitation, point.x, point.w)
        equation.factorised()

    work()
    seconds = [stopwatch(work) for _ in range(repeats)]
    processor, wall = np.median(seconds, axis=0)
    return float(processor), float(wall)


def stopwatch(work: Callable[[], object]) -> tuple[float, float]:
    """Processor and wall seconds of a call."""
    processor, wall = time.process_time(), time.perf_counter()
    work()
    return time.process_time() - processor, time.perf_counter() - wall


def clocked(items: Iterable[Item]) -> Iterator[tuple[Item, float, float]]:
    """Each item with the processor and wall seconds it took to come."""
    processor, wall = time.process_time(), time.perf_counter()
    for item in items:
        yield item, time.process_time() - processor, time.perf_counter() - wall
        processor, wall = time.process_time(), time.perf_counter()


@contextmanager
def counting() -> Iterator[Counts]:
    """Counts what Newton's method does in this process."""
    counts, evaluate = Counts(), newton.evaluate

    def counted_evaluate(*args: Any, **options: Any) -> Any:
        counts.evaluations += 1
        return evaluate(*args, **options)

    def counted_gmres(*args: Any, **options: Any) -> Any:
        found = gmres(*args, **options)
        counts.krylov_solves += 1
        counts.krylov_iterations += found.iterations
        return found

    with (
        patch.object(newton, "evaluate", counted_evaluate),
        patch.object(active_forces, "gmres", counted_gmres),
    ):
        yield counts


def _jacobian(point: BranchPoint) -> Any:
    assert point.solution.jacobian is not None, "a converged solution carries its Jacobian"
    return point.solution.jacobian


# Run a measurement in a process of its own that has so many threads and no more.

Arguments = ParamSpec("Arguments")
Result = TypeVar("Result")


def in_a_process(
    threads: int, function: Callable[Arguments, Result], *args: Arguments.args, **options: Arguments.kwargs
) -> Result:
    """function(*args, **options), computed in a fresh process with so many threads."""
    with environment(thread_limits(threads)), ProcessPoolExecutor(1, mp_context=get_context("spawn")) as pool:
        return pool.submit(function, *args, **options).result()
