"""One run: the stages in order, each taken from its file where nothing that goes into it has changed."""

import hashlib
from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import TypeVar

from updamp.fem.finite_element_model import ComponentModel, CoupledCheck, FiniteElementResult, joined
from updamp.fem.rig_components import RigComponents
from updamp.fem.static_contact.rest_state import StaticContact
from updamp.geometry.rig_mesh import RigMesh
from updamp.hbm.analysis.finer_points import PointErrors
from updamp.hbm.continuation.response_curve import ResponseCurve
from updamp.hbm.resonance.resonance_curve import ResonanceCurve
from updamp.hbm.stability.branch_stability import BranchStability
from updamp.parallel.resources import Meter
from updamp.rig.questions import empty_windows, possible_resonances
from updamp.rig.rig import Rig
from updamp.workflow import stages, store
from updamp.workflow.accuracy_jobs import AccuracyJob
from updamp.workflow.adaptive_curves import AdaptiveCurveJob, of_these_harmonics
from updamp.workflow.curve_jobs import CurveJob
from updamp.workflow.job_pool import Job, JobEnd, JobOutcome, JobProgress, run_all
from updamp.workflow.limits import check_size
from updamp.workflow.output_folder import check_folder
from updamp.workflow.products import Product, Products, Stored, stored
from updamp.workflow.progress import Display
from updamp.workflow.resonance_jobs import ResonanceJob
from updamp.workflow.run_options import RunOptions
from updamp.workflow.stability_jobs import StabilityJob
from updamp.workflow.stage_functions import StageFunctions
from updamp.workflow.stages import Stage

AnyJob = TypeVar("AnyJob", bound=Job)

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
                store.read_stamp(self.file(stage.name)).key == self.key(stage)
                for stage in (stages.BLADE, stages.DAMPER)
            )
        except store.StoreError:
            return False

    def file(self, name: str) -> Path:
        return self.options.folder / "stages" / f"{name}.h5"

    def key(self, stage: Stage, mode: str = "", force: float = 0.0) -> str:
        return stage.key(self.rig, {"preset": self.options.preset, "mode": mode, "force": repr(force)})

    @property
    def response_point(self) -> str:
        """Where peaks are taken: the tip of the blade that is excited."""
        return f"blade_{self.rig.excitation.blade}.tip.x"

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
        finite_elements, check = done.finite_elements, done.coupled_check
        if finite_elements is None or not self.wanted(stages.STATIC_CONTACT):
            return done
        rest = self._static_contact(finite_elements.product)
        done = replace(done, static_contact=rest)
        if not self.wanted(stages.CURVE):
            return done
        self._ask_of_windows(finite_elements.product, check.product if check else None)
        return self._with_curves(done, finite_elements.path, rest.path)

    def _ask_of_windows(self, finite_elements: FiniteElementResult, check: CoupledCheck | None) -> None:
        if check is None:  # the stuck structure's frequencies are not known
            return
        resonances = possible_resonances(finite_elements.blade_frequencies.tolist(), check.full.tolist())
        windows = {mode: self.rig.study.modes[mode].window for mode in self.options.modes or self.rig.study.modes}
        for question in empty_windows(windows, resonances, float(check.full.max())):
            self.display.note("question", question)

    def _with_curves(self, done: Products, finite_elements: Path, rest: Path) -> Products:
        jobs = self.jobs(finite_elements, rest)
        base, extra = ([job for job in jobs if job.finer == kind] for kind in (False, True))
        together = [*base, *extra] if self.rig.harmonic_balance.tolerance is None else base
        found, failures = self._obtain_all(together, ResponseCurve)
        traced = [(of_these_harmonics(job, found[job.output].product), found[job.output].product)
                  for job in base if job.output in found]  # fmt: skip
        if together is base:  # how far finer curves go is known now
            orders = {(job.mode, job.force): job.orders for job, _ in traced}
            extra = [
                replace(job, orders=orders[job.mode, job.force]) for job in extra if (job.mode, job.force) in orders
            ]
            more, lost = self._obtain_all(extra, ResponseCurve)
            found, failures = {**found, **more}, (*failures, *lost)
        outputs = {job.output for job in extra}
        done = replace(
            done,
            curves=tuple(found[job.output] for job in base if job.output in found),
            finer=tuple(found[job.output] for job in extra if job.output in found),
            failures=tuple(one for one in failures if one.job.output not in outputs),
            unknown=tuple(one for one in failures if one.job.output in outputs),
        )
        done = self._with_stability(self._with_point_errors(done, traced), traced)
        return self._with_resonances(done, finite_elements, rest)

    def _with_point_errors(self, done: Products, curves: Sequence[tuple[CurveJob, ResponseCurve]]) -> Products:
        if not self.options.accuracy:
            return done
        jobs = [
            AccuracyJob(job, self.response_point, *self._about(stages.FINER_POINTS, job, curve))
            for job, curve in curves
        ]
        found, failures = self._obtain_all(jobs, PointErrors)
        errors = tuple(found[job.output] for job in jobs if job.output in found)
        return replace(done, point_errors=errors, unknown=(*done.unknown, *failures))

    def _with_stability(self, done: Products, curves: Sequence[tuple[CurveJob, ResponseCurve]]) -> Products:
        if not self.options.stability:
            return done
        jobs = [
            StabilityJob(job, self.response_point, *self._about(stages.STABILITY, job, curve)) for job, curve in curves
        ]
        found, failures = self._obtain_all(jobs, BranchStability)
        stability = tuple(found[job.output] for job in jobs if job.output in found)
        return replace(done, stability=stability, unknown=(*done.unknown, *failures))

    def _with_resonances(self, done: Products, finite_elements: Path, rest: Path) -> Products:
        if not self.options.resonance:
            return done
        jobs = [
            ResonanceJob(
                self.rig, mode, self.response_point, self.key(stages.RESONANCE, mode), finite_elements, rest,
                self.file(f"{stages.RESONANCE.name}_{mode}"),
            )
            for mode in self.options.modes or tuple(self.rig.study.modes)
        ]  # fmt: skip
        found, failures = self._obtain_all(jobs, ResonanceCurve)
        resonances = tuple(found[job.output] for job in jobs if job.output in found)
        return replace(done, resonances=resonances, unknown=(*done.unknown, *failures))

    def _about(self, stage: Stage, job: CurveJob, curve: ResponseCurve) -> tuple[str, Path]:
        """Key and file of what a stage says about a curve. A curve that is traced once more, for its file was lost, may
        have other points."""
        key = self.key(stage, job.mode, job.force)
        digest = hashlib.sha256(key.encode() + curve.frequency.tobytes()).hexdigest()
        return digest, self.file(f"{stage.name}_{job.mode}_{job.force:.12g}N")

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
        path, key = self.file(stage.name), self.key(stage)
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

    # --- the curves ---

    def jobs(self, finite_elements: Path, rest: Path) -> tuple[CurveJob, ...]:
        """One a mode and force, as the study or the options have them; two where the accuracy is asked for."""
        modes = self.options.modes or tuple(self.rig.study.modes)
        forces = self.options.forces or self.rig.study.force_levels
        choices = [(mode, force) for mode in modes for force in forces]
        base = [self._curve_job(stages.CURVE, *choice, finite_elements, rest) for choice in choices]
        if not self.options.accuracy:
            return tuple(base)
        extra = [self._curve_job(stages.FINER_CURVE, *choice, finite_elements, rest) for choice in choices]
        return (*base, *extra)

    def _curve_job(self, stage: Stage, mode: str, force: float, finite_elements: Path, rest: Path) -> CurveJob:
        finer, tolerance = stage is stages.FINER_CURVE, self.rig.harmonic_balance.tolerance
        output = self.file(f"curve_{mode}_{force:.12g}N{'_finer' if finer else ''}")
        key = self.key(stage, mode, force)
        if tolerance is None or finer:
            return CurveJob(self.rig, mode, force, key, finite_elements, rest, output, finer)
        point = self.response_point
        return AdaptiveCurveJob(
            self.rig, mode, force, key, finite_elements, rest, output, point=point, tolerance=tolerance
        )

    def _obtain_all(
        self, jobs: Sequence[AnyJob], kind: type[Product]
    ) -> tuple[Mapping[Path, Stored[Product]], tuple[JobOutcome, ...]]:
        """The jobs' products from their files if those fit, else computed and stored, shared over the processes; and
        what became of those that were not finished.
        """
        found = _stored_products(jobs, kind)
        missing = [job for job in jobs if job.output not in found]
        for job in jobs:
            if job.output in found:
                self.display.unchanged(job.name)
        if not missing:
            return found, ()
        in_all = self.display.together("in all", len(missing))

        def progress(job: Job, reached: JobProgress) -> None:
            self._on_progress(job, reached)
            in_all.update(job.name, reached.share)

        def end(outcome: JobOutcome) -> None:
            self._on_end(outcome)
            in_all.done(outcome.job.name)

        outcomes = run_all(missing, min(self.options.workers, len(missing)), progress, end)
        in_all.over()
        found |= _stored_products(missing, kind)
        return found, tuple(outcome for outcome in outcomes if outcome.end is not JobEnd.FINISHED)

    def _on_progress(self, job: Job, progress: JobProgress) -> None:
        self.display.update(job.name, progress.share, progress.detail)

    def _on_end(self, outcome: JobOutcome) -> None:
        name = outcome.job.name
        if outcome.end is not JobEnd.FINISHED:
            self.display.failed(name, outcome.message or outcome.end.value)
            return
        self.executed.append(name)
        well, sentence = outcome.job.conclusion()
        show = self.display.done if well else self.display.failed
        show(name, sentence)


def _stored_products(jobs: Iterable[Job], kind: type[Product]) -> dict[Path, Stored[Product]]:
    """By file, those that are there."""
    products = ((job.output, stored(job.output, kind, job.key)) for job in jobs)
    return {path: product for path, product in products if product is not None}


def _check_names(option: str, given: Iterable[str], known: Iterable[str]) -> None:
    for name in given:
        if name not in known:
            raise ValueError(f"{option} {name}: the rig file has {', '.join(known)}")
