"""What jobs share that say something about a traced curve: which one, where the answer goes, and what it is called."""

from dataclasses import dataclass
from pathlib import Path
from typing import Any, ClassVar

from updamp.parallel.resources import Meter
from updamp.workflow import store
from updamp.workflow.curve_jobs import CurveJob


@dataclass(frozen=True)
class JobAboutCurve:
    """Of the curve that `curve` leaves.

    point: where the peak is taken
    key: of what is found; output: its file
    about: what is said of the curve, for the job's name; part: the name of the work in what a run cost
    """

    curve: CurveJob
    point: str
    key: str
    output: Path
    about: ClassVar[str]
    part: ClassVar[str]

    @property
    def name(self) -> str:
        return f"{self.curve.name}, {self.about}"

    @property
    def ease(self) -> tuple[float, ...]:
        return self.curve.ease

    def keep(self, found: Any, meter: Meter) -> None:
        """Store what was found, with what it cost. raises: DiskError"""
        stamp = store.Stamp(self.key, {self.part: meter.seconds}, (meter.interval,), meter.peak_memory)
        store.write(self.output, found, stamp)
