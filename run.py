"""One run: the stages in order, each taken from its file where nothing that goes into it has changed."""

from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass, field
from functools import cached_property
from pathlib import Path
from typing import Any, Generic, TypeVar

from updamp import stages, store
from updamp.curve_jobs import CurveEnd, CurveJob, CurveOutcome, trace_all
from updamp.progress import Display, Update
from updamp.resources import Meter
from updamp.rig import Rig
from updamp.stages import Stage

Product = TypeVar("Product")


@dataclass(frozen=True)
class RunOptions:
    """preset: of the mesh; folder: for all that the run writes; workers: processes that trace curves

    modes, forces: which curves [N]; empty for all of the study
    check: whether to compare the reduced with the full coupled model; until: last stage, None for all
    raises: ValueError naming the option that is out of range
    """

    preset: str
    folder: Path
    workers: int = 1
    modes: tuple[str, ...] = ()
    forces: tuple[float, ...] = ()
    check: bool = True
    pictures: bool = True
    until: Stage | None = None

    def __post_init__(self) -> None:
        if self.workers < 1:
            raise ValueError(f"jobs = {self.workers}: at least 1")


@dataclass(frozen=True, eq=False)
class Stored(Generic[Product]):
    """A stage's product with its file, key and cost."""

    path: Path
    product: Product
    stamp: store.Stamp


@dataclass(eq=False)
class Run:
    """What a run has at hand. `executed` names the stages and curves that were computed, not taken from files."""

    rig: Rig
    options: RunOptions
    display: Display
    executed: list[str] = field(default_factory=list)

    def __post_init__(self) -> None:
        _check_names("--mesh", (self.options.preset,), self.rig.mesh)
        _check_names("--mode", self.options.modes, self.rig.study.modes)

    @property
    def files(self) -> Path:
        """Folder of the stage products."""
        return self.options.folder / "stages"

    def key(self, stage: Stage, mode: str = "", force: float = 0.0) -> str:
        return stage.key(self.rig, {"preset": self.options.preset, "mode": mode, "force": repr(force)})

    def wanted(self, stage: Stage) -> bool:
        """Whether the run goes as far as this stage."""
        last = self.options.until
        return last is None or stages.STAGES.index(stage) <= stages.STAGES.index(last)

    def obtain(
        self,
        stage: Stage,
        kind: type[Product],
        compute: Callable[[Update], tuple[Product, Mapping[str, float]]],
    ) -> Stored[Product]:
        """The stage's product from its file if that fits, else computed and stored.

        compute: takes a callback for progress; returns the product and the wall time of its parts [s], by name
        """
        path, key = self.files / f"{stage.name}.h5", self.key(stage)
        if (found := stored(path, kind, key)) is not None:
            self.display.unchanged(stage.name)
            return found
        with Meter() as meter, self.display.stage(stage.name) as update:
            product, seconds = compute(update)
        self.executed.append(stage.name)
        stamp = store.Stamp(key, seconds or {stage.name: meter.seconds}, (meter.interval,), meter.peak_memory)
        store.write(path, product, stamp)
        return Stored(path, product, stamp)


def stored(path: Path, kind: type[Product], key: str) -> Stored[Product] | None:
    """What the file holds if it was made with this key; a file that is missing or damaged counts as stale."""
    try:
        stamp = store.read_stamp(path)
        return Stored(path, store.read(path, kind), stamp) if stamp.key == key else None
    except store.StoreError:
        return None


def _check_names(option: str, given: Iterable[str], known: Iterable[str]) -> None:
    for name in given:
        if name not in known:
            raise ValueError(f"{option} {name}: the rig file has {', '.join(known)}")
