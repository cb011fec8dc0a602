"""Work through tasks, in this process or in several, with a bar that shows how far it is."""

from collections.abc import Callable, Iterator, Sequence
from concurrent.futures import ProcessPoolExecutor, as_completed
from multiprocessing import get_context
from typing import Protocol, TypeVar

from updamp.workflow.progress import Display

Result = TypeVar("Result")


class Named(Protocol):
    @property
    def name(self) -> str: ...


Task = TypeVar("Task", bound=Named)


def in_turn(
    work: Callable[[Task], Result], tasks: Sequence[Task], jobs: int, title: str, summary: Callable[[Result], str]
) -> list[Result]:
    """work: of a task, able to go to another process; summary: the line for its result, which must not tell the truth

    Results come in the order in which they are finished. A task that fails is shown, and the others go on.
    raises: RuntimeError at the end naming those that failed
    """
    finished: list[Result] = []
    failed: list[str] = []
    with Display() as display:
        display.update(title, 0.0, f"0 of {len(tasks)}")
        for done, (task, outcome) in enumerate(_outcomes(work, tasks, jobs), 1):
            if isinstance(outcome, Exception):
                failed.append(f"{task.name}: {type(outcome).__name__}: {outcome}")
                display.failed(task.name, f"{type(outcome).__name__}: {outcome}")
            else:
                finished.append(outcome)
                display.done(task.name, summary(outcome))
            display.update(title, done / len(tasks), f"{done} of {len(tasks)}")
        display.done(title, f"{len(finished)} of {len(tasks)}")
    if failed:
        raise RuntimeError("failed; the same command tries them again: " + "; ".join(failed))
    return finished


def _outcomes(
    work: Callable[[Task], Result], tasks: Sequence[Task], jobs: int
) -> Iterator[tuple[Task, Result | Exception]]:
    if jobs == 1:
        for task in tasks:
            try:
                outcome: Result | Exception = work(task)
            except Exception as error:  # whatever a task stumbles over must not stop the others
                outcome = error
            yield task, outcome
        return
    with ProcessPoolExecutor(jobs, mp_context=get_context("spawn")) as pool:
        futures = {pool.submit(work, task): task for task in tasks}
        for future in as_completed(futures):
            error = future.exception()
            if error is not None and not isinstance(error, Exception):
                raise error
            yield futures[future], error if error is not None else future.result()
