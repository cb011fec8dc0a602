"""The measurement that would tell the surviving explanations apart best, per hour of testing.

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

from updamp.diagnosis.model.numerical_error import NumericalError
from updamp.diagnosis.model.parameters import PRELOAD
from updamp.diagnosis.model.predicted_branch import trace_branch
from updamp.diagnosis.model.workers import Workers, here
from updamp.diagnosis.residual.fit import Fit
from updamp.diagnosis.residual.observations import Plan
from updamp.diagnosis.search.attempts import without_branches
from updamp.diagnosis.search.candidate_runs import CandidateRun, Recording, candidate_runs
from updamp.diagnosis.search.separation import Prediction, separation
from updamp.diagnosis.verdict import NextMeasurement
from updamp.hbm.continuation import BranchStoppedError, ContinuationOptions

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
    raises: ValueError where a mode has no sensor with the first harmonic
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


def _measurement(pair: tuple[str, str], one: Prediction, other: Prediction, recording: Recording) -> NextMeasurement:
    apart = separation(one, other, recording.sensors)
    a, b = pair
    if apart < _NOTHING:
        sentence = f"no run that was looked at tells {a} from {b}; the best is to {recording.what}"
    elif apart < DECIDES:
        sentence = f"{recording.what}: a hint at most, {a} and {b} would lie {apart:.1f} standard deviations apart"
    else:
        sentence = f"{recording.what}: {a} and {b} would lie {apart:.3g} standard deviations apart"
    return NextMeasurement(sentence, pair, apart, recording.hours)


def _noise(plan: Plan) -> dict[str, float]:
    """Point -> relative standard deviation of its first harmonic in the plan; under "" that of all points."""
    values: dict[str, list[float]] = {}
    for o in plan.observations:
        for j, (point, k) in enumerate(plan.conditions[o.test].sensors):
            if k == 1:
                values.setdefault(point, []).append(float(np.median(o.noise[:, 1 + 2 * j])))
    noise = {point: float(np.median(each)) for point, each in values.items()}
    return {**noise, "": float(np.median(list(noise.values())))} if noise else noise


def _prediction(
    shared: tuple[Mapping[str, Fit], Mapping[str, float]], wanted: tuple[CandidateRun, str]
) -> Prediction | None:
    """None where the model has no response there. shared: explanations, and noise; wanted: run, and whose prediction"""
    (fits, noise), (run, name) = shared, wanted
    fit = fits[name]
    n = fit.parametrisation.n_of_model
    parametrisation = replace(fit.parametrisation, numerics=NumericalError())
    u = fit.u[:n].copy()
    if run.load != 1:
        u[parametrisation.names.index(PRELOAD.name)] += np.log(run.load)
    try:
        branch = trace_branch(parametrisation, u, run.condition, _FINE)
    except BranchStoppedError:
        return None
    names = tuple(nuisance.name for nuisance in parametrisation.nuisances)
    return Prediction(branch, fit.covariance[:n, :n], names, fit.compared.scatter, noise)
