"""`updamp diagnose`: from a rig file and a measurement to the effect that is missing."""

import hashlib
from collections.abc import Callable, Mapping, Sequence
from contextlib import suppress
from dataclasses import dataclass, field, replace
from datetime import date
from pathlib import Path

from pydantic_core import to_json
from rich.console import Console

from updamp.comparison.compare import compare
from updamp.comparison.comparison import COMPARISON_JSON, MOVED_BY_NUMERICS
from updamp.comparison.fit.compared import compare_at, predict_branches
from updamp.comparison.fit.identified_shapes import with_shapes
from updamp.comparison.fit.observations import Plan, plan_of
from updamp.comparison.fit.size_of_numerics import moved_frequencies
from updamp.comparison.prediction.branch_tasks import Branches, BranchesBy, in_turn
from updamp.diagnosis.candidate_models.baseline import Baseline, baseline, calibrated_as, held_out_runs
from updamp.diagnosis.candidate_models.fit_tasks import FitRunnerOf
from updamp.diagnosis.criteria import Criteria
from updamp.diagnosis.decision.ablations import write_ablations
from updamp.diagnosis.decision.conclude import conclude
from updamp.diagnosis.decision.decide import Decision, decide
from updamp.diagnosis.decision.profiled import Intervals, profiles, with_profiles
from updamp.diagnosis.evidence import EVIDENCE_JSON
from updamp.diagnosis.missing_force.missing_force import missing_forces
from updamp.diagnosis.next_measurement.next_measurement import next_measurements, surviving_explanations
from updamp.diagnosis.selection.search import SearchResult, search
from updamp.diagnosis.verdict import VERDICT_JSON, MissingForce, NextMeasurement, Verdict
from updamp.effects.catalogue import catalogue
from updamp.effects.chosen import code_of
from updamp.effects.effect import Effect
from updamp.effects.own_effects import own_effects
from updamp.hbm.analysis.settings import Setting
from updamp.hbm.continuation.predictor_corrector import BranchStoppedError
from updamp.measurement.measurement import Measurement
from updamp.model.rig_files import is_modal, load_any, load_rig
from updamp.parallel.processes import chosen_workers
from updamp.parallel.workers import Workers
from updamp.report.page import write_report
from updamp.workflow.built_rig import chosen_dimensions
from updamp.workflow.code_version import SEARCH, code_version
from updamp.workflow.compare_run import pictures_of, provenance_of
from updamp.workflow.comparison_inputs import CompareFiles, ComparisonInputs, comparison_inputs
from updamp.workflow.diagnose_stated import diagnose_stated, tables
from updamp.workflow.kept_results import ResultKey, inputs_digest
from updamp.workflow.progress import Display
from updamp.workflow.search_cache import CachedFits, SearchCache

_STAGE = "diagnosis"
# Predicted with each explanation, to find the next measurement: some 6 s of one core with 36 patches.
_RUNS = 6


@dataclass(frozen=True)
class DiagnoseOptions:
    """finer: presets of finer meshes, None for the next finer ones of the rig file
    dimensions: of the rig that may be other than its file says, by the effects' names; None for all
    held_out: names of runs that no fit sees, None for one level of each mode
    held_out_modes: modes of which no fit sees a run; with any, only the levels in `held_out` are held out besides
    own: files of the user's own effects, looked for too
    jobs: processes; scheduler: address of a Dask scheduler whose workers trace branches and run fits, "" for this
        machine
    report: whether to write report.html, with comparison and missing force; next_measurement: whether to look for the
        run that tells explanations apart, for the report
    """

    finer: tuple[str, ...] | None = None
    held_out: tuple[str, ...] | None = None
    held_out_modes: tuple[str, ...] = ()
    own: tuple[Path, ...] = ()
    jobs: int = 1
    scheduler: str = ""
    report: bool = True
    next_measurement: bool = True
    dimensions: tuple[str, ...] | None = None
    criteria: Criteria = field(default_factory=Criteria)

    def check(self, measurement: Measurement) -> None:
        """raises: ValueError where what is to be held out was not measured, or is all there is"""
        if measurement.runs:
            held_out_runs(plan_of(measurement), self.held_out, self.held_out_modes)


def diagnose(files: CompareFiles, preset: str, options: DiagnoseOptions, console: Console) -> Verdict:
    """Build the model where it is not there yet, search, write diagnosis.json and report.html.

    A diagnosis that was stopped goes on where it was, as long as nothing that it depends on has changed.
    raises: RigError, MeasurementError and what the stages raise; ValueError where the measurement has neither curves
        nor usable stated values, or a run to hold out was not measured
    """
    with Display(console) as display:
        dimensions = chosen_dimensions(options.dimensions)
        inputs = comparison_inputs(files, preset, options.jobs, display, options.finer, dimensions, options.check)
        provenance = {**provenance_of(files, inputs, preset), "date": date.today().isoformat()}
        if not inputs.measurement.runs:
            return _of_stated(files, options, inputs, provenance, display, console)
        effects = _effects(inputs, options)
        plan = with_shapes(plan_of(inputs.measurement), inputs.before_effects, inputs.measurement.calibrated)
        progress = _progress_bar(display)
        cache = _cache(files, preset, options, inputs, effects, display)
        with chosen_workers(options.jobs, options.scheduler, options.own) as workers:
            start = _baseline(cache, inputs, plan, options, progress, BranchesBy(workers))
            if moved := moved_frequencies(start.fitted.parametrisation.numerics, plan):
                provenance[MOVED_BY_NUMERICS] = moved
                display.note("numerics", f"{MOVED_BY_NUMERICS}: {moved}")
            found = search(start, effects, options.criteria, progress, CachedFits(cache, FitRunnerOf(workers)), workers)
            provenance["held out"] = ", ".join(plan.conditions[i].name for i in start.held_out) or "nothing"
            names = {channel.point: channel.name for channel in inputs.measurement.channels}
            decision = decide(found.evidence, options.criteria)
            found = with_profiles(found, _profiles(cache, found, decision, progress, workers))
            provenance["solved with"] = _setting(found)
            forces = _forces(found, decision, BranchesBy(workers)) if options.report else ()
            proposed = _next_measurements(cache, found, decision, options, progress, workers) if options.report else ()
            verdict = conclude(found, decision, options.criteria, names, forces, provenance, proposed)
            VERDICT_JSON.write(files.out / "diagnosis.json", verdict)
            EVIDENCE_JSON.write(files.out / "evidence.json", found.evidence)
            write_ablations(files.out / "ablations.json", found.evidence, options.criteria)
            if options.report:
                _report(files, inputs, verdict, display, progress, BranchesBy(workers))
        display.done(_STAGE, f"{verdict.verdict}: {', '.join((*verdict.outright, *verdict.group)) or 'no effect'}")
    return verdict


def _setting(found: SearchResult) -> str:
    """What all models of the search are solved with"""
    base = found.baseline.given
    return str(Setting(base.harmonics.orders, base.time_samples))


def _of_stated(
    files: CompareFiles,
    options: DiagnoseOptions,
    inputs: ComparisonInputs,
    provenance: Mapping[str, str],
    display: Display,
    console: Console,
) -> Verdict:
    """Where no curve was measured: diagnosis.json, report.html and two tables."""
    if not inputs.measurement.features or is_modal(files.rig):
        raise ValueError(
            f"{files.measurement}: no runs (curves), and no stated features that a rig with contacts could answer to; "
            "measure curves with repeats"
        )
    rig, progress = load_rig(files.rig), _progress_bar(display)
    found = diagnose_stated(
        inputs.before_effects,
        rig.windows,
        f"blade_{rig.excitation.blade}",
        inputs.measurement.features,
        _effects(inputs, options),
        inputs.rig_effects,
        provenance,
        progress,
        options.criteria,
    )
    VERDICT_JSON.write(files.out / "diagnosis.json", found.verdict)
    if options.report:
        _report(files, inputs, found.verdict, display, progress, in_turn)
    display.done(_STAGE, found.verdict.verdict)
    for table in tables(found):
        console.print(table)
    return found.verdict


def _effects(inputs: ComparisonInputs, options: DiagnoseOptions) -> tuple[Effect, ...]:
    """Those of the catalogue and the user's own that the rig file does not have yet and the runs may tell."""
    modes = len({run.mode for run in inputs.measurement.runs})
    present = {one.effect.name for one in inputs.rig_effects}
    known = [*catalogue().values(), *own_effects(options.own, inputs.before_effects)]
    return tuple(effect for effect in known if effect.name not in present and effect.modes <= modes)


def _cache(
    files: CompareFiles,
    preset: str,
    options: DiagnoseOptions,
    inputs: ComparisonInputs,
    effects: Sequence[Effect],
    display: Display,
) -> SearchCache:
    """What was found so far, if it was by this version of updamp and from the same inputs."""
    key = ResultKey(code_version(*SEARCH), _digest(files, preset, options, inputs, effects))
    return SearchCache(files.out / "search", key, lambda sentence: display.note(_STAGE, sentence)).without_stale()


def _digest(
    files: CompareFiles, preset: str, options: DiagnoseOptions, inputs: ComparisonInputs, effects: Sequence[Effect]
) -> str:
    """Of all that the results depend on beside updamp itself. The rig file counts as it is read: what the files that it
    names hold counts too, comments do not."""
    code = [hashlib.sha256(path.read_bytes()).hexdigest() for path in options.own]
    code += [code_of(effect, None) for effect in effects]
    data = [f"{name} {value}" for name, value in sorted((inputs.measurement.hashes or {}).items())]
    rig = to_json(load_any(files.rig)).decode()
    decisive = replace(options, jobs=1, scheduler="", report=True, next_measurement=True, own=())
    return inputs_digest(rig, preset, repr(decisive), *code, *data, *(e.name for e in effects))


def _baseline(
    cache: SearchCache,
    inputs: ComparisonInputs,
    plan: Plan,
    options: DiagnoseOptions,
    progress: Callable[[str], None],
    branches_of: Branches,
) -> Baseline:
    def made() -> Baseline:
        held_out = held_out_runs(plan, options.held_out, options.held_out_modes)
        return baseline(inputs.before_effects, inputs.rig_effects, plan, inputs.finer, held_out, progress, branches_of)

    return cache.once("baseline", made)


def _forces(found: SearchResult, decision: Decision, branches_of: Branches) -> tuple[MissingForce, ...]:
    """Beside the calibration that goes with what is named: that of the model without it has taken up a part of the
    force, more than first order gives back."""
    fitted, plan = found.baseline.fitted, found.baseline.train_plan
    if decision.outcome == "adequate" or not plan.has_phases:
        return ()  # a force has a direction
    p, compared = fitted.parametrisation, fitted.compared
    if decision.trial is not None and (decision.effects or decision.group):
        u = calibrated_as(fitted, found.refits[decision.trial.effects].fitted)
        with suppress(BranchStoppedError):  # where the model without effects has no response
            compared = compare_at(p, u, plan, predict_branches(p, u, plan, None, branches_of), compared.scatter)
    return missing_forces(compared, p, plan)


def _profiles(
    cache: SearchCache, found: SearchResult, decision: Decision, progress: Callable[[str], None], workers: Workers
) -> Mapping[tuple[str, ...], Intervals]:
    """Intervals of what the verdict speaks of."""
    if decision.trial is None:
        return {}
    name = f"intervals {' or '.join(' and '.join(t.effects) for t in (decision.trial, *decision.alternatives))}"
    return cache.once(name, lambda: profiles(found, decision, progress, workers))


def _next_measurements(
    cache: SearchCache,
    found: SearchResult,
    decision: Decision,
    options: DiagnoseOptions,
    progress: Callable[[str], None],
    workers: Workers,
) -> tuple[NextMeasurement, ...]:
    """The next measurements worth making, where explanations are still to be separated."""
    explanations = surviving_explanations(found, decision, options.criteria) if options.next_measurement else {}
    if not explanations:
        return ()
    name = f"next measurement {', '.join(explanations)}"
    return cache.once(name, lambda: next_measurements(explanations, found.baseline.plan, progress, _RUNS, workers))


def _report(
    files: CompareFiles,
    inputs: ComparisonInputs,
    verdict: Verdict,
    display: Display,
    progress: Callable[[str], None],
    branches_of: Branches,
) -> None:
    comparison, _ = compare(
        inputs.before_effects,
        inputs.measurement,
        inputs.features,
        verdict.provenance,
        progress=progress,
        finer=inputs.finer,
        rig_effects=inputs.rig_effects,
        branches_of=branches_of,
    )
    COMPARISON_JSON.write(files.comparison, comparison)
    write_report(comparison, files.report, pictures_of(files.out), verdict)
    for odd in comparison.to_look_at:
        display.note("check", odd)


def _progress_bar(display: Display) -> Callable[[str], None]:
    """How many fits there will be is not known: the bar tells what it is at."""
    share = 0.0

    def progress(step: str) -> None:
        nonlocal share
        share += (1 - share) / 40
        display.step(_STAGE, share, step)

    return progress
