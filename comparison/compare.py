"""Lay a model over a measurement: calibrate what is known only roughly, and say where it still fails."""

import math
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from updamp.comparison.comparison import (
    LACK_OF_FIT,
    MOVED_BY_NUMERICS,
    Backbone,
    Calibrated,
    Comparison,
    FeatureComparison,
    Finding,
    PointResidual,
)
from updamp.comparison.curves import curve_pairs
from updamp.comparison.findings.all_findings import all_findings
from updamp.comparison.findings.backbone import measured_backbones, model_backbones
from updamp.comparison.findings.findings import misfits
from updamp.comparison.findings.odd_points import odd_points
from updamp.comparison.findings.phase_lag import (
    PhaseLag,
    SensorLag,
    fitted_lag,
    lag_finding,
    phase_lag,
    read_lags,
    sensor_lag_finding,
    sensor_lags,
    without_phases,
)
from updamp.comparison.findings.stated_values import feature_findings
from updamp.comparison.findings.unlike_repeats import unlike_repeats
from updamp.comparison.fit.calibration import Calibration
from updamp.comparison.fit.compared import compare_at, predict_branches
from updamp.comparison.fit.fit import Fit
from updamp.comparison.fit.gated_calibration import GatedCalibration, gated_calibration
from updamp.comparison.fit.identified_shapes import with_shapes
from updamp.comparison.fit.lack_of_fit import lack_of_fit
from updamp.comparison.fit.numerical_gate import NumericalGate, finer_than
from updamp.comparison.fit.observations import Plan, plan_of
from updamp.comparison.fit.odd_readings import OddReading
from updamp.comparison.fit.repeat_scatter import of_repeats
from updamp.comparison.fit.scatter import Scatter, kinds_of
from updamp.comparison.fit.size_of_numerics import moved_frequencies
from updamp.comparison.prediction.branch_tasks import Branches, in_turn
from updamp.comparison.prediction.model_at import ModelAt
from updamp.comparison.prediction.parameters import Parametrisation
from updamp.comparison.prediction.predicted_branch import PredictedBranch, at_sizes
from updamp.effects.chosen import ChosenEffect
from updamp.effects.rig_model import RigModel
from updamp.effects.sized import sized
from updamp.hbm.newton.observe import ContactState, contact_states
from updamp.measurement.measurement import Measurement
from updamp.model.calibration import LOSS_FACTOR, nuisances, together_of_mode

Floats = NDArray[np.float64]
Complex = NDArray[np.complex128]
Progress = Callable[[str], None]

# Least share of the damping that is told as the material's. Where contacts make nearly all of it, the slope that it is
# read off is about nil, of either sign: what is told of the damping would be nil with a deviation of nil, or turned
# round.
_LEAST_SHARE = 0.02


@dataclass(frozen=True, eq=False)
class CalibrationResult:
    """What a comparison rests on, and all of it that takes long.

    plan, measured: what counts, and all that was measured
    given: the model as the rig file has it, with its numerical error
    before, after: branches of that and as calibrated, one a condition
    lag: fitted together with the calibration, None where measured phases do not ask for it
    sensor_lags: of those whose phases do not count, since they lag by themselves
    odd: points that do not count, since they are unlike those next to them
    """

    plan: Plan
    measured: Plan
    given: Parametrisation
    before: tuple[PredictedBranch, ...]
    fit: Fit
    after: tuple[PredictedBranch, ...]
    lag: PhaseLag | None = None
    sensor_lags: tuple[SensorLag, ...] = ()
    odd: tuple[OddReading, ...] = ()


def compare(
    model: RigModel,
    measurement: Measurement,
    features: Sequence[FeatureComparison] = (),
    provenance: Mapping[str, str] | None = None,
    progress: Progress = lambda _: None,
    finer: Mapping[str, RigModel] | None = None,
    rig_effects: Sequence[ChosenEffect] = (),
    branches_of: Branches = in_turn,
) -> tuple[Comparison, Fit | None]:
    """The comparison, and the calibration it rests on (None where only features were measured).

    finer: name -> model with finer numerics; what it changes counts as numerical error, not as misfit. That of more
        harmonics and time samples is made here
    rig_effects: effects of the rig file, which `model` and `finer` do not have yet
    branches_of: traces them, in this process or in others

    raises: BranchStoppedError where the model has no response at the beginning of a run
    """
    if not measurement.runs:
        return _of_features(measurement, features, provenance or {}), None
    calibrated = calibrate(model, measurement, progress, finer, rig_effects, branches_of)
    return comparison_of(calibrated, measurement, features, provenance), calibrated.fit


def calibrate(
    model: RigModel,
    measurement: Measurement,
    progress: Progress = lambda _: None,
    finer: Mapping[str, RigModel] | None = None,
    rig_effects: Sequence[ChosenEffect] = (),
    branches_of: Branches = in_turn,
) -> CalibrationResult:
    """As for `compare`, of a measurement with runs. Where all measured phases lag the model's by one angle or one time,
    together with that; where those of one sensor do, without them."""
    plan = with_shapes(plan_of(measurement), model, measurement.calibrated)
    plain = Parametrisation(model, nuisances(model), rig_effects=tuple(rig_effects))
    gate, everything = NumericalGate(plan, finer_than(model, finer or {}), branches_of), range(len(plan.conditions))
    first = gated_calibration(plain, gate, everything, None, progress)
    found = _with_curves(first, first.calibration, plan, progress, branches_of)
    of_tests = read_lags(found.fit, found.plan, found.after)
    read = phase_lag(of_tests)
    if read is None and (lags := sensor_lags(of_tests)):
        kept = without_phases(plan, lags)
        again = gated_calibration(plain, replace(gate, plan=kept), everything, None, progress)
        of_kept = _with_curves(again, again.calibration, kept, progress, branches_of)
        return replace(of_kept, measured=plan, sensor_lags=lags)
    if read is None:
        return found
    start = np.append(found.fit.u[: len(plain)], 0.0)
    lagging_by = sized(read.effect, model, plan.largest_amplitude)
    lagging = gated_calibration(replace(plain, effects=(lagging_by,)), gate, everything, start, progress).calibration
    return replace(_with_curves(first, lagging, plan, progress, branches_of), lag=fitted_lag(lagging.fit, read.effect))


def _with_curves(
    first: GatedCalibration, found: Calibration, plan: Plan, progress: Progress, branches_of: Branches
) -> CalibrationResult:
    """first: which began with the model as given"""
    fitted, counts = found.fit, found.rests_on(plan)
    progress("curves")
    after = predict_branches(fitted.parametrisation, fitted.u, counts, fitted.compared.branches, branches_of)
    moved = tuple(at_sizes(branch, fitted.u) for branch in after)
    return CalibrationResult(counts, plan, first.given, first.before, fitted, moved, odd=found.odd)


def comparison_of(
    calibrated: CalibrationResult,
    measurement: Measurement,
    features: Sequence[FeatureComparison] = (),
    provenance: Mapping[str, str] | None = None,
) -> Comparison:
    """The findings on a calibrated model, with the curves and numbers behind them."""
    plan, before, fitted, after = calibrated.plan, calibrated.before, calibrated.fit, calibrated.after
    given = calibrated.given
    as_given = compare_at(given, np.zeros(len(given)), plan, before, fitted.compared.scatter)
    names = {channel.point: channel.name for channel in measurement.channels}
    of_tests, of_model = measured_backbones(plan, names), model_backbones(plan, names, after)
    repeats = of_repeats(fitted, plan)
    found = _findings(calibrated, names, of_tests, of_model, repeats)
    return Comparison(
        title=measurement.title,
        adequate=not found,
        findings=found,
        calibration=calibrated_factors(fitted),
        calibrated_modes=calibrated_modes(fitted),
        curves=curve_pairs(calibrated.measured, names, before, after),
        residuals=tuple(_point_residuals(fitted, plan, names)),
        measured_backbones=of_tests,
        model_backbones=of_model,
        features=tuple(features),
        scatter=_scatter_of(fitted),
        chi2_before=as_given.chi2,
        chi2_after=fitted.compared.chi2,
        values=fitted.compared.values,
        parameters=len(fitted.u),
        contact_states=_states_of_tests(fitted, plan, after),
        assumptions=measurement.stated,
        provenance={**(provenance or {}), **_provenance(fitted, plan)},
        level_unit=plan.conditions[0].unit,
        response_unit=measurement.units[0],
        force_unit=measurement.units[1],
        unlike_repeats=unlike_repeats(fitted.compared, repeats, plan),
        odd_points=odd_points(calibrated.odd, plan, names),
        questions=measurement.questions,
        checks=_of_repeatability(plan),
    )


def _scatter_of(fitted: Fit) -> dict[str, float]:
    """By name, of what there is in this measurement."""
    compared = fitted.compared
    there = kinds_of(compared.assemblies)
    return {name: size for name, size in compared.scatter.as_numbers().items() if name in there}


def _of_repeatability(plan: Plan) -> tuple[str, ...]:
    if not plan.rougher_than_stated:
        return ()
    stated, own = (f"{100 * each:.2g} %" for each in (plan.repeatability, plan.own_noise))
    return (
        f"repeatability = {plan.repeatability:g}: {stated} is stated, and the points of the runs scatter by {own} by "
        "themselves, which counts in its place",
    )


def _findings(
    calibrated: CalibrationResult,
    names: Mapping[str, str],
    of_tests: Sequence[Backbone],
    of_model: Sequence[Backbone],
    repeats: Scatter,
) -> tuple[Finding, ...]:
    """Lags of phases first, where there are any."""
    plan, fitted, after = calibrated.plan, calibrated.fit, calibrated.after
    loss_factor = fitted.parametrisation.names.index(LOSS_FACTOR.name)
    first_order = misfits(fitted, plan, [damping_share(b, loss_factor) for b in after])
    told = all_findings(fitted, plan, after, first_order, names, of_tests, of_model, repeats)
    of_sensors = tuple(sensor_lag_finding(one, names) for one in calibrated.sensor_lags)
    return (*of_sensors, *told) if calibrated.lag is None else (lag_finding(calibrated.lag), *told)


def _provenance(fitted: Fit, plan: Plan) -> dict[str, str]:
    moved = moved_frequencies(fitted.parametrisation.numerics, plan)
    by_chance = {"calibration": fitted.message, LACK_OF_FIT: f"{lack_of_fit(fitted, plan):.3g}"}
    return {**({MOVED_BY_NUMERICS: moved} if moved else {}), **by_chance}


def _of_features(
    measurement: Measurement, features: Sequence[FeatureComparison], provenance: Mapping[str, str]
) -> Comparison:
    found, nan = feature_findings(features), float("nan")
    return Comparison(
        title=measurement.title,
        adequate=not found,
        findings=found,
        calibration=(),
        curves=(),
        residuals=(),
        measured_backbones=(),
        model_backbones=(),
        features=tuple(features),
        scatter={},
        chi2_before=nan,
        chi2_after=nan,
        values=0,
        parameters=0,
        contact_states={},
        assumptions=measurement.stated,
        provenance=provenance,
        questions=measurement.questions,
    )


def damping_share(branch: PredictedBranch, loss_factor: int) -> float:
    """The material's share of the damping at the branch's highest point: how much the amplitude there answers to it."""
    top = int(np.argmax(np.abs(branch.amplitude[:, 0])))
    slope = branch.at(branch.place[[top]]).slopes[0, loss_factor, 1]
    return float(np.clip(-slope, _LEAST_SHARE, 1.0))


def calibrated_factors(fitted: Fit) -> tuple[Calibrated, ...]:
    """As factors on the rig file's values."""
    entries = []
    for n, u, s in zip(fitted.parametrisation.nuisances, fitted.u, fitted.uncertainty, strict=False):
        entries.append(_calibrated(n.name, n.deviation, float(u), float(s)))
    return tuple(entries)


def calibrated_modes(fitted: Fit) -> tuple[Calibrated, ...]:
    """Of each mode of a rig given by several, what the factors on all and on this one alone are together."""
    known = fitted.parametrisation.nuisances
    entries = []
    for name, places in together_of_mode([n.name for n in known], fitted.parametrisation.base.modes).items():
        deviation = math.hypot(*(known[i].deviation for i in places))
        u = float(fitted.u[list(places)].sum())
        entries.append(_calibrated(name, deviation, u, fitted.uncertainty_of_sum(places)))
    return tuple(entries)


def _calibrated(name: str, prior_deviation: float, u: float, deviation: float) -> Calibrated:
    """As a factor; u, deviation: of its logarithm"""
    after, lower, upper = (float(np.exp(u + z * deviation)) for z in (0.0, -1.96, 1.96))
    return Calibrated(name, "", 1.0, prior_deviation, after, lower, upper)


def _point_residuals(fitted: Fit, plan: Plan, names: Mapping[str, str]) -> list[PointResidual]:
    """What is left at every point with its assembly's offsets taken into account, in deviations of the sensors."""
    found = []
    for m in fitted.compared.matched:
        o, condition = m.observations, plan.conditions[m.observations.test]
        left = m.difference / (o.noise * fitted.compared.scatter.noise)
        for j, (point, _) in enumerate(condition.sensors):
            amplitude, phase = left[:, 1 + 2 * j], left[:, 2 + 2 * j]
            known = 1 + np.isfinite(o.noise[:, 2 + 2 * j])
            size = np.hypot(amplitude, phase) / np.sqrt(known)
            found += [
                PointResidual(
                    condition.name, condition.mode, condition.level, o.repeat, names[point], *map(float, values)
                )
                for values in zip(o.frequency, amplitude, phase, size, strict=True)
            ]
    return found


def _states_of_tests(
    fitted: Fit, plan: Plan, branches: Sequence[PredictedBranch]
) -> dict[str, tuple[float, float, float, float]]:
    """By mode, level and direction of the sweep; none of a model without contacts."""
    if fitted.parametrisation.base.contacts is None:
        return {}
    return {
        f"{c.mode} {c.level_name} {'up' if c.upwards else 'down'}": _states(fitted.parametrisation, fitted.u, branch)
        for c, branch in zip(plan.conditions, branches, strict=True)
    }


def _states(parametrisation: Parametrisation, u: Floats, branch: PredictedBranch) -> tuple[float, float, float, float]:
    """Shares of the contacts that stick, slip, separate or stay open, at the highest point of the first sensor."""
    point = branch.points[int(np.argmax(np.abs(branch.amplitude[:, 0])))]
    there = ModelAt(parametrisation, u).at(branch.condition)
    states = contact_states(there.model.system, there.whole(point.x), point.w)
    stuck, slipping, separating, never = (float(np.mean(states == kind)) for kind in ContactState)
    return stuck, slipping, separating, never
