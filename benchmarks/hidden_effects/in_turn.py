"""Work through cases, in this process or in several, with a bar that shows how far it is."""

from collections.abc import Callable, Iterator, Sequence
from concurrent.futures import ProcessPoolExecutor, as_completed
from multiprocessing import get_context
from typing import TypeVar

from hidden_effects.cases import Case

from updamp.progress import Display

Result = TypeVar("Result")


def in_turn(
    work: Callable[[Case], Result], cases: Sequence[Case], jobs: int, title: str, shown: Callable[[Result], str]
) -> list[Result]:
    """work: of a case, able to go to another process; shown: the line for its result, which must not tell the truth

    Results come in the order in which they are finished. A case that fails is shown, and the others go on.
    raises: RuntimeError at the end naming those that failed
    """
    finished: list[Result] = []
    failed: list[str] = []
    with Display() as display:
        display.update(title, 0.0, f"0 of {len(cases)}")
        for done, (case, outcome) in enumerate(_outcomes(work, cases, jobs), 1):
            if isinstance(outcome, Exception):
                failed.append(f"{case.name}: {type(outcome).__name__}: {outcome}")
                display.failed(case.name, f"{type(outcome).__name__}: {outcome}")
            else:
                finished.append(outcome)
                display.done(case.name, shown(outcome))
            display.update(title, done / len(cases), f"{done} of {len(cases)}")
        display.done(title, f"{len(finished)} of {len(cases)}")
    if failed:
        raise RuntimeError("failed; the same command tries them again: " + "; ".join(failed))
    return finished


def _outcomes(
    work: Callable[[Case], Result], cases: Sequence[Case], jobs: int
) -> Iterator[tuple[Case, Result | Exception]]:
    if jobs == 1:
        for case in cases:
            try:
                yield case, work(case)
            except Exception as error:  # whatever a case stumbles over must not stop the others
                yield case, error
        return
    with ProcessPoolExecutor(jobs, mp_context=get_context("spawn")) as pool:
        futures = {pool.submit(work, case): case for case in cases}
        for future in as_completed(futures):
            error = future.exception()
            if error is not None and not isinstance(error, Exception):
                raise error
            yield futures[future], error if error is not None else future.result()
