"""A comparison of two friction-softened modes, for tests of what shows it: the arithmetic is real, the rig is not.

Each mode is one degree of freedom with a Jenkins element (spring and slider in series) in parallel and a stiffness
that falls with amplitude, both by their describing functions, so the response at a force level is known in closed
form, turning points included.
"""

from collections.abc import Iterator
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from updamp.comparison.comparison import (
    Backbone,
    Calibrated,
    Comparison,
    CurvePair,
    FeatureComparison,
    Finding,
    MeasuredCurve,
    ModelCurve,
    PointResidual,
)

Floats = NDArray[np.float64]
LEVELS = (0.096, 0.32, 0.96, 5.0, 17.0)  # N
CHANNELS = {"tip_left": 0.93, "tip_right": -1.0}  # modal amplitudes
DRIFT, FRICTION, GAIN, NOISE = 3e-4, 0.04, 0.008, 0.004  # relative standard deviations


@dataclass(frozen=True)
class Oscillator:
    """name: of the mode; mass [kg]; stuck: frequency [Hz]; share: of the stuck stiffness that the slider carries;
    slip: displacement at which it slips [m]; softening: relative loss of stiffness at 1 mm; loss_factor [-]"""

    name: str
    mass: float
    stuck: float
    share: float
    slip: float
    softening: float
    loss_factor: float

    def stiffness(self, amplitude: Floats) -> Floats:
        """In phase with the displacement [N/m]"""
        stuck = self.mass * (2 * np.pi * self.stuck) ** 2
        angle = np.arccos(1 - 2 * np.minimum(self.slip / amplitude, 1))
        slider = self.share * stuck * (angle - np.sin(2 * angle) / 2) / np.pi
        return (1 - self.share) * stuck + slider - stuck * self.softening * np.tanh(amplitude / 1e-3) ** 2

    def damping(self, amplitude: Floats) -> Floats:
        """In quadrature [N/m]"""
        stuck = self.mass * (2 * np.pi * self.stuck) ** 2
        ratio = np.minimum(self.slip / amplitude, 1)
        return stuck * (self.loss_factor + self.share * 4 / np.pi * ratio * (1 - ratio))

    def resonance(self, amplitude: Floats) -> Floats:
        return np.sqrt(self.stiffness(amplitude) / self.mass) / (2 * np.pi)

    def branch(
        self, force: float, window: tuple[float, float], points: int = 200
    ) -> tuple[Floats, NDArray[np.complex128]]:
        """Frequency [Hz] and displacement per force [m/N], from low frequency over the peak to high frequency."""
        amplitude = np.geomspace(1e-9, 1e-1, 40_000)
        square = (force / amplitude) ** 2 - self.damping(amplitude) ** 2
        amplitude = amplitude[: np.argmax(square < 0)]
        amplitude = amplitude[-1] * np.concatenate([np.geomspace(0.004, 0.5, 1500), 1 - np.geomspace(0.5, 1e-9, 1500)])
        root = np.sqrt(np.maximum((force / amplitude) ** 2 - self.damping(amplitude) ** 2, 0))
        detuning = np.concatenate([root, -root[::-1]])
        amplitude = np.concatenate([amplitude, amplitude[::-1]])
        frequency = np.sqrt(np.maximum(self.stiffness(amplitude) - detuning, 0) / self.mass) / (2 * np.pi)
        receptance = 1 / (detuning + 1j * self.damping(amplitude))
        inside = (frequency > window[0]) & (frequency < window[1])
        frequency, receptance = frequency[inside], receptance[inside]
        length = np.hypot(
            np.diff(frequency) / np.ptp(frequency), np.diff(np.abs(receptance)) / np.abs(receptance).max()
        )
        along = np.concatenate([[0], np.cumsum(length)])
        at = np.linspace(0, along[-1], points)
        return np.interp(at, along, frequency), np.interp(at, along, receptance.real) + 1j * np.interp(
            at, along, receptance.imag
        )


TRUTH = (
    Oscillator("IP", 0.9, 393.0, 0.13, 6e-6, 0.055, 0.004),
    Oscillator("OOP", 0.8, 435.9, 0.04, 2.5e-6, 0.02, 0.0035),
)
BEFORE = (replace(TRUTH[0], stuck=424.0, slip=8e-6), replace(TRUTH[1], stuck=440.3, slip=3e-6, loss_factor=0.0022))
AFTER = (replace(TRUTH[0], stuck=393.6), replace(TRUTH[1], loss_factor=0.0022))


def visited(frequency: Floats, upwards: bool) -> NDArray[np.bool_]:
    """What a slow sweep sees: it jumps over whatever it would have to turn back for."""
    if upwards:
        return frequency >= np.maximum.accumulate(frequency)
    return frequency <= np.minimum.accumulate(frequency[::-1])[::-1]


def synthetic_comparison(
    levels: tuple[float, ...] = LEVELS, repeats: int = 3, points: int = 40, sweeps: tuple[bool, ...] = (True,)
) -> Comparison:
    """Two modes at each level, sweep and of `CHANNELS`; the calibrated model has too little damping in OOP."""
    generator = np.random.default_rng(7)
    curves = tuple(_curves(generator, levels, repeats, points, sweeps))
    residuals = tuple(residual for curve in curves for residual in _residuals(curve))
    size = np.array([residual.size for residual in residuals])
    return Comparison(
        title="Double-beam rig with wedge damper: synthetic laboratory",
        adequate=False,
        findings=_findings(),
        calibration=_calibration(),
        curves=curves,
        residuals=residuals,
        measured_backbones=tuple(_measured_backbones(curves)),
        model_backbones=tuple(_model_backbones(levels)),
        features=_features(),
        scatter={"sliding_friction": FRICTION, "frequency drift": DRIFT, "sensor gain": GAIN, "sensor noise": 1.08},
        chi2_before=31.0 * size.size * 2,
        chi2_after=float(np.sum(size**2)) * 2,
        values=size.size * 2,
        parameters=5,
        contact_states=_contact_states(levels),
        assumptions=(
            "The sign of tip_left is not stated: read as positive along x.",
            "Amplitudes are not said to be peak or RMS: read as peak.",
        ),
        provenance={
            "Rig": "rigs/double_beam.toml, SHA-256 3f5a90be21c4",
            "Measurement": "measurement.toml, SHA-256 90be21c43f5a",
            "Versions": "updamp 0.1.0, numpy 2.4.6, jax 0.10.0",
        },
    )


def features_only() -> Comparison:
    """Stated values and nothing else, as from a paper."""
    full = synthetic_comparison(levels=(0.96,), repeats=1, points=5)
    return replace(
        full, curves=(), residuals=(), measured_backbones=(), model_backbones=(), scatter={}, calibration=(),
        contact_states={}, values=4, parameters=0, chi2_before=6410.0, chi2_after=6410.0,
    )  # fmt: skip


def _curves(
    generator: np.random.Generator, levels: tuple[float, ...], repeats: int, points: int, sweeps: tuple[bool, ...]
) -> Iterator[CurvePair]:
    for truth, before, after in zip(TRUTH, BEFORE, AFTER, strict=True):
        for level in levels:
            peak = truth.resonance(np.array([_peak_amplitude(truth, level)]))[0]
            window = (0.955 * peak, 1.035 * peak)
            wide = (0.92 * peak, 1.1 * peak)
            for upwards in sweeps:
                seen = [_assembly(generator, truth) for _ in range(repeats)]
                for channel, modal in CHANNELS.items():
                    measured = tuple(
                        _measure(generator, rig, modal, level, upwards, window, points, number + 1)
                        for number, rig in enumerate(seen)
                    )
                    pair = [_model(rig, modal, level, upwards, wide) for rig in (before, after)]
                    yield CurvePair(
                        f"{truth.name.lower()}_{level:g}N_{'up' if upwards else 'down'}", truth.name, level, upwards,
                        channel, measured, _band(measured), pair[0], pair[1], 0.981, 0.974, 0.912,
                    )  # fmt: skip


def _peak_amplitude(rig: Oscillator, force: float) -> float:
    amplitude = np.geomspace(1e-9, 1e-1, 20_000)
    return float(amplitude[np.argmax(amplitude * rig.damping(amplitude) > force)])


def _assembly(generator: np.random.Generator, rig: Oscillator) -> Oscillator:
    drift, friction = 1 + DRIFT * generator.standard_normal(), 1 + FRICTION * generator.standard_normal()
    return replace(rig, stuck=rig.stuck * drift, slip=rig.slip * friction)


def _measure(
    generator: np.random.Generator, rig: Oscillator, modal: float, level: float, upwards: bool,
    window: tuple[float, float], points: int, number: int,
) -> MeasuredCurve:  # fmt: skip
    frequency, receptance = rig.branch(level, window, 2000)
    keep = visited(frequency, upwards)
    order = np.argsort(frequency[keep])
    frequency, receptance = frequency[keep][order], receptance[keep][order]
    near = np.linspace(-1, 1, points) ** 3 * 0.7 + np.linspace(-1, 1, points) * 0.3  # denser about the peak
    peak = frequency[np.argmax(np.abs(receptance))]
    at = np.interp(near, [-1, 0, 1], [window[0] * 1.001, peak, window[1] * 0.999])
    value = np.interp(at, frequency, receptance.real) + 1j * np.interp(at, frequency, receptance.imag)
    noise = NOISE * (generator.standard_normal(points) + 1j * generator.standard_normal(points))
    gain = modal * (1 + GAIN * generator.standard_normal())
    force = level * (1 - 0.12 * np.abs(value) / np.abs(value).max())  # drops at resonance
    return MeasuredCurve(number, at, gain * value * (1 + noise), force)


def _model(rig: Oscillator, modal: float, level: float, upwards: bool, window: tuple[float, float]) -> ModelCurve:
    frequency, receptance = rig.branch(level, window)
    return ModelCurve(frequency, modal * receptance, visited(frequency, upwards))


def _band(measured: tuple[MeasuredCurve, ...]) -> Floats:
    frequency = measured[0].frequency
    each = np.stack([np.interp(frequency, curve.frequency, np.abs(curve.receptance)) for curve in measured])
    middle, spread = each.mean(axis=0), np.maximum(1.96 * each.std(axis=0), 0.02 * each.mean(axis=0))
    return np.stack([frequency, middle - spread, middle + spread], axis=1)


def _residuals(pair: CurvePair) -> Iterator[PointResidual]:
    branch = pair.after
    order = np.argsort(branch.frequency[branch.visited])
    frequency, model = branch.frequency[branch.visited][order], branch.receptance[branch.visited][order]
    for curve in pair.measured:
        at = np.interp(curve.frequency, frequency, model.real) + 1j * np.interp(curve.frequency, frequency, model.imag)
        away = np.log(curve.receptance / at)
        for f, value in zip(curve.frequency, away, strict=True):
            amplitude, phase = float(value.real / 0.05), float(value.imag / 0.05)
            size = float(np.sqrt((amplitude**2 + phase**2) / 2))
            yield PointResidual(
                pair.run, pair.mode, pair.level, curve.repeat, pair.channel, float(f), amplitude, phase, size
            )


def _measured_backbones(curves: tuple[CurvePair, ...]) -> Iterator[Backbone]:
    for rig in TRUTH:
        for channel in CHANNELS:
            rows = []
            for pair in (c for c in curves if c.mode == rig.name and c.channel == channel):
                for curve in pair.measured:
                    at = int(np.argmax(np.abs(curve.receptance)))
                    amplitude = float(abs(curve.receptance[at]) * curve.force[at])
                    damping = curve.force[at] / amplitude / (rig.mass * (2 * np.pi * curve.frequency[at]) ** 2)
                    rows.append(
                        (pair.level, curve.repeat, amplitude, curve.frequency[at], damping, abs(curve.receptance[at]))
                    )
            columns = np.array(rows).T
            yield Backbone(rig.name, channel, columns[0], columns[1].astype(np.int64), *columns[2:])


def _model_backbones(levels: tuple[float, ...]) -> Iterator[Backbone]:
    for rig in AFTER:
        for channel, modal in CHANNELS.items():
            force = np.geomspace(min(levels), max(levels), max(len(levels), 40))
            amplitude = np.array([_peak_amplitude(rig, level) for level in force])
            yield Backbone(
                rig.name, channel, force, np.zeros(len(force), np.int64), amplitude * abs(modal),
                rig.resonance(amplitude), rig.damping(amplitude) / rig.stiffness(amplitude),
                abs(modal) / rig.damping(amplitude),
            )  # fmt: skip


def _findings() -> tuple[Finding, ...]:
    return (
        Finding(
            "OOP: damping 31 % low at 0.096 N, right at 17 N (within 3 %).", "OOP", 0.096, "damping", "", -0.31, 14.2
        ),
        Finding("IP: resonance 0.15 % high at every force level.", "IP", None, "frequency", "", 0.0015, 5.1),
        Finding(
            "tip_left reads 7 % less than tip_right; the model's symmetry has them equal.",
            "", None, "sensor", "tip_left", 0.07, 8.8,
        ),
    )  # fmt: skip


def _calibration() -> tuple[Calibrated, ...]:
    return (
        Calibrated("Young's modulus", "Pa", 2.07e11, 0.02, 1.993e11, 1.981e11, 2.005e11),
        Calibrated("loss factor", "", 3e-3, 0.5, 2.2e-3, 2.0e-3, 2.4e-3),
        Calibrated("sliding_friction", "", 0.45, 0.2, 0.471, 0.452, 0.490),
        Calibrated("tangential contact stiffness", "N/m^3", 6e10, 0.4, 4.35e10, 4.02e10, 4.70e10),
        Calibrated("normal contact stiffness", "N/m^3", 6e10, 0.4, 2.1e10, 1.2e10, 3.7e10),
    )


def _features() -> tuple[FeatureComparison, ...]:
    nan = float("nan")
    return (
        FeatureComparison("resonance_frequency", "1F without damper", nan, 269.0, nan, nan, 269.05, 1.9e-4, 2e-3),
        FeatureComparison("resonance_frequency", "OOP", 0.096, 435.9, nan, nan, 440.3, 0.0101, 5e-4),
        FeatureComparison("resonance_frequency", "IP", 0.096, 393.0, nan, nan, 424.0, 0.0789, 1e-3),
        FeatureComparison("resonance_frequency_shift", "OOP", 17.0, nan, nan, 0.01, 0.0062, nan, nan),
        FeatureComparison("resonance_frequency", "IP", 17.0, nan, 360.0, 385.0, 398.2, nan, nan),
    )


def _contact_states(levels: tuple[float, ...]) -> dict[str, tuple[float, float, float, float]]:
    states = {}
    for mode, ease in (("IP", 1.0), ("OOP", 0.4)):
        for level in levels:
            slipping = float(1 - np.exp(-ease * level / 3))
            open_share = 0.25 * slipping**2
            separating = 0.3 * slipping * (1 - open_share)
            rest = 1 - open_share - separating
            slip_share = min(slipping, 1) * rest * 0.8
            states[f"{mode} {level:g} N"] = (rest - slip_share, slip_share, separating, open_share)
    return states
