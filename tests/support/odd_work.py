"""Pieces of work for other processes to import: one that can be slow, one that fails, one that is killed."""

import os
import signal
import time


def slow_first(shared: float, item: int) -> tuple[int, int]:
    """The item, and the process that did it."""
    time.sleep(shared if item == 0 else 0.0)
    return item, os.getpid()


def fails(_: None, item: int) -> int:
    if item == 1:
        raise ValueError("the second one fails")
    return item


def killed(_: None, item: int) -> int:
    os.kill(os.getpid(), signal.SIGKILL)
    return item


def has_read(_: None, __: int) -> list[str]:
    """Names of modules of users' effects."""
    import sys

    return [name for name in sys.modules if name.startswith("updamp_user_effect")]
