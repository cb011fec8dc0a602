"""Stages of many designs in one folder, each product under its own key: what two designs share is computed once.

The keys are those of a run (`workflow/stages.py`): a design that changes friction alone finds the finite elements of
any other one, and one that changes the damper alone the blade. A lock keeps two processes from computing the same
product at the same time.
"""

import fcntl
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from dataclasses import dataclass, field, replace
from itertools import count
from pathlib import Path
from typing import TypeVar

from updamp.design.solved_peak import FollowedPeaks, followed_peaks
from updamp.effects.rig_model import RigModel
from updamp.fem.finite_element_model import ComponentModel, FiniteElementResult, joined
from updamp.fem.rig_components import RigComponents
from updamp.fem.static_contact.rest_state import StaticContact
from updamp.geometry.rig_mesh import RigMesh
from updamp.hbm.continuation.response_curve import ResponseCurve
from updamp.hbm.resonance.resonance_curve import ResonanceRequest
from updamp.hbm.resonance.resonance_steps import ResonanceOptions
from updamp.parallel.resources import Meter
from updamp.rig.rig import Rig
from updamp.workflow import stages, store
from updamp.workflow.curve_jobs import CurveJob, traced
from updamp.workflow.job_pool import JobEnd
from updamp.workflow.products import stored
from updamp.workflow.stage_functions import StageFunctions
from updamp.workflow.stages import Stage

Product = TypeVar("Product")


@dataclass(eq=False)
class SharedStages:
    """Of one rig. folder: common to all designs; `executed` names the stages that were computed, not found.

    raises, from each stage: what it raises in a run: GeometryError, SolverFailedError and others, all with a sentence
    """

    rig: Rig
    preset: str
    folder: Path
    functions: StageFunctions = field(default_factory=StageFunctions)
    executed: list[str] = field(default_factory=list)

    def mesh(self) -> RigMesh:
        return self._obtain(stages.MESH, RigMesh, lambda: self.functions.mesh(self.rig, self.preset))

    def finite_elements(self) -> FiniteElementResult:
        def compute() -> FiniteElementResult:
            return joined(self._component(stages.BLADE), self._component(stages.DAMPER), self.mesh().contacts)

        return self._obtain(stages.FINITE_ELEMENTS, FiniteElementResult, compute)

    def _component(self, stage: Stage) -> ComponentModel:
        def compute() -> ComponentModel:
            with RigComponents(self.mesh(), self.rig) as parts:
                return self.functions.component(stage)(parts)

        return self._obtain(stage, ComponentModel, compute)

    def static_contact(self) -> StaticContact:
        def compute() -> StaticContact:
            return self.functions.static_contact(self.rig, self.finite_elements().reduced)

        return self._obtain(stages.STATIC_CONTACT, StaticContact, compute)

    def peaks(self, model: RigModel, request: ResonanceRequest) -> FollowedPeaks:
        """The resonance of a mode followed in the force, through its window in the rig; model: of the rig"""
        frequency = "" if request.mode_frequency is None else f"{request.mode_frequency:.9g}"
        options = request.options or ResonanceOptions()
        forces = " ".join(map(repr, request.forces))
        choice = {"point": request.point, "forces": forces, "frequency": frequency, "points": str(options.max_points)}
        key = stages.PEAKS.key(self.rig, {"preset": self.preset, "mode": request.mode, **choice})
        return self._kept(stages.PEAKS, key, FollowedPeaks, lambda: followed_peaks(model, request), f" {request.mode}")

    def curve(self, mode: str, force: float, most_points: int | None = None) -> ResponseCurve:
        """Through the mode's window in the rig [N].

        most_points: what takes more is given up: handed out as far as it is, and traced again when more are allowed
        """
        job = self.curve_job(mode, force)
        with _alone(job.output):
            if (found := stored(job.output, ResponseCurve, job.key)) is not None:
                return found.product
            self.static_contact()
            points = count(1)
            end, curve = traced(job, should_stop=lambda: most_points is not None and next(points) >= most_points)
            self.executed.append(f"{stages.CURVE.name} {mode} {force:g} N")
            return curve if end is JobEnd.FINISHED else replace(curve, stopped=given_up(len(curve)))

    def curve_job(self, mode: str, force: float) -> CurveJob:
        """What traces the curve [N], once the stages before are in their files."""
        key = self._key(stages.CURVE, mode, force)
        before = [self._file(s, self._key(s)) for s in (stages.FINITE_ELEMENTS, stages.STATIC_CONTACT)]
        return CurveJob(self.rig, mode, force, key, before[0], before[1], self._file(stages.CURVE, key))

    def _obtain(self, stage: Stage, kind: type[Product], compute: Callable[[], Product]) -> Product:
        return self._kept(stage, self._key(stage), kind, compute)

    def _kept(
        self, stage: Stage, key: str, kind: type[Product], compute: Callable[[], Product], of: str = ""
    ) -> Product:
        path = self._file(stage, key)
        with _alone(path):
            if (found := stored(path, kind, key)) is not None:
                return found.product
            with Meter() as meter:
                product = compute()
            self.executed.append(f"{stage.name}{of}")
            store.write(path, product, store.Stamp(key, {stage.name: meter.seconds}, (meter.interval,)))
            return product

    def _key(self, stage: Stage, mode: str = "", force: float = 0.0) -> str:
        return stage.key(self.rig, {"preset": self.preset, "mode": mode, "force": repr(force)})

    def _file(self, stage: Stage, key: str) -> Path:
        return self.folder / f"{stage.name}_{key[:24]}.h5"


def given_up(points: int) -> str:
    return f"it was given up after {points} points"


@contextmanager
def _alone(path: Path) -> Iterator[None]:
    """No other process of this machine computes the file meanwhile; the lock goes with the process that holds it."""
    lock_file = path.parent / ".locks" / path.name
    lock_file.parent.mkdir(parents=True, exist_ok=True)
    with lock_file.open("w") as lock:
        fcntl.flock(lock, fcntl.LOCK_EX)
        yield
