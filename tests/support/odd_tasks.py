"""Stand-ins for branches to be predicted, for other processes to import: one that takes long, one that is killed."""

import os
import signal
import sys
import time
from dataclasses import dataclass
from types import SimpleNamespace

from updamp.comparison.prediction.branch_tasks import by_processes


@dataclass(frozen=True)
class Slow:
    name: str
    effort: float = 1.0

    @property
    def condition(self) -> SimpleNamespace:
        return SimpleNamespace(name=self.name)

    def predicted(self) -> int:
        print("begun", flush=True)
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
