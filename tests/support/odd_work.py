"""Work for other processes to import: pieces and branches that take long, fail, or are killed."""

import os
import signal
import sys
import time
from dataclasses import dataclass
from types import SimpleNamespace

from updamp.comparison.prediction.branch_tasks import by_processes


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
    return [name for name in sys.modules if name.startswith("updamp_user_effect")]


@dataclass(frozen=True)
class Slow:
    name: str
    effort: float = 1.0

    @property
    def condition(self) -> SimpleNamespace:
        return SimpleNamespace(name=self.name)

    def predicted(self) -> int:
        # in one piece: print writes the end of the line by itself, and two processes mix theirs
        os.write(1, b"begun\n")
        time.sleep(600)
        return os.getpid()


class Killed(Slow):
    def predicted(self) -> int:
        os.kill(os.getpid(), signal.SIGKILL)
        raise AssertionError


def wait_for_two() -> None:
    """What a comparison does while two branches are traced."""
    with by_processes(2) as branches:
        branches([Slow("a"), Slow("b")])


if __name__ == "__main__":
    # started in the background it would inherit that it takes no notice
    signal.signal(signal.SIGINT, signal.default_int_handler)
    sys.exit(wait_for_two())
