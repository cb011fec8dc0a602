"""The explanations that the data leave side by side, and the measurement that would separate them best, per hour.

Every run that the rig could make next (candidate_runs.py, with the hours that each is taken to need) is predicted with
each explanation, by a branch traced at its fitted parameters; how far two predictions lie apart is in separation.py.
One run of one assembly is assumed, with the sensors' noise and the scatter as learnt so far. Numerical error is left
out: both explanations share it.
"""

from collections.abc import Callable, Mapping
from dataclasses import replace
from itertools import combinations

import numpy as np
from numpy.typing import NDArray

from updamp.comparison.fit.fit import Fit
from updamp.comparison.fit.observations import Plan
from updamp.comparison.prediction.numerical_error import NumericalError
from updamp.comparison.prediction.traced_branch import trace_branch
from updamp.diagnosis.candidate_models.fit_tasks import without_branches
from updamp.diagnosis.criteria import Criteria
from updamp.diagnosis.decision.decide import Decision
from updamp.diagnosis.evidence import Trial
from updamp.diagnosis.next_measurement.candidate_runs import CandidateRun, Recording, candidate_runs
from updamp.diagnosis.next_measurement.separation import PredictedRun, RunNoise, separation
from updamp.diagnosis.selection.search import SearchResult
from updamp.diagnosis.verdict import NextMeasurement
from updamp.hbm.continuation.continuation import BranchStoppedError, ContinuationOptions
from updamp.parallel.workers import Workers, here

Floats = NDArray[np.float64]
Progress = Callable[[str], None]

# Separation from which on a run decides between two explanations, and below which it says next to nothing.
DECIDES, _NOTHING = 3.0, 1.0
# Half the usual step: between its points a branch is interpolated, and at a noise of half a per cent what that does to
# places where contacts begin to slip would pass for a separation of five.
_FINE = ContinuationOptions(largest_step=0.1)
# Separation by which further harmonics or sensors have to exceed that of the run without them.
_MORE = 1.1
# Measurements kept for every pair of explanations.
_KEPT = 3
# Explanations at most: each is predicted with every run.
_MOST = 3
NOTHING = "nothing missing"


def next_measurements(
    explanations: Mapping[str, Fit],
    plan: Plan,
    progress: Progress = lambda _: None,
    most_runs: int = 12,
    workers: Workers = here,
) -> tuple[NextMeasurement, ...]:
    """For every pair of explanations the runs with most separation per hour, best first; a pair that no run separates
    keeps its best one, and the sentence says so. Empty for fewer than two.

    plan: that they were fitted to; most_runs: runs predicted, each by one traced branch for each explanation
    """
    if len(explanations) < 2:
        return ()
    first = next(iter(explanations.values())).parametrisation
    runs = candidate_runs(plan, first, most_runs)
    wanted = [(run, name) for run in runs for name in explanations]
    fits = {name: without_branches(fit) for name, fit in explanations.items()}
    predicted = workers(
        _prediction, (fits, _noise(plan)), wanted, lambda i, _: progress(f"predicted {wanted[i][0].condition.name}")
    )
    rows = zip(*[iter(predicted)] * len(explanations), strict=True)
    found: dict[tuple[str, str], list[NextMeasurement]] = {}
    for run, row in zip(runs, rows, strict=True):
        predictions = dict(zip(explanations, row, strict=True))
        for a, b in combinations(explanations, 2):
            one, other = predictions[a], predictions[b]
            if one is not None and other is not None:
                measurements = [_measurement((a, b), one, other, r) for r in run.recordings]
                found.setdefault((a, b), []).extend(_worth_recording(measurements))
    best = [measurement for pair in found.values() for measurement in _best(pair)]
    return tuple(sorted(best, key=_rate, reverse=True))


def _worth_recording(measurements: list[NextMeasurement]) -> list[NextMeasurement]:
    """Of one run, read off in several ways: the first, and others that tell more."""
    first, *others = measurements
    return [first, *(m for m in others if m.separation > _MORE * first.separation)]


def _rate(measurement: NextMeasurement) -> float:
    return measurement.separation / measurement.hours


def _best(measurements: list[NextMeasurement]) -> list[NextMeasurement]:
    known = sorted((m for m in measurements if np.isfinite(m.separation)), key=_rate, reverse=True)
    worth = [m for m in known if m.separation >= DECIDES]
    return worth[:_KEPT] or sorted(known, key=lambda m: -m.separation)[:1]


def _measurement(
    pair: tuple[str, str], one: PredictedRun, other: PredictedRun, recording: Recording
) -> NextMeasurement:
    apart = separation(one, other, recording.sensors)
    a, b = pair
    if apart < _NOTHING:
        sentence = f"no run that was looked at tells {a} from {b}; the best is to {recording.what}"
    elif apart < DECIDES:
        sentence = f"{recording.what}: a hint at most, {a} and {b} would lie {apart:.1f} standard deviations apart"
    else:
        sentence = f"{recording.what}: {a} and {b} would lie {apart:.3g} standard deviations apart"
    return NextMeasurement(sentence, pair, apart, recording.hours)


def _noise(plan: Plan) -> RunNoise:
    """As in the plan: of its frequencies, and of each point; under "" that of all points."""
    values: dict[str, list[float]] = {}
    for o in plan.observations:
        for j, (point, _) in enumerate(plan.conditions[o.test].sensors):
            values.setdefault(point, []).append(float(np.median(o.noise[:, 1 + 2 * j])))
    sensors = {point: float(np.median(each)) for point, each in values.items()}
    frequency = float(np.median(np.concatenate([o.noise[:, 0] for o in plan.observations])))
    return RunNoise(frequency, {**sensors, "": float(np.median(list(sensors.values())))} if sensors else sensors)


def _prediction(shared: tuple[Mapping[str, Fit], RunNoise], wanted: tuple[CandidateRun, str]) -> PredictedRun | None:
    """None where the model has no response there. shared: explanations, and noise; wanted: run, and whose prediction"""
    (fits, noise), (run, name) = shared, wanted
    fit = fits[name]
    n = fit.parametrisation.n_of_model
    parametrisation = replace(fit.parametrisation, numerics=NumericalError())
    u = fit.u[:n]
    if run.load != 1:
        parametrisation = replace(parametrisation, base=parametrisation.base.with_pull(run.load))
    try:
        branch = trace_branch(parametrisation, u, run.condition, _FINE)
    except BranchStoppedError:
        return None
    names = tuple(nuisance.name for nuisance in parametrisation.nuisances)
    return PredictedRun(branch, fit.covariance[:n, :n], names, fit.compared.scatter, noise)


def surviving_explanations(found: SearchResult, decision: Decision, criteria: Criteria) -> dict[str, Fit]:
    """Name of the explanation -> its fit, the best first; at least two, or none where there is nothing to separate.

    inseparable, undecidable: all that are beside each other; unknown: the best effects, as far as they explain nearly
    as much; adequate: that nothing is missing and the best effect that the data of the fit alone would ask for
    """
    evidence = found.evidence
    settled = sorted((t for t in (*evidence.trials, *evidence.combined) if t.full), key=lambda t: t.excess)
    chosen = list(decision.alternatives)
    if decision.outcome == "unknown":
        chosen = [t for t in settled if t.drop > 0 and t.excess < criteria.search.close * settled[0].excess]
    if decision.outcome == "adequate":
        near = [t for t in settled if t.delta_bic >= criteria.delta_bic][:1]
        return {NOTHING: found.baseline.fitted, **_fits(found, near)} if near else {}
    return _fits(found, chosen[:_MOST]) if len(chosen) > 1 else {}


def _fits(found: SearchResult, trials: list[Trial]) -> dict[str, Fit]:
    return {" and ".join(t.effects): found.refits[t.effects].fitted for t in trials}
