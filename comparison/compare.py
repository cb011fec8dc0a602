"""Lay a model over a measurement: calibrate what is known only roughly, and say where it still fails."""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray

from updamp.comparison import correlation
from updamp.comparison.comparison import (
    Backbone,
    Calibrated,
    Comparison,
    CurvePair,
    FeatureComparison,
    MeasuredCurve,
    ModelCurve,
    PointResidual,
)
from updamp.comparison.findings.all_findings import all_findings
from updamp.comparison.findings.backbone import backbone
from updamp.comparison.findings.findings import lack_of_fit, misfits
from updamp.comparison.findings.stated_values import feature_findings
from updamp.comparison.fit.fit import Fit, FitOptions, compare_at, fit, predict
from updamp.comparison.fit.numerical_gate import gated
from updamp.comparison.fit.observations import Observations, Plan, plan_of
from updamp.comparison.prediction.branch_tasks import Branches, in_turn
from updamp.comparison.prediction.parameters import Parametrisation
from updamp.comparison.prediction.predicted_branch import PredictedBranch, at_sizes, with_patterns
from updamp.effects.chosen import ChosenEffect
from updamp.effects.rig_model import RigModel
from updamp.hbm.newton.observe import ContactState, contact_states
from updamp.measurement.measurement import Measurement
from updamp.model.calibration import LOSS_FACTOR

Floats = NDArray[np.float64]
Complex = NDArray[np.complex128]
Progress = Callable[[str], None]

_MOST_POINTS = 400  # of a model's curve in the report


@dataclass(frozen=True)
class CompareOptions:
    """harmonics: compared where they were measured; fit: of the calibration"""

    harmonics: tuple[int, ...] = (1,)
    fit: FitOptions = field(default_factory=FitOptions)


@dataclass(frozen=True, eq=False)
class CalibrationResult:
    """What a comparison rests on, and all of it that takes long.

    before, after: branches as the rig file has the model and as calibrated, one a condition
    """

    plan: Plan
    before: tuple[PredictedBranch, ...]
    fit: Fit
    after: tuple[PredictedBranch, ...]


def compare(
    model: RigModel,
    measurement: Measurement,
    features: Sequence[FeatureComparison] = (),
    provenance: Mapping[str, str] | None = None,
    options: CompareOptions | None = None,
    progress: Progress = lambda _: None,
    finer: Mapping[str, RigModel] | None = None,
    taken: Sequence[ChosenEffect] = (),
    branches_of: Branches = in_turn,
) -> tuple[Comparison, Fit | None]:
    """The comparison, and the calibration it rests on (None where only features were measured).

    finer: name -> model with finer numerics; what it changes counts as numerical error, not as misfit. That of more
        harmonics and time samples is made here
    taken: effects of the rig file, which `model` and `finer` do not have yet
    branches_of: traces them, in this process or in others

    raises: BranchStoppedError where the model has no response at the beginning of a run
    """
    if not measurement.runs:
        return _of_features(measurement, features, provenance or {}), None
    calibrated = calibrate(model, measurement, options, progress, finer, taken, branches_of)
    return comparison_of(calibrated, measurement, features, provenance), calibrated.fit


def calibrate(
    model: RigModel,
    measurement: Measurement,
    options: CompareOptions | None = None,
    progress: Progress = lambda _: None,
    finer: Mapping[str, RigModel] | None = None,
    taken: Sequence[ChosenEffect] = (),
    branches_of: Branches = in_turn,
) -> CalibrationResult:
    """As for `compare`, of a measurement with runs."""
    options = options or CompareOptions()
    plan = plan_of(measurement, options.harmonics)
    parametrisation, plain = gated(model, taken, plan, finer or {}, progress, branches_of)
    start = np.zeros(len(parametrisation))
    before = tuple(with_patterns(branch, parametrisation.numerics) for branch in plain)
    del plain
    fitted = fit(parametrisation, plan, start, None, before, options.fit, progress, branches_of)
    progress("curves")
    after = predict(parametrisation, fitted.u, plan, fitted.compared.branches, branches_of)
    return CalibrationResult(plan, before, fitted, tuple(at_sizes(branch, fitted.u) for branch in after))


def comparison_of(
    calibrated: CalibrationResult,
    measurement: Measurement,
    features: Sequence[FeatureComparison] = (),
    provenance: Mapping[str, str] | None = None,
) -> Comparison:
    """What is said of a calibrated model."""
    plan, before, fitted, after = calibrated.plan, calibrated.before, calibrated.fit, calibrated.after
    parametrisation = fitted.parametrisation
    start = np.zeros(len(parametrisation))
    as_given = compare_at(parametrisation, start, plan, before, fitted.compared.scatter)
    loss_factor = parametrisation.names.index(LOSS_FACTOR.name)
    names = {channel.point: channel.name for channel in measurement.channels}
    of_tests, of_model = _measured_backbones(plan, names), _model_backbones(plan, names, after)
    first_order = misfits(fitted, plan, [damping_share(b, loss_factor) for b in after])
    said = all_findings(fitted, plan, after, first_order, names, of_tests, of_model)
    return Comparison(
        title=measurement.title,
        adequate=not said,
        findings=said,
        calibration=calibration(fitted),
        curves=tuple(
            _pair(plan, i, j, names, before[i], after[i])
            for i, condition in enumerate(plan.conditions)
            for j in range(len(condition.sensors))
        ),
        residuals=tuple(_point_residuals(fitted, plan, names)),
        measured_backbones=of_tests,
        model_backbones=of_model,
        features=tuple(features),
        scatter=fitted.compared.scatter.as_numbers(),
        chi2_before=as_given.chi2,
        chi2_after=fitted.compared.chi2,
        values=fitted.compared.values,
        parameters=len(fitted.u),
        contact_states={
            f"{c.mode} {c.level_name} {'up' if c.upwards else 'down'}": _states(parametrisation, fitted.u, b)
            for c, b in zip(plan.conditions, after, strict=True)
            if parametrisation.base.contacts is not None
        },
        assumptions=measurement.assumptions,
        provenance={**(provenance or {}), "calibration": fitted.message, "lack of fit": f"{lack_of_fit(fitted):.3g}"},
        level_unit=plan.conditions[0].unit,
    )


def _of_features(
    measurement: Measurement, features: Sequence[FeatureComparison], provenance: Mapping[str, str]
) -> Comparison:
    said, nan = feature_findings(features), float("nan")
    return Comparison(
        measurement.title, not said, said, (), (), (), (), (), tuple(features), {}, nan, nan, 0, 0, {},
        measurement.assumptions, provenance,
    )  # fmt: skip


def damping_share(branch: PredictedBranch, loss_factor: int) -> float:
    """The material's share of the damping at the branch's highest point: how much the amplitude there answers to it."""
    top = int(np.argmax(np.abs(branch.amplitude[:, 0])))
    answer = branch.at(branch.place[[top]]).slopes[0, loss_factor, 1]
    return float(np.clip(-answer, 0.02, 1.0))


def calibration(fitted: Fit) -> tuple[Calibrated, ...]:
    """As factors on the rig file's values."""
    entries = []
    for n, u, s in zip(fitted.parametrisation.nuisances, fitted.u, fitted.uncertainty, strict=False):
        after, lower, upper = (float(np.exp(u + z * s)) for z in (0.0, -1.96, 1.96))
        entries.append(Calibrated(n.name, "", 1.0, n.deviation, after, lower, upper))
    return tuple(entries)


def _receptance(observed: Floats, log_force: Floats, force: float, sensor: int) -> Complex:
    return np.asarray(np.exp(observed[:, 1 + 2 * sensor] + 1j * observed[:, 2 + 2 * sensor] - log_force) / force)


def _pair(
    plan: Plan,
    test: int,
    sensor: int,
    names: Mapping[str, str],
    before: PredictedBranch,
    after: PredictedBranch,
) -> CurvePair:
    condition = plan.conditions[test]
    runs = [o for o in plan.observations if o.test == test]
    measured = tuple(
        MeasuredCurve(
            o.repeat,
            o.frequency,
            _receptance(o.observed, o.log_force, condition.force, sensor),
            condition.force * np.exp(o.log_force),
        )
        for o in runs
    )
    curve = _model_curve(after, sensor)
    at_measured = [_on_sweep(curve, m.frequency) for m in measured]
    z, y = np.concatenate([m.receptance for m in measured]), np.concatenate(at_measured)
    of_all_sensors = _all_sensors(plan, test, after)
    point, k = condition.sensors[sensor]
    return CurvePair(
        run=condition.name,
        mode=condition.mode,
        level=condition.level,
        upwards=condition.upwards,
        channel=names[point] if k == 1 else f"{names[point]}, harmonic {k}",
        measured=measured,
        band=_band(measured),
        before=_model_curve(before, sensor),
        after=curve,
        frac=correlation.frac(z, y),
        csac=correlation.csac(*of_all_sensors),
        csf=correlation.csf(*of_all_sensors),
    )


def _all_sensors(plan: Plan, test: int, branch: PredictedBranch) -> tuple[Complex, Complex]:
    """Measured and model receptances (n, n_sensors) at the measured frequencies."""
    condition = plan.conditions[test]
    sensors = range(len(condition.sensors))
    curves = [_model_curve(branch, j) for j in sensors]
    measured, model = [], []
    for o in (o for o in plan.observations if o.test == test):
        measured.append(np.stack([_receptance(o.observed, o.log_force, condition.force, j) for j in sensors], axis=1))
        model.append(np.stack([_on_sweep(curve, o.frequency) for curve in curves], axis=1))
    return np.concatenate(measured), np.concatenate(model)


def _model_curve(branch: PredictedBranch, sensor: int) -> ModelCurve:
    place = np.linspace(branch.place[0], branch.place[-1], min(_MOST_POINTS, 8 * len(branch.place)))
    observed = branch.at(place).value
    near = np.searchsorted(branch.place, place, side="right") - 1
    near = np.clip(near, 0, len(branch.place) - 2)
    visited = branch.visited[near] & branch.visited[near + 1]
    receptance = _receptance(observed, np.zeros(len(place)), branch.condition.force, sensor)
    return ModelCurve(np.exp(observed[:, 0]), receptance, visited)


def _on_sweep(curve: ModelCurve, frequency: Floats) -> Complex:
    """The visited part at given frequencies."""
    f, z = curve.frequency[curve.visited], curve.receptance[curve.visited]
    order = np.argsort(f)
    return np.asarray(
        np.interp(frequency, f[order], z[order].real) + 1j * np.interp(frequency, f[order], z[order].imag)
    )


def _band(measured: Sequence[MeasuredCurve]) -> Floats:
    """(n, 3) from the spread of the repeats, as that of the logarithm of the receptance at a frequency."""
    if len(measured) < 2:
        return np.zeros((0, 3))
    frequency = np.sort(measured[0].frequency)
    logs = []
    for m in measured:
        order = np.argsort(m.frequency)
        logs.append(np.interp(frequency, m.frequency[order], np.log(np.abs(m.receptance[order]))))
    mean, spread = np.mean(logs, axis=0), np.std(logs, axis=0, ddof=1)
    return np.column_stack([frequency, np.exp(mean - 1.96 * spread), np.exp(mean + 1.96 * spread)])


def _point_residuals(fitted: Fit, plan: Plan, names: Mapping[str, str]) -> list[PointResidual]:
    """What is left at every point with its assembly's offsets taken into account, in deviations of the sensors."""
    found = []
    for m in fitted.compared.matched:
        o, condition = m.observations, plan.conditions[m.observations.test]
        left = m.difference / (o.noise * fitted.compared.scatter.noise)
        for j, (point, _) in enumerate(condition.sensors):
            amplitude, phase = left[:, 1 + 2 * j], left[:, 2 + 2 * j]
            size = np.hypot(amplitude, phase) / np.sqrt(2)
            found += [
                PointResidual(
                    condition.name, condition.mode, condition.level, o.repeat, names[point], *map(float, values)
                )
                for values in zip(o.frequency, amplitude, phase, size, strict=True)
            ]
    return found


def _measured_backbones(plan: Plan, names: Mapping[str, str]) -> tuple[Backbone, ...]:
    return _backbones(
        plan,
        names,
        lambda o, j: (
            o.repeat,
            o.frequency,
            _receptance(o.observed, o.log_force, plan.conditions[o.test].force, j),
            plan.conditions[o.test].force * np.exp(o.log_force),
        ),
        plan.observations,
    )


def _backbones(
    plan: Plan,
    names: Mapping[str, str],
    curve: Callable[[Observations, int], tuple[int, Floats, Complex, Floats]],
    runs: Sequence[Observations],
) -> tuple[Backbone, ...]:
    found = []
    for mode in dict.fromkeys(c.mode for c in plan.conditions):
        of_mode = [o for o in runs if plan.conditions[o.test].mode == mode]
        sensors = [s for s in plan.conditions[of_mode[0].test].sensors if s[1] == 1]
        for point, k in sensors:
            entries = []
            for o in of_mode:
                condition = plan.conditions[o.test]
                repeat, f, z, force = curve(o, condition.sensors.index((point, k)))
                entries.append((condition.level, repeat, f, z, force))
            found.append(backbone(mode, names[point], entries))
    return tuple(found)


def _model_backbones(plan: Plan, names: Mapping[str, str], branches: Sequence[PredictedBranch]) -> tuple[Backbone, ...]:
    first = [next(o for o in plan.observations if o.test == i) for i in range(len(plan.conditions))]

    def curve(o: Observations, sensor: int) -> tuple[int, Floats, Complex, Floats]:
        whole = _model_curve(branches[o.test], sensor)
        # beyond the window that was measured the branch may climb to another mode's resonance
        low, high = plan.conditions[o.test].window
        measured = whole.visited & (whole.frequency >= low) & (whole.frequency <= high)
        shown = measured if measured.any() else whole.visited
        f, z = whole.frequency[shown], whole.receptance[shown]
        return 0, f, z, np.full(len(f), plan.conditions[o.test].force)

    return _backbones(plan, names, curve, first)


def _states(parametrisation: Parametrisation, u: Floats, branch: PredictedBranch) -> tuple[float, float, float, float]:
    """Shares of the contacts that stick, slip, separate or stay open, at the highest point of the first sensor."""
    point = branch.points[int(np.argmax(np.abs(branch.amplitude[:, 0])))]
    system = parametrisation.model(u).system
    states = contact_states(system, point.x, point.w)
    stuck, slipping, separating, never = (float(np.mean(states == kind)) for kind in ContactState)
    return stuck, slipping, separating, never
