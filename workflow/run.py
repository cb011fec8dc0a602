"""One run: the stages in order, each taken from its file where nothing that goes into it has changed."""

from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import Any

from updamp.fem.finite_element_model import ComponentModel, CoupledCheck, FiniteElementResult, joined
from updamp.fem.rig_components import RigComponents
from updamp.fem.static_contact.rest_state import StaticContact
from updamp.geometry.rig_mesh import RigMesh
from updamp.parallel.resources import Meter
from updamp.rig.rig import Rig
from updamp.workflow import stages, store
from updamp.workflow.accuracy_jobs import AccuracyJob
from updamp.workflow.curve_jobs import CurveJob
from updamp.workflow.job_pool import Job, JobEnd, JobOutcome, JobProgress, run_all
from updamp.workflow.limits import check_size
from updamp.workflow.marching_jobs import MarchingJob
from updamp.workflow.mode_names import named_modes, window_questions
from updamp.workflow.output_folder import check_folder
from updamp.workflow.products import Product, Products, Stored, stored, why_stopped
from updamp.workflow.progress import Display
from updamp.workflow.quick_look import is_computed
from updamp.workflow.resonance_jobs import ResonanceJob
from updamp.workflow.run_jobs import RunJob, RunJobs, StageFiles
from updamp.workflow.run_options import RunOptions
from updamp.workflow.stability_jobs import StabilityJob
from updamp.workflow.stage_functions import StageFunctions
from updamp.workflow.stages import Stage

COMPONENT_STEPS = 4  # announced by the finite elements of one component, for the progress bar


@dataclass(eq=False)
class Run:
    """What a run has at hand. `executed` names the stages and curves that were computed, not taken from files.

    raises: ValueError where an option names a mesh or mode that the rig file does not have, the folder is no place to
        write into, or the memory does not hold what is asked for
    """

    rig: Rig
    options: RunOptions
    display: Display
    functions: StageFunctions = field(default_factory=StageFunctions)
    executed: list[str] = field(default_factory=list)

    def __post_init__(self) -> None:
        _check_names("--mesh", (self.options.preset,), self.rig.mesh)
        _check_names("--mode", self.options.modes, self.rig.study.modes)
        check_folder(self.options.folder, self.rig.name)
        check_size(self.rig, self.options.preset, self._meshed())

    def _meshed(self) -> bool:
        """Whether both components are there, from this machine or another."""
        try:
            return all(
                store.read_stamp(self.files.file(stage.name)).key == self.files.key(stage)
                for stage in (stages.BLADE, stages.DAMPER)
            )
        except store.StoreError:
            return False

    @property
    def files(self) -> StageFiles:
        return StageFiles(self.rig, self.options)

    def wanted(self, stage: Stage) -> bool:
        """Whether the run goes as far as this stage."""
        last = self.options.until
        return last is None or stages.STAGES.index(stage) <= stages.STAGES.index(last)

    def products(self) -> Products:
        """Run what has to be run.

        raises: what the stages raise; KeyboardInterrupt after an interruption, with all that is solved on disk
        """
        done = Products(self._mesh())
        if not self.wanted(stages.BLADE):
            return done
        done = self._with_finite_elements(done)
        finite_elements = done.finite_elements
        if finite_elements is None or not self.wanted(stages.STATIC_CONTACT):
            return done
        rest = self._static_contact(finite_elements.product)
        done = replace(done, static_contact=rest)
        if not self.wanted(stages.CURVE):
            return done
        done = replace(done, named_modes=named_modes(self.rig, finite_elements.product.reduced, rest.product))
        windows = {mode: self.rig.study.modes[mode].window for mode in self.options.modes or self.rig.study.modes}
        for question in window_questions(windows, done):
            self.display.note("question", question)
        return self._with_curves(done, finite_elements.path, rest.path)

    def _with_curves(self, done: Products, finite_elements: Path, rest: Path) -> Products:
        jobs = RunJobs(self.files, self.rig.response_point, finite_elements, rest)
        given, failures, left = self._obtain_all(jobs, jobs.at_once())
        curves = [(job, one) for job, one in given if isinstance(job, CurveJob)]
        done = replace(
            done,
            curves=tuple(one for job, one in curves if not job.finer),
            finer=tuple(one for job, one in curves if job.finer),
            point_errors=tuple(one for job, one in given if isinstance(job, AccuracyJob)),
            stability=tuple(one for job, one in given if isinstance(job, StabilityJob)),
            marched=tuple(one for job, one in given if isinstance(job, MarchingJob)),
            resonances=tuple(one for job, one in given if isinstance(job, ResonanceJob)),
            failures=tuple(one for one in failures if _is_curve(one.job)),
            unknown=tuple(one for one in failures if not _is_curve(one.job)),
            left=left,
        )
        return self._with_detached(done, jobs, curves)

    def _with_detached(self, done: Products, jobs: RunJobs, curves: Sequence[tuple[CurveJob, Stored[Any]]]) -> Products:
        """What lies beside curves: known once they and the resonances followed in force are."""
        followed = {entry.product.mode: entry for entry in done.resonances}
        beside = [jobs.beside(job, one.product, followed.get(job.mode)) for job, one in curves if not job.finer]
        given, failures, left = self._obtain_all(jobs, [job for job in beside if job is not None])
        detached, unknown = tuple(one for _, one in given), (*done.unknown, *failures)
        return replace(done, detached=detached, unknown=unknown, left=(*done.left, *left))

    def _mesh(self) -> Stored[RigMesh]:
        def compute(meter: Meter) -> tuple[RigMesh, Mapping[str, float]]:
            mesh = self.functions.mesh(self.rig, self.options.preset)
            return mesh, {"mesh": meter.seconds}

        return self._obtain(stages.MESH, RigMesh, compute)

    def _with_finite_elements(self, done: Products) -> Products:
        """As far as the run goes. The components share their factorisations with the check where they are made now."""
        with RigComponents(done.mesh.product, self.rig) as parts:
            for stage in (stages.BLADE, stages.DAMPER):
                if self.wanted(stage):
                    done = replace(done, components=(*done.components, self._component(stage, parts)))
            if not self.wanted(stages.FINITE_ELEMENTS):
                return done
            finite_elements = self._joined(done)
            done = replace(done, finite_elements=finite_elements)
            if not self.options.check or not self.wanted(stages.COUPLED_CHECK):
                return done
            return replace(done, coupled_check=self._coupled_check(parts, finite_elements.product))

    def _joined(self, done: Products) -> Stored[FiniteElementResult]:
        def compute(_: Meter) -> tuple[FiniteElementResult, Mapping[str, float]]:
            blade, damper = (component.product for component in done.components)
            return joined(blade, damper, done.mesh.product.contacts), {}

        return self._obtain(stages.FINITE_ELEMENTS, FiniteElementResult, compute)

    def _component(self, stage: Stage, parts: RigComponents) -> Stored[ComponentModel]:
        def compute(_: Meter) -> tuple[ComponentModel, Mapping[str, float]]:
            parts.clock.progress = self._steps(stage.name, COMPONENT_STEPS)
            return parts.clock.timed(lambda: self.functions.component(stage)(parts))

        return self._obtain(stage, ComponentModel, compute)

    def _coupled_check(self, parts: RigComponents, finite_elements: FiniteElementResult) -> Stored[CoupledCheck]:
        def compute(_: Meter) -> tuple[CoupledCheck, Mapping[str, float]]:
            parts.clock.progress = self._steps(stages.COUPLED_CHECK.name, 1 + COMPONENT_STEPS)
            return parts.clock.timed(lambda: self.functions.coupled_check(parts, finite_elements.reduced))

        return self._obtain(stages.COUPLED_CHECK, CoupledCheck, compute)

    def _static_contact(self, finite_elements: FiniteElementResult) -> Stored[StaticContact]:
        def compute(meter: Meter) -> tuple[StaticContact, Mapping[str, float]]:
            rest = self.functions.static_contact(self.rig, finite_elements.reduced)
            return rest, {"static_contact": meter.seconds}

        return self._obtain(stages.STATIC_CONTACT, StaticContact, compute)

    def _obtain(
        self,
        stage: Stage,
        kind: type[Product],
        compute: Callable[[Meter], tuple[Product, Mapping[str, float]]],
    ) -> Stored[Product]:
        """The stage's product from its file if that fits, else computed and stored.

        compute: takes the running meter; returns the product and the wall time of its parts [s], by name
        """
        path, key = self.files.file(stage.name), self.files.key(stage)
        if (found := stored(path, kind, key)) is not None:
            self.display.unchanged(stage.name)
            return found
        with Meter() as meter, self.display.stage(stage.name):
            product, seconds = compute(meter)
        self.executed.append(stage.name)
        stamp = store.Stamp(key, seconds, (meter.interval,), meter.peak_memory)
        store.write(path, product, stamp)
        return Stored(path, product, stamp)

    def _steps(self, name: str, count: int) -> Callable[[str], None]:
        begun = 0

        def progress(step: str) -> None:
            nonlocal begun
            self.display.update(name, min(begun / count, 0.99), step)
            begun += 1

        return progress

    # --- the curves, and what is said about them ---

    def _obtain_all(
        self, jobs: RunJobs, first: Sequence[RunJob]
    ) -> tuple[list[tuple[RunJob, Stored[Any]]], list[JobOutcome], tuple[RunJob, ...]]:
        """Some jobs, and those that follow them, with their products, in this order, from their files where those fit,
        else computed and stored, shared over the processes; what became of those that were not finished; and those
        that a quick look leaves out.
        """
        found: dict[Path, Stored[Any]] = {}
        left: dict[Path, RunJob] = {}

        def missing(those: Iterable[RunJob]) -> Iterator[RunJob]:
            """Those that are to be computed, also of the ones that follow those that are on file."""
            for job in those:
                if (there := stored(job.output, job.kind, job.key)) is None:
                    if is_computed(job, self.rig, self.options):
                        yield job
                    else:
                        left[job.output] = job
                    continue
                if job.name not in self.executed:
                    self.display.unchanged(job.name, why_stopped(there.product))
                found[job.output] = there
                yield from missing(jobs.following(job, there.product))

        outcomes = self._run_all(list(missing(first)), jobs, missing)
        failures = [one for one in outcomes if one.end is not JobEnd.FINISHED]
        return _in_order(jobs, first, found), failures, tuple(left.values())

    def _run_all(
        self, first: Sequence[RunJob], jobs: RunJobs, missing: Callable[[Iterable[RunJob]], Iterable[RunJob]]
    ) -> Sequence[JobOutcome]:
        """missing: of jobs those of which there is no file, with what follows the others"""
        if not first:
            return ()
        in_all = self.display.together("in all", sum(1 + jobs.count_following(job) for job in first))

        def progress(job: Job, reached: JobProgress) -> None:
            self.display.update(job.name, reached.share, reached.detail)
            in_all.update(job.name, reached.share)

        def end(outcome: JobOutcome) -> None:
            self._on_end(outcome)
            in_all.done(outcome.job.name)

        def following(outcome: JobOutcome) -> Sequence[Job]:
            assert isinstance(outcome.job, RunJob), "such were handed in"
            return [job for job in missing([outcome.job]) if job is not outcome.job]

        outcomes = run_all(first, self.options.workers, progress, end, following)
        in_all.over()
        return outcomes

    def _on_end(self, outcome: JobOutcome) -> None:
        name = outcome.job.name
        if outcome.end is not JobEnd.FINISHED:
            self.display.failed(name, outcome.message or outcome.end.value)
            return
        self.executed.append(name)
        well, sentence = outcome.job.conclusion()
        show = self.display.done if well else self.display.failed
        show(name, sentence)


def _in_order(
    jobs: RunJobs, first: Sequence[RunJob], found: Mapping[Path, Stored[Any]]
) -> list[tuple[RunJob, Stored[Any]]]:
    """As the study has them, not as they were finished: files that are made of them have keys of them in this order."""
    given: list[tuple[RunJob, Stored[Any]]] = []
    for job in first:
        if (there := found.get(job.output)) is not None:
            after = jobs.following(job, there.product)
            given += [(one, found[one.output]) for one in (job, *after) if one.output in found]
    return given


def _is_curve(job: Job) -> bool:
    """One that the study asks for."""
    return isinstance(job, CurveJob) and not job.finer


def _check_names(option: str, given: Iterable[str], known: Iterable[str]) -> None:
    for name in given:
        if name not in known:
            raise ValueError(f"{option} {name}: the rig file has {', '.join(known)}")
