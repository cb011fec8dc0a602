"""A study at work: designs chosen by the method, solved by workers, each kept as soon as it is there."""

import hashlib
import json
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import Any

from pydantic_core import to_json

from updamp.design.evaluate import Asked, Task, evaluate
from updamp.design.methods.method import MethodResult, Problem
from updamp.design.records import Record, RecordFolder, alone_in
from updamp.design.rig_numbers import AnyRig
from updamp.design.solved_design import DesignInput, SolvedDesign
from updamp.design.study_file import DesignStudy
from updamp.design.tracked_modes import ModeReference, mode_references
from updamp.design.variables import Values, Variable, overrides
from updamp.model.rig_files import load_any
from updamp.parallel.ending import heard
from updamp.parallel.processes import chosen_workers
from updamp.parallel.workers import Workers
from updamp.rig.toml_file import read_toml
from updamp.workflow import stages
from updamp.workflow.progress import Display
from updamp.workflow.rig_text import moved

VERSION = 1  # to be raised whenever a response means something else than before
_BAR = "designs"
_ROUND_OFF = 1e-9  # of a range: values are written to twelve digits


@dataclass(frozen=True)
class StudyFolder:
    """What a study writes: rig.toml, designs/, stages/, tables, study.json, the page."""

    path: Path

    @property
    def rig(self) -> Path:
        return self.path / "rig.toml"

    @property
    def designs(self) -> Path:
        return self.path / "designs"

    @property
    def stages(self) -> Path:
        return self.path / "stages"


@dataclass(frozen=True)
class StudyResult:
    """records: of all designs of this study, earlier sessions included; others: how many the folder holds besides, of
    another rig, mesh or set of responses, or beyond the bounds; setup: what its records have in common
    method: None where the study was interrupted"""

    study: DesignStudy
    folder: StudyFolder
    rig: AnyRig
    references: tuple[ModeReference, ...]
    records: tuple[Record, ...]
    others: int
    setup: str
    method: MethodResult | None


@dataclass(eq=False)
class Evaluations:
    """The `Evaluate` of a study: takes known designs from their records, has the others solved, keeps them at once."""

    task: Task
    stated: Mapping[str, Any]
    study: DesignStudy
    records: RecordFolder
    workers: Workers
    display: Display
    solved: int = 0
    _named: set[str] = field(default_factory=set)

    def __call__(self, designs: Sequence[Values], expected: int | None = None) -> list[Record]:
        asked = [self._asked(values) for values in designs]
        for one in asked:  # numbers count designs in the order in which the method names them
            self.records.number(one.key)
        self._named.update(one.key for one in asked)
        fresh = {one.key: one for one in asked if self.records.find(one.key) is None}
        missing, total = list(fresh.values()), expected or len(self._named)
        self._show(total)

        def keep(_: int, record: Record) -> None:
            kept = self.records.add(record)
            self.solved += 1
            if kept.outcome in ("failed", "error"):
                self.display.note(f"design {kept.number}", kept.reason)
            self._show(total)

        new = dict(zip(fresh, self.workers(evaluate, self.task, missing, keep), strict=True))
        return [self.records.find(one.key) or new[one.key] for one in asked]

    def _asked(self, values: Values) -> Asked:
        changes = overrides(self.stated, self.study.variables, values)
        key = _hash(self.task.setup, {one.name: values[one.name] for one in self.study.variables})
        return Asked(values, changes, key)

    def _show(self, total: int) -> None:
        known = len(self.records.of_setup(self.task.setup))
        self.display.update(
            _BAR, min(known / max(total, 1), 1.0), f"{known} of {total} known, {self.solved} solved now"
        )


def run_study(study: DesignStudy, out: Path, jobs: int, scheduler: str, display: Display) -> StudyResult:
    """Solve what is not known yet.

    raises: RigError, ValueError for a study that the rig has no place for, or where another process is at work in the
        folder; KeyboardInterrupt is passed on only before the first design: later ones are in their records, and the
        result says that the method has not ended
    """
    folder = StudyFolder(out.resolve())
    with alone_in(folder.path):
        return _run(study, folder, jobs, scheduler, display)


def _run(study: DesignStudy, folder: StudyFolder, jobs: int, scheduler: str, display: Display) -> StudyResult:
    rig = own_copy(study.rig, folder.rig)
    given = DesignInput(folder.rig, {}, study.mesh, folder.stages, (), _peaks(study), study.most_points)
    references = _references(study, rig, given, display)
    given = replace(given, references=references)
    task = Task(given, study.responses, _setup(study, rig))
    records = RecordFolder(folder.designs)
    stated, own = read_toml(folder.rig, "a rig file"), tuple(e.file for e in rig.effects if e.file is not None)
    result: MethodResult | None = None
    interrupted: KeyboardInterrupt | None = None
    try:
        with chosen_workers(jobs, scheduler, own) as workers:
            result = study.method.run(
                _problem(study, folder, task.setup), Evaluations(task, stated, study, records, workers, display)
            )
    except KeyboardInterrupt as stop:
        heard()
        interrupted = stop
    found = tuple(record for record in records.of_setup(task.setup) if _within_bounds(study, record))
    if interrupted is not None and not found:
        raise interrupted
    display.done(_BAR, f"{len(found)} known")
    others = len(records) - len(found)
    return StudyResult(study, folder, rig, references, found, others, task.setup, result)


def _within_bounds(study: DesignStudy, record: Record) -> bool:
    """Bounds may have been narrowed since."""

    def within(one: Variable) -> bool:
        spare, value = _ROUND_OFF * (one.upper - one.lower), record.values[one.name]
        return one.lower - spare <= value <= one.upper + spare

    return all(within(one) for one in study.variables)


def _problem(study: DesignStudy, folder: StudyFolder, setup: str) -> Problem:
    """Other goals or bounds are another search."""
    names = tuple(one.name for one in study.responses)
    goals = [(one.response, one.goal.words) for one in study.objectives]
    limits = [repr(one) for one in (*study.constraints, *study.variables)]
    key = _hash(setup, goals, limits)
    return Problem(study.name, study.variables, names, study.objectives, study.constraints, folder.path, key)


def own_copy(rig: Path, copy: Path) -> AnyRig:
    """The rig file as it is now, in the study's folder: what becomes of it meanwhile is not seen."""
    copy.parent.mkdir(parents=True, exist_ok=True)
    text = moved(rig.read_text(encoding="utf-8"), rig.parent, copy.parent)
    if not copy.is_file() or copy.read_text(encoding="utf-8") != text:
        temporary = copy.with_suffix(".tmp")
        temporary.write_text(text, encoding="utf-8")
        temporary.replace(copy)
    return load_any(copy)


def _peaks(study: DesignStudy) -> tuple[Any, ...]:
    return tuple(dict.fromkeys(peak for one in study.responses for peak in one.peaks()))


def _references(study: DesignStudy, rig: AnyRig, given: DesignInput, display: Display) -> tuple[ModeReference, ...]:
    """Of the modes that responses name, in the rig as its file stands."""
    named = {mode for one in study.responses for mode in one.modes()}
    if not named:
        return ()
    with display.stage("rig as it stands"):
        windows = {name: window for name, window in rig.windows.items() if name in named}
        model = SolvedDesign(given).model
        _refuse_unknown_points(study, model.free.points)
        return mode_references(model, windows, rig.response_point)


def _refuse_unknown_points(study: DesignStudy, known: Sequence[str]) -> None:
    for one in study.responses:
        for point in (peak.point for peak in one.peaks()):
            if point and point not in known:
                raise ValueError(f'response {one.name}: point = "{point}": the rig has {", ".join(known)}')


def _setup(study: DesignStudy, rig: AnyRig) -> str:
    """What all designs share: the rig as it is read, the mesh, responses, variables, and versions of what computes."""
    versions = {stage.name: stage.version for stage in stages.STAGES}
    responses = [(type(one).__name__, json.loads(one.model_dump_json())) for one in study.responses]
    places = [(one.name, one.path, one.unit) for one in study.variables]
    given_up = [] if study.most_points is None else [study.most_points]
    return _hash(VERSION, json.loads(to_json(rig)), study.mesh, versions, responses, places, *given_up)


def _hash(*parts: Any) -> str:
    return hashlib.sha256(json.dumps(parts, sort_keys=True).encode()).hexdigest()
