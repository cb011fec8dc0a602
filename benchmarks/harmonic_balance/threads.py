"""Run a measurement in a process of its own that has so many threads and no more."""

from collections.abc import Callable
from concurrent.futures import ProcessPoolExecutor
from multiprocessing import get_context
from typing import ParamSpec, TypeVar

from updamp.resources import environment, thread_limits

Arguments = ParamSpec("Arguments")
Result = TypeVar("Result")


def in_a_process(
    threads: int, function: Callable[Arguments, Result], *args: Arguments.args, **options: Arguments.kwargs
) -> Result:
    """function(*args, **options), computed in a fresh process with so many threads."""
    with environment(thread_limits(threads)), ProcessPoolExecutor(1, mp_context=get_context("spawn")) as pool:
        return pool.submit(function, *args, **options).result()
