"""A function for numba to compile and keep, in processes that begin together."""

from multiprocessing.synchronize import Barrier
from typing import Any

from updamp.hbm.contact.compiled.keeping import kept


def doubled(x: float) -> float:
    return 2 * x


def compile_it(together: Barrier, found: Any) -> None:
    """found: queue that gets how often it was compiled here, and how often read"""
    function = kept(doubled)
    together.wait()
    function(1.5)
    found.put((sum(function.stats.cache_misses.values()), sum(function.stats.cache_hits.values())))
