"""A parameter study at work: stages that variants share, then the curves that are not there yet, in order."""

import time
from collections.abc import Collection, Mapping
from dataclasses import dataclass, field
from pathlib import Path

from updamp.design.run_study import own_copy
from updamp.design.solved_design import DesignInput, SolvedDesign
from updamp.design.tracked_modes import mode_references
from updamp.hbm.continuation.response_curve import ResponseCurve
from updamp.parallel.ending import heard
from updamp.parameter_study.families import CurveName, ParameterStudy, StudyCurveJob, in_study
from updamp.parameter_study.mode_peak import window_of_mode
from updamp.parameter_study.solved_study import SolvedStudy
from updamp.rig.rig import Rig
from updamp.workflow import store
from updamp.workflow.job_pool import Job, JobEnd, JobOutcome, JobProgress, run_all
from updamp.workflow.products import stored
from updamp.workflow.progress import Display

_BAR = "curves"
NOT_TRACED = "not traced yet"


@dataclass(frozen=True)
class StudyRun:
    """result: as far as it is solved; interrupted: whether curves are left to be traced"""

    result: SolvedStudy
    interrupted: bool


@dataclass(eq=False)
class _Tracing:
    """The bars of curves at work, and of all of them together."""

    display: Display
    total: int
    known: int
    failures: dict[str, str] = field(default_factory=dict)

    def show(self) -> None:
        self.display.update(_BAR, self.known / max(self.total, 1), f"{self.known} of {self.total} known")

    def on_progress(self, job: Job, progress: JobProgress) -> None:
        self.display.update(job.name, progress.share, progress.detail)

    def on_end(self, outcome: JobOutcome) -> None:
        job, finished = outcome.job, outcome.end is JobEnd.FINISHED
        well, sentence = job.conclusion() if finished else (False, outcome.message or outcome.end.value)
        (self.display.done if well else self.display.failed)(job.name, sentence)
        self.known += finished
        if outcome.end is JobEnd.FAILED:
            self.failures[job.key] = outcome.message
        self.show()


def run_parameter_study(study: ParameterStudy, out: Path, jobs: int, display: Display, solve: bool = True) -> StudyRun:
    """Trace what is not known yet.

    solve: whether to trace curves; without, what is there is taken
    raises: RigError where the rig file cannot be read; ValueError where the rig has no mode in a window; what the
        stages of the rig as it stands raise. What fails of a variant alone is the reason why its curves are missing
    """
    started, out = time.perf_counter(), out.resolve()
    rig = own_copy(study.rig, out / "rig.toml")  # a record; files that variants name are sought beside the rig file
    assert isinstance(rig, Rig), "checked when the study was read"
    variants = _variants(study, rig, out, display)
    named = tuple(dict.fromkeys(name for family in study.families for name in family.curves()))
    prepared, missing = _prepared(named, variants, display)
    tracing = _Tracing(display, len(named), sum(map(_is_there, prepared.values())))
    tracing.show()
    interrupted = _trace(prepared, jobs, tracing) if solve else False
    curves = {name: curve for name, job in prepared.items() if (curve := _there(job)) is not None}
    for name, job in prepared.items():
        if name not in curves:
            missing[name] = tracing.failures.get(job.key, NOT_TRACED)
    display.done(_BAR, counted(curves.values(), len(named)))
    seconds = time.perf_counter() - started
    return StudyRun(SolvedStudy(study, out, rig, variants, curves, missing, seconds), interrupted)


def counted(curves: Collection[ResponseCurve], total: int) -> str:
    """How many of the study's curves there are, and how many of these are the whole branch through their window."""
    complete = sum(curve.complete for curve in curves)
    reasons = "; study.html has the reasons of the others" if complete < total else ""
    return f"{len(curves)} of {total} known, {complete} of them complete{reasons}"


def _variants(study: ParameterStudy, rig: Rig, out: Path, display: Display) -> dict[str, SolvedDesign]:
    store = out / "stages"
    with display.stage("rig as it stands"):
        model = SolvedDesign(DesignInput(study.rig, {}, study.mesh, store)).model
        used = {mode for family in study.families for mode in family.modes}
        windows = {mode: window for mode, window in rig.windows.items() if mode in used}
        references = mode_references(model, windows, rig.response_point)
    return {
        one.name: SolvedDesign(DesignInput(study.rig, one.changes, study.mesh, store, references))
        for one in study.variants
    }


def _prepared(
    named: tuple[CurveName, ...], variants: Mapping[str, SolvedDesign], display: Display
) -> tuple[dict[CurveName, StudyCurveJob], dict[CurveName, str]]:
    """Jobs, with their stages before made; and why there is none for the other curves."""
    prepared, missing = {}, {}
    windows: dict[tuple[str, str], tuple[float, float]] = {}
    with display.stage("variants") as update:
        for place, name in enumerate(named):
            update(place / len(named), name.label)
            try:
                design, key = variants[name.variant], (name.variant, name.mode)
                if key not in windows:
                    windows[key] = window_of_mode(design, name.mode)
                job = design.curve_job(name.mode, name.force, windows[key])
                prepared[name] = in_study(job, name.variant, place)
            except (ValueError, RuntimeError) as error:  # the project's own, each with a sentence
                missing[name] = str(error)
    for variant, reason in dict.fromkeys((name.variant, reason) for name, reason in missing.items()):
        display.note(variant, reason)
    return prepared, missing


def _trace(prepared: Mapping[CurveName, StudyCurveJob], jobs: int, tracing: _Tracing) -> bool:
    """Returns: whether it was interrupted"""
    once: dict[str, StudyCurveJob] = {}  # two variants may be the same rig
    for job in prepared.values():
        if not _is_there(job):
            once.setdefault(job.key, job)
    if not once:
        return False
    try:
        run_all(list(once.values()), min(jobs, len(once)), tracing.on_progress, tracing.on_end)
    except KeyboardInterrupt:
        heard()
        return True
    return False


def _is_there(job: StudyCurveJob) -> bool:
    try:
        return store.read_stamp(job.output).key == job.key
    except store.StoreError:
        return False


def _there(job: StudyCurveJob) -> ResponseCurve | None:
    found = stored(job.output, ResponseCurve, job.key)
    return found.product if found is not None else None
