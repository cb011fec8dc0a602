"""A quick look: the responses and their peaks first, what checks them and what takes longest left to a later run.

Nothing is computed otherwise than in a full run. What is on file already is taken; what is left out is said.
"""

from collections.abc import Iterable, Mapping, Sequence

from updamp.hbm.continuation.response_curve import ResponseCurve
from updamp.hbm.resonance.resonance_curve import ResonanceCurve
from updamp.pictures.variants import PeakPoint
from updamp.rig.rig import Rig
from updamp.workflow.accuracy_jobs import AccuracyJob
from updamp.workflow.curve_jobs import CurveJob
from updamp.workflow.detached_jobs import DetachedJob
from updamp.workflow.job_pool import Job
from updamp.workflow.marching_jobs import MarchingJob
from updamp.workflow.products import Products
from updamp.workflow.resonance_jobs import ResonanceJob
from updamp.workflow.run_options import RunOptions
from updamp.workflow.stability_jobs import StabilityJob

PICTURES = ("frf_", "resonance_", "mesh.")  # drawn in a quick look: what their names begin with


def is_computed(job: Job, rig: Rig, options: RunOptions) -> bool:
    """Whether the run computes it where it is not on file: all, or what a quick look needs."""
    if not options.quick or isinstance(job, ResonanceJob | MarchingJob):
        return True
    return isinstance(job, CurveJob) and not job.finer and job.force not in _followed_alone(rig, options)


def _followed_alone(rig: Rig, options: RunOptions) -> Sequence[float]:
    """Forces [N] at which no curve is traced, for the resonance followed in the force gives the peak: the highest of
    the study, whose curves take longest. None where the user names forces or has no resonance followed."""
    levels = sorted(set(rig.study.force_levels))
    return levels[1:][-1:] if options.resonance and not options.forces else ()


def is_drawn(name: str, options: RunOptions) -> bool:
    """name: of a picture's file, without folder"""
    return not options.quick or name.startswith(PICTURES)


def peak_sentences(peaks: Mapping[tuple[str, float], PeakPoint | None]) -> list[str]:
    """On those that are known."""
    return [
        f"{mode} {force:g} N: peak of {1e3 * peak.receptance:.5f} mm/N at {peak.frequency:.2f} Hz; "
        "the curve may be higher elsewhere"
        for (mode, force), peak in peaks.items()
        if peak is not None
    ]


def error_is_left(left: Iterable[Job], curve: ResponseCurve) -> bool:
    """Whether a part of what is needed for the curve's numerical error was left out."""
    parts = [job.curve if isinstance(job, AccuracyJob) else job for job in left]
    return any(isinstance(p, CurveJob) and (p.mode, p.force) == (curve.mode, curve.force) for p in parts)


def curves_left(left: Iterable[Job]) -> list[CurveJob]:
    """Of which there is the peak alone, as far as the resonance was followed."""
    return [job for job in left if isinstance(job, CurveJob) and not job.finer]


def peaks_followed(products: Products) -> Mapping[tuple[str, float], PeakPoint | None]:
    """By mode and force, of the curves that were left out: the peak where the resonance, followed in the force, first
    passes it; None where it was not followed so far."""
    followed = {entry.product.mode: entry.product for entry in products.resonances}
    return {(job.mode, job.force): _peak(followed.get(job.mode), job.force) for job in curves_left(products.left)}


def not_followed(products: Products) -> list[str]:
    """Sentences on the peaks that neither a curve nor the resonance followed in the force has come to, and why."""
    why = _why_ended(products)
    return [
        f"{mode} {force:g} N: there is no curve, and the resonance was not followed so far: "
        f"{why.get(mode) or 'it was not begun'}"
        for (mode, force), peak in peaks_followed(products).items()
        if peak is None
    ]


def ended_early(products: Products) -> list[str]:
    """Sentences on the resonances that were not followed up to the highest force, and why; where a curve was left out
    for it, `not_followed` tells it."""
    left = {job.mode for job in curves_left(products.left)}
    return [
        f"{mode}: the resonance is not followed in the force to the end, and beyond curves alone tell it: {reason}"
        for mode, reason in _why_ended(products).items()
        if reason and mode not in left
    ]


def _why_ended(products: Products) -> dict[str, str]:
    """By mode, "" where it was followed to the end."""
    why = {entry.product.mode: entry.product.stopped for entry in products.resonances}
    return why | {one.job.mode: one.message for one in products.unknown if isinstance(one.job, ResonanceJob)}


def _peak(followed: ResonanceCurve | None, force: float) -> PeakPoint | None:
    if followed is None or not len(met := followed.passes(force)):
        return None
    at = int(met[0])
    return PeakPoint(force, float(followed.frequency[at]), float(abs(followed.receptance[at])), followed.complete)


def not_checked(products: Products, options: RunOptions) -> list[str]:
    """Sentences on what was left out or not asked for; what was not found is told by `not_followed`."""
    left, peaks = products.left, peaks_followed(products)
    met = [f"{mode} {force:g} N" for (mode, force), peak in peaks.items() if peak is not None]
    said = [f"{', '.join(met)}: no curve; its peak is where the resonance followed in force passes it"] if met else []
    said += [_SENTENCES[about] for about in _about_curves(left, options)]
    if not options.resonance:
        said.append("the resonance followed in force, and branches beside the curves that it leads to")
    if options.quick and options.pictures:
        said.append("pictures of contacts, damper, pressure and modes are not drawn")
    return said


def responses_note(left: Sequence[Job], options: RunOptions) -> str:
    """Of a picture of responses, "" where all is checked"""
    about = _about_curves(left, options)
    return f"not checked: {', '.join(about)}" if about else ""


_SENTENCES = {
    "stability": "which points are stable: lines are solid all the same",
    "numerical error": "the numerical error: what more harmonics, samples and cycles change",
    "peaks in time": "whether the motion at the peaks stays when it is marched in time",
    "other branches": "branches beside the curves",
}


def _about_curves(left: Sequence[Job], options: RunOptions) -> list[str]:
    kinds = {type(job) for job in left}
    finer = any(isinstance(job, CurveJob) and job.finer for job in left)
    missing = {
        "stability": StabilityJob in kinds or not options.stability,
        "numerical error": AccuracyJob in kinds or finer or not options.accuracy,
        "peaks in time": not options.marching,
        "other branches": DetachedJob in kinds,
    }
    return [name for name, is_missing in missing.items() if is_missing]
