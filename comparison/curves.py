"""Measured and predicted receptances side by side, run by run and channel by channel, and how alike they are.

The correlation numbers are those that test engineers know from correlating models with frequency responses; secondary
here, since none of them knows how well the measurement repeats. FRAC: P. Avitabile, "Experimental modal analysis",
2001; CSAC and CSF: H. Grafe, "Model updating of large structural dynamics models using measured response functions",
PhD thesis, Imperial College, 1998, eqs. 3.14 and 3.17.
"""

from collections.abc import Mapping, Sequence

import numpy as np
from numpy.typing import NDArray

from updamp.comparison.comparison import CurvePair, MeasuredCurve, ModelCurve
from updamp.comparison.fit.observations import Plan
from updamp.comparison.prediction.predicted_branch import PredictedBranch

Floats = NDArray[np.float64]
Complex = NDArray[np.complex128]

_MOST_POINTS = 400  # of a model's curve in the report


def curve_pairs(
    plan: Plan, names: Mapping[str, str], before: Sequence[PredictedBranch], after: Sequence[PredictedBranch]
) -> tuple[CurvePair, ...]:
    """Every test at every sensor.

    names: of the channels, by point of the model; before, after: branches, one a test, as given and calibrated
    """
    return tuple(
        _curve_pair(plan, i, j, names, before[i], after[i])
        for i, condition in enumerate(plan.conditions)
        for j in range(len(condition.sensors))
    )


def _curve_pair(
    plan: Plan,
    test: int,
    sensor: int,
    names: Mapping[str, str],
    before: PredictedBranch,
    after: PredictedBranch,
) -> CurvePair:
    """One test at one sensor, all repeats: their places in the plan and in the condition."""
    condition = plan.conditions[test]
    measured = _measured_curves(plan, test, sensor)
    curve = model_curve(after, sensor)
    at_measured = [_on_sweep(curve, m.frequency) for m in measured]
    z, y = np.concatenate([m.receptance for m in measured]), np.concatenate(at_measured)
    all_z, all_y = _all_sensors(plan, test, after)
    if not all(m.has_phase for m in measured):  # then how alike amplitudes are
        z, y, all_z, all_y = (np.abs(part) + 0j for part in (z, y, all_z, all_y))
    return CurvePair(
        run=condition.name,
        mode=condition.mode,
        level=condition.level,
        upwards=condition.upwards,
        channel=names[condition.sensors[sensor][0]],
        measured=measured,
        band=_band(measured),
        before=model_curve(before, sensor),
        after=curve,
        frac=frac(z, y),
        csac=csac(all_z, all_y),
        csf=csf(all_z, all_y),
    )


def _measured_curves(plan: Plan, test: int, sensor: int) -> tuple[MeasuredCurve, ...]:
    """One a repeat."""
    force = plan.conditions[test].force
    return tuple(
        MeasuredCurve(
            o.repeat,
            o.frequency,
            receptance_of(o.observed, o.log_force, force, sensor),
            force * np.exp(o.log_force),
            o.has_phase(sensor),
        )
        for o in plan.observations
        if o.test == test
    )


def receptance_of(observed: Floats, log_force: Floats, force: float, sensor: int) -> Complex:
    """(n,) [m/N] from what is observed (n, 1 + 2 n_sensors); log_force: (n,) of the measured force over `force` [N]"""
    return np.asarray(np.exp(observed[:, 1 + 2 * sensor] + 1j * observed[:, 2 + 2 * sensor] - log_force) / force)


def model_curve(branch: PredictedBranch, sensor: int) -> ModelCurve:
    """The whole branch at one sensor, densely; sensor: its place in the condition"""
    place = np.linspace(branch.place[0], branch.place[-1], min(_MOST_POINTS, 8 * len(branch.place)))
    observed = branch.at(place).value
    near = np.searchsorted(branch.place, place, side="right") - 1
    near = np.clip(near, 0, len(branch.place) - 2)
    visited = branch.seen[near]
    receptance = receptance_of(observed, np.zeros(len(place)), branch.condition.force, sensor)
    return ModelCurve(np.exp(observed[:, 0]), receptance, visited)


def _all_sensors(plan: Plan, test: int, branch: PredictedBranch) -> tuple[Complex, Complex]:
    """Measured and model receptances (n, n_sensors) at the measured frequencies."""
    condition = plan.conditions[test]
    sensors = range(len(condition.sensors))
    curves = [model_curve(branch, j) for j in sensors]
    measured, model = [], []
    for o in (o for o in plan.observations if o.test == test):
        measured.append(np.stack([receptance_of(o.observed, o.log_force, condition.force, j) for j in sensors], axis=1))
        model.append(np.stack([_on_sweep(curve, o.frequency) for curve in curves], axis=1))
    return np.concatenate(measured), np.concatenate(model)


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


def frac(measured: Complex, model: Complex) -> float:
    """Frequency response assurance criterion of one response over frequency, 0 to 1: (n,) each."""
    return float(np.abs(np.vdot(measured, model)) ** 2 / (np.vdot(measured, measured) * np.vdot(model, model)).real)


def csac(measured: Complex, model: Complex) -> float:
    """Cross signature assurance criterion of all responses at each frequency, its mean over them: (n, n_channels)."""
    cross = np.abs(np.sum(measured.conj() * model, axis=1)) ** 2
    return float(np.mean(cross / (np.sum(np.abs(measured) ** 2, axis=1) * np.sum(np.abs(model) ** 2, axis=1))))


def csf(measured: Complex, model: Complex) -> float:
    """Cross signature scale factor, the sensitivity to scale that CSAC lacks, its mean: (n, n_channels)."""
    cross = 2 * np.abs(np.sum(measured.conj() * model, axis=1))
    return float(np.mean(cross / (np.sum(np.abs(measured) ** 2, axis=1) + np.sum(np.abs(model) ** 2, axis=1))))
