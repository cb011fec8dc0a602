"""The jobs of a run: which are begun with, and which follow a curve once it is traced."""

import hashlib
from collections.abc import Iterator
from dataclasses import dataclass, replace
from pathlib import Path

from updamp.hbm.continuation.response_curve import ResponseCurve
from updamp.hbm.resonance.resonance_curve import ResonanceCurve
from updamp.rig.rig import Rig
from updamp.workflow import stages
from updamp.workflow.accuracy_jobs import AccuracyJob
from updamp.workflow.adaptive_curves import AdaptiveCurveJob, of_these_harmonics
from updamp.workflow.curve_jobs import CurveJob
from updamp.workflow.detached_jobs import DetachedJob, has_more
from updamp.workflow.marching_jobs import MarchingJob
from updamp.workflow.products import Stored
from updamp.workflow.resonance_jobs import ResonanceJob
from updamp.workflow.run_options import RunOptions
from updamp.workflow.stability_jobs import StabilityJob
from updamp.workflow.stages import Stage

RunJob = CurveJob | AccuracyJob | StabilityJob | MarchingJob | ResonanceJob | DetachedJob


@dataclass(frozen=True)
class StageFiles:
    """Where the products of a run stand, and with which keys."""

    rig: Rig
    options: RunOptions

    def file(self, name: str) -> Path:
        return self.options.folder / "stages" / f"{name}.h5"

    def key(self, stage: Stage, mode: str = "", force: float = 0.0) -> str:
        return stage.key(self.rig, {"preset": self.options.preset, "mode": mode, "force": repr(force)})


@dataclass(frozen=True)
class RunJobs:
    """point: where peaks are taken; finite_elements, rest: files of the stages before"""

    files: StageFiles
    point: str
    finite_elements: Path
    rest: Path

    def at_once(self) -> tuple[RunJob, ...]:
        """What waits for no curve: the curves, one a mode and force, as the study or the options have them; and the
        resonances, one a mode."""
        options, rig = self.files.options, self.files.rig
        modes = options.modes or tuple(rig.study.modes)
        choices = [(mode, force) for mode in modes for force in options.forces or rig.study.force_levels]
        found: list[RunJob] = [self._curve(*choice) for choice in choices]
        if options.resonance:
            found += [self._resonance(mode) for mode in modes]
        return tuple(found)

    def following(self, job: RunJob, product: object) -> tuple[RunJob, ...]:
        """What is said about a curve, now that it is known; nothing after other jobs. product: of the job"""
        if not (isinstance(job, CurveJob) and isinstance(product, ResponseCurve)) or job.finer:
            return ()
        return tuple(self._about(of_these_harmonics(job, product), product))

    def count_following(self, job: RunJob) -> int:
        """How many they will be, where the curve is complete."""
        options = self.files.options
        if not isinstance(job, CurveJob) or job.finer:
            return 0
        if options.quick:
            return int(options.marching)
        return options.stability + options.marching + 2 * options.accuracy

    def beside(
        self, job: CurveJob, curve: ResponseCurve, followed: Stored[ResonanceCurve] | None
    ) -> DetachedJob | None:
        """Branches beside a curve, where there is anything to look at. followed: the mode's resonance in the force"""
        product = followed.product if followed is not None else None
        if not has_more(curve, product, self.files.rig.study.modes[job.mode].window):
            return None
        traced = of_these_harmonics(job, curve)
        key, output = self._of_these_points(stages.DETACHED, traced, curve)
        path, made = (followed.path, followed.stamp.key) if followed is not None else (None, "")
        return DetachedJob(traced, self.point, key + made, output, path)

    def _about(self, traced: CurveJob, curve: ResponseCurve) -> Iterator[RunJob]:
        options = self.files.options
        if options.accuracy:
            yield AccuracyJob(traced, self.point, *self._of_these_points(stages.FINER_POINTS, traced, curve))
        if options.stability:
            yield StabilityJob(traced, self.point, *self._of_these_points(stages.STABILITY, traced, curve))
        if options.marching:
            yield MarchingJob(traced, self.point, *self._of_these_points(stages.MARCHED_PEAK, traced, curve))
        if options.accuracy and curve.complete:  # of what is not known whole there is no change to be known
            yield replace(self._finer_curve(traced.mode, traced.force), orders=traced.orders)

    def _of_these_points(self, stage: Stage, job: CurveJob, curve: ResponseCurve) -> tuple[str, Path]:
        """Key and file of what a stage says about a curve. A curve that is traced once more, for its file was lost, may
        have other points."""
        key = self.files.key(stage, job.mode, job.force)
        digest = hashlib.sha256(key.encode() + curve.frequency.tobytes()).hexdigest()
        return digest, self.files.file(f"{stage.name}_{job.mode}_{job.force:.12g}N")

    def _curve(self, mode: str, force: float) -> CurveJob:
        rig, key, output = self.files.rig, self.files.key(stages.CURVE, mode, force), self._curve_file(mode, force)
        if (tolerance := rig.harmonic_balance.tolerance) is None:
            return CurveJob(rig, mode, force, key, self.finite_elements, self.rest, output)
        return AdaptiveCurveJob(
            rig, mode, force, key, self.finite_elements, self.rest, output, point=self.point, tolerance=tolerance
        )

    def _finer_curve(self, mode: str, force: float) -> CurveJob:
        rig, key = self.files.rig, self.files.key(stages.FINER_CURVE, mode, force)
        output = self._curve_file(mode, force, "_finer")
        return CurveJob(rig, mode, force, key, self.finite_elements, self.rest, output, finer=True)

    def _resonance(self, mode: str) -> ResonanceJob:
        name, key = f"{stages.RESONANCE.name}_{mode}", self.files.key(stages.RESONANCE, mode)
        output = self.files.file(name)
        return ResonanceJob(self.files.rig, mode, self.point, key, self.finite_elements, self.rest, output)

    def _curve_file(self, mode: str, force: float, ending: str = "") -> Path:
        return self.files.file(f"curve_{mode}_{force:.12g}N{ending}")
