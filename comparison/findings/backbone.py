"""Resonance against amplitude, read off measured and predicted receptances in the same way.

Frequency and height at the highest top of the receptance; the equivalent loss factor from how fast the tangent of the
phase falls there, eta = 2 / (f |d tan(phase - phase of the peak) / d f|): for a linear oscillator with light damping it
follows a straight line (D. J. Ewins, Modal Testing, 2000, ch. 4). Where many contacts slip at the top, or another mode
is near, it does not: what the phase tells is taken where the width at 1/sqrt(2) of the height tells the same.

A sweep that jumps beside its highest point has no top to be read between its points: what lies beyond the jump is
another part of the curve. Its highest point is then its resonance, as the turning point is the model's.
"""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from updamp.comparison.comparison import Backbone
from updamp.comparison.curves import model_curve, receptance_of
from updamp.comparison.findings.tops import highest
from updamp.comparison.fit.observations import Observations, Plan
from updamp.comparison.prediction.predicted_branch import PredictedBranch

Floats = NDArray[np.float64]
Complex = NDArray[np.complex128]

FIVE = 5  # points that a top is read off
# Points whose phase is within this of that at the peak tell the damping [rad].
_NEAR = np.pi / 4
# Logarithm of the ratio of both loss factors, by phase and by width, up to which the phase turns as an oscillator's.
_LIKE_OSCILLATOR = 0.15
# Rates of d log(receptance) / d f that an oscillator has on both sides of its highest point, the larger over the
# smaller: with evenly spaced points 1 where these are dense, pi / log 3 = 2.9 where the next ones are far out.
_NO_JUMP = np.pi / np.log(3)
_HALF_POWER = 0.5  # of the square of the response


@dataclass(frozen=True)
class ResonanceReading:
    """frequency [Hz], receptance [m/N], amplitude [m], loss factor [-] (nan where the phase does not tell)"""

    frequency: float
    receptance: float
    amplitude: float
    loss_factor: float


def read_resonance(
    frequency: Floats, receptance: Complex, force: Floats, deviation: Floats | None = None
) -> ResonanceReading:
    """Of one sweep, in its own order. frequency: (n,) [Hz]; receptance: (n,) [m/N]; force: (n,) [N]
    deviation: (n,) of the receptance, relative, none by default"""
    size = np.abs(receptance)
    i = highest(np.log(size), deviation)
    top, at = summit(frequency, np.log(receptance), i)
    by_phase = _loss_factor(frequency, receptance, i, at)
    widths = np.array([half_power_frequency(frequency, size, i, side) for side in (-1, 1)])
    # both halves together, which another mode nearby makes unlike each other; a window narrower than them tells neither
    by_width = by_phase if np.isnan(widths).all() else 2 * float(np.mean(np.abs(widths - at))) / at
    agree = abs(np.log(by_phase / by_width)) < _LIKE_OSCILLATOR
    return ResonanceReading(at, float(np.exp(top)), float(np.exp(top) * force[i]), by_phase if agree else float("nan"))


def half_power_frequency(f: Floats, size: Floats, i: int, side: int) -> float:
    """Where the receptance has fallen to 1/sqrt(2) of its largest value, on one side of it in the order of the points;
    nan where it does not."""
    wanted, k = size[i] / np.sqrt(2), i
    while 0 <= k + side < len(f):
        if size[k + side] < wanted:
            share = (size[k] - wanted) / (size[k] - size[k + side])
            return float(f[k] + share * (f[k + side] - f[k]))
        k += side
    return float("nan")


def five_about(i: int) -> slice:
    """Places of the points that a top is read off, fewer beside an end."""
    return slice(max(i - FIVE // 2, 0), i + FIVE // 2 + 1)


def summit(f: Floats, log_receptance: Complex, i: int) -> tuple[float, float]:
    """Top and its place of the oscillator through the largest value and its neighbours; the largest value where these
    are too few, do not enclose a top, or a jump is among them.

    One over the square of an oscillator's response is a parabola of the frequency, however far apart the points are; a
    parabola through the responses lies a tenth below the top of points that are a half-width apart. Where no point lies
    within the half-power points of what is found, they do not tell how high the top is: it is told no higher than that.

    log_receptance: (n,) its imaginary part the phase, all of it 0 where that is not known
    """
    log_size, near = log_receptance.real, five_about(i)
    through = _oscillator(f, log_size, i)
    if through is None or _jumps(f[near], log_receptance[near]):
        return float(log_size[i]), float(f[i])
    return float(log_size[i] - np.log(through.least) / 2), float(f[i] + through.at * through.width)


def summit_deviation(f: Floats, log_size: Floats, i: int) -> tuple[float, float]:
    """Deviations of the logarithm of a top's height and of its place (`summit`), to first order, in those of the
    logarithms of the points' sizes; infinite of a place where the points enclose no top."""
    through = _oscillator(f, log_size, i)
    if through is None:
        return 1.0, np.inf
    at, bend = through.at, 2 * through.parabola[0]
    of_least, of_place = np.array([at**2, at, 1.0]), np.array([2 * at, 1.0, 0.0])
    height = float(np.linalg.norm(of_least @ through.moved)) / (2 * through.least)
    return height, through.width * float(np.linalg.norm(of_place @ through.moved)) / bend


@dataclass(frozen=True, eq=False)
class _Oscillator:
    """parabola: (3,) the highest power first, of one over the square of a response over that of its highest point, by
    how far off that is in widths of the points; moved: (3, n) what a unit of their logarithms changes it by
    at, least: place of its top, in widths, and what it is there, half at least"""

    parabola: Floats
    moved: Floats
    width: float
    at: float
    least: float


def _oscillator(f: Floats, log_size: Floats, i: int) -> _Oscillator | None:
    """About the highest point, the points as unsure as they are large; None where they are too few or enclose no
    top."""
    near = five_about(i)
    x = f[near] - f[i]
    if len(np.unique(x)) < FIVE:
        return None
    width = float(np.ptp(x))
    x = x / width
    inverse = np.exp(2 * (log_size[i] - log_size[near]))
    to_parabola = np.asarray(np.linalg.pinv(np.vander(x, 3) / inverse[:, None]), dtype=np.float64)
    c = to_parabola @ np.ones(FIVE)
    at = float(-c[1] / (2 * c[0])) if c[0] > 0 else np.inf
    if not x.min() <= at <= x.max():
        return None
    return _Oscillator(c, -2 * to_parabola, width, at, max(float(np.polyval(c, at)), _HALF_POWER))


def _jumps(f: Floats, log_receptance: Complex) -> bool:
    """Whether a response jumps from one of five points to the next, the third of which is the highest: it turns faster
    there than an oscillator's, which turns the fastest about its top."""
    phase = log_receptance.imag
    if np.ptp(phase) == 0:
        return _jumps_in_size(f, log_receptance.real)
    rate = np.hypot(np.diff(log_receptance.real), np.diff(np.unwrap(phase))) / np.abs(np.diff(f))
    return bool(rate.max() > _NO_JUMP * min(rate[1], rate[2]))


def _jumps_in_size(f: Floats, log_size: Floats) -> bool:
    """Likewise where no phase is known. One over the square of an oscillator's amplitude is a parabola of the
    frequency: the one through the highest three points leads to the outer two, which lie elsewhere beside a jump by as
    much as it is high. Told from half the square on; of lower jumps the top is misread by a tenth at most."""
    inner, outer = [1, 2, 3], [0, 4]
    through = np.polyfit(f[inner] / np.ptp(f), np.exp(-2 * log_size[inner]), 2)
    led_to = np.polyval(through, f[outer] / np.ptp(f)) * np.exp(2 * log_size[outer])
    return bool(led_to.min() < _HALF_POWER or led_to.max() > 1 / _HALF_POWER)


def loss_by_phase(f: Floats, receptance: Complex, i: int) -> float:
    """Loss factor by the phase's slope about the i-th point, the highest top, nan where too few points tell it."""
    return _loss_factor(f, receptance, i, summit(f, np.log(receptance), i)[1])


def _loss_factor(f: Floats, receptance: Complex, i: int, at: float) -> float:
    phase = np.unwrap(np.angle(receptance))
    near = np.abs(phase - phase[i]) < _NEAR
    # the run of neighbours about the peak, not what lies beyond a jump
    low, high = i, i
    while low > 0 and near[low - 1]:
        low -= 1
    while high < len(f) - 1 and near[high + 1]:
        high += 1
    if high - low < 3:
        return float("nan")
    run = slice(low, high + 1)
    # about the phase at the top, which lies between two points: the tangent is straight about no other
    tangent = np.tan(phase[run] - np.interp(0.0, *_increasing(f[run] - at, phase[run])))
    slope = np.polyfit(f[run] - at, tangent, 1)[0]
    return float(-2 / (at * slope)) if slope < 0 else float("nan")


def _increasing(x: Floats, y: Floats) -> tuple[Floats, Floats]:
    order = np.argsort(x)
    return x[order], y[order]


def backbone(
    mode: str, channel: str, entries: Sequence[tuple[float, int, Floats, Complex, Floats, Floats | None]]
) -> Backbone:
    """entries: (level, repeat, frequency, receptance, force, deviation) of each sweep, as `read_resonance`"""
    found = [(level, repeat, read_resonance(f, z, force, off)) for level, repeat, f, z, force, off in entries]
    return Backbone(
        mode,
        channel,
        np.array([level for level, _, _ in found]),
        np.array([repeat for _, repeat, _ in found], dtype=np.int64),
        np.array([r.amplitude for *_, r in found]),
        np.array([r.frequency for *_, r in found]),
        np.array([r.loss_factor for *_, r in found]),
        np.array([r.receptance for *_, r in found]),
    )


def measured_backbones(plan: Plan, names: Mapping[str, str]) -> tuple[Backbone, ...]:
    """One a mode and sensor, with an entry for every run. names: of the channels, by point of the model"""
    return _backbones(
        plan,
        names,
        lambda o, j: (
            o.repeat,
            o.frequency,
            receptance_of(o.observed, o.log_force, plan.conditions[o.test].force, j),
            plan.conditions[o.test].force * np.exp(o.log_force),
            o.noise[:, 1 + 2 * j],
        ),
        plan.observations,
    )


def places_of(plan: Plan, test: int, is_measured: bool) -> list[int]:
    """Of a test's entries in the backbones of its mode: the measured ones, or the model's."""
    mode = plan.conditions[test].mode
    tests = [o.test for o in plan.observations] if is_measured else range(len(plan.conditions))
    return [k for k, t in enumerate([t for t in tests if plan.conditions[t].mode == mode]) if t == test]


def model_backbones(plan: Plan, names: Mapping[str, str], branches: Sequence[PredictedBranch]) -> tuple[Backbone, ...]:
    """Likewise, with an entry for every condition. branches: one a condition"""
    first = [next(o for o in plan.observations if o.test == i) for i in range(len(plan.conditions))]

    def curve(o: Observations, sensor: int) -> tuple[int, Floats, Complex, Floats, None]:
        whole = model_curve(branches[o.test], sensor)
        # beyond the window that was measured the branch may climb to another mode's resonance
        low, high = plan.conditions[o.test].window
        measured = whole.visited & (whole.frequency >= low) & (whole.frequency <= high)
        used = measured if measured.any() else whole.visited
        f, z = whole.frequency[used], whole.receptance[used]
        return 0, f, z, np.full(len(f), plan.conditions[o.test].force), None

    return _backbones(plan, names, curve, first)


def _backbones(
    plan: Plan,
    names: Mapping[str, str],
    curve: Callable[[Observations, int], tuple[int, Floats, Complex, Floats, Floats | None]],
    runs: Sequence[Observations],
) -> tuple[Backbone, ...]:
    found = []
    for mode in dict.fromkeys(c.mode for c in plan.conditions):
        of_mode = [o for o in runs if plan.conditions[o.test].mode == mode]
        for sensor in plan.conditions[of_mode[0].test].sensors:
            entries = []
            for o in of_mode:
                condition = plan.conditions[o.test]
                entries.append((condition.level, *curve(o, condition.sensors.index(sensor))))
            found.append(backbone(mode, names[sensor[0]], entries))
    return tuple(found)
