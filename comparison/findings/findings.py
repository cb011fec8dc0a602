"""Where the model fails, in the words of a vibration engineer: which mode and force level, frequency or damping, which
sensor, and whether that stands out of what the test repeats to.

Each statement is a direction in the residual: a shift of a run's resonance, more damping in it, a sensor that reads
high. All of them are estimated together, on top of the fitted parameters, by generalised least squares.
"""

from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass, replace
from typing import TypeVar

import numpy as np
from numpy.typing import NDArray
from scipy.stats import norm

from updamp.comparison.comparison import Finding
from updamp.comparison.findings.words import FAR_LESS, in_percent, level_of, levels_of
from updamp.comparison.fit.failing_model import RISK, Freedom
from updamp.comparison.fit.fit import Fit
from updamp.comparison.fit.observations import Plan
from updamp.comparison.fit.scatter import Assembly, whitened
from updamp.model.calibration import LOSS_FACTOR

Floats = NDArray[np.float64]

FREQUENCY, DAMPING, SENSOR, AMPLITUDE, RUN = "frequency", "damping", "sensor", "amplitude", "run"
# Prior size of a misfit, which keeps directions that the data do not tell at zero: relative; of a resonance as a
# share of the measured window, over which the model is taken as linear here. Shifts of all tests alike are what Young's
# modulus is for: they are left to it. Whole runs are off by twice or half where they are.
_SIZES = {FREQUENCY: 0.1, DAMPING: 1.0, SENSOR: 0.1, RUN: float(np.log(2))}
# Distance from a bound at which a parameter counts as held by it, in prior deviations.
_AT_BOUND = 1e-3


@dataclass(frozen=True)
class Direction:
    """A kind of misfit: quantity, condition (place in the plan) or sensor (point of the model, harmonic); amplitude is
    that of all sensors in all tests, run that of all sensors in one"""

    quantity: str
    test: int = -1
    sensor: tuple[str, int] = ("", 1)


@dataclass(frozen=True)
class Misfit:
    """relative: model over measurement less 1; deviation: its standard deviation"""

    direction: Direction
    relative: float
    deviation: float

    @property
    def significance(self) -> float:
        return self.relative / self.deviation if self.deviation > 0 else 0.0

    @property
    def size(self) -> float:
        """Of the logarithm: as much for twice as for half of what was measured."""
        return abs(float(np.log1p(self.relative)))


def misfits(fit: Fit, plan: Plan, damping_share: Sequence[float]) -> tuple[Misfit, ...]:
    """All directions, estimated together with the fitted parameters, which stay where they are to within their own
    uncertainty: what all tests have in common is theirs, and what tests differ by is known far better than that.

    damping_share: for each condition, the material's share of the damping at its resonance: what turns a factor on
        the material's loss factor into one on all the damping
    """
    directions = _directions(plan)
    r, both = equations_with(fit, plan, directions)
    n = both.shape[1] - len(directions)
    sizes = np.array([size_of(x, plan) for x in directions])
    before = 1 / fit.parametrisation.deviation**2
    prior = np.concatenate([before + 1 / np.maximum(fit.deviations, 1e-12) ** 2, 1 / sizes**2])
    both[:, :n] *= ~_held(fit)
    covariance = np.linalg.inv(both.T @ both + np.diag(prior))
    # the parameters stand at their best values: their own gradient is nil, but for the prior's
    estimate = covariance @ (both.T @ r - np.append(fit.u * before, np.zeros(len(sizes))))
    # with the noise that the misfit asks for, where it is larger (R. T. Birge, Phys. Rev. 40 (1932) 207)
    covariance = covariance * max(1.0, fit.compared.mean_squared_misfit)
    estimate, covariance = estimate[n:], covariance[n:, n:]

    def misfit(direction: Direction, combined: Floats) -> Misfit:
        # a correction that the model needs upwards is a model that reads low
        log, deviation = -float(combined @ estimate), float(np.sqrt(combined @ covariance @ combined))
        relative = float(np.expm1(log))
        # as significant as the logarithm is
        return Misfit(direction, relative, deviation * (relative / log if log else 1.0))

    return (*(misfit(*one) for one in _statements(directions, damping_share)), *_of_sensors(directions, misfit))


def _statements(directions: Sequence[Direction], damping_share: Sequence[float]) -> list[tuple[Direction, Floats]]:
    """What is stated, each with the combination of the directions that it is: of the sensors their mean."""
    found = []
    for row, direction in zip(np.eye(len(directions)), directions, strict=True):
        if direction.quantity != SENSOR:
            found.append((direction, row * (damping_share[direction.test] if direction.quantity == DAMPING else 1.0)))
    gains = np.array([float(d.quantity == SENSOR) for d in directions])
    return [*found, (Direction(AMPLITUDE), gains / gains.sum())] if gains.any() else found


def _of_sensors(directions: Sequence[Direction], misfit: Callable[[Direction, Floats], Misfit]) -> Iterator[Misfit]:
    places = {d: i for i, d in enumerate(directions) if d.quantity == SENSOR}

    def against(one: Direction, others: Sequence[Direction]) -> Misfit:
        combined = np.zeros(len(directions))
        combined[places[one]] = 1.0
        combined[[places[other] for other in others]] = -1 / len(others)
        return misfit(one, combined)

    return farthest_first(list(places), against)


Sensor = TypeVar("Sensor")


def farthest_first(
    sensors: Sequence[Sensor], against: Callable[[Sensor, Sequence[Sensor]], Misfit | None]
) -> Iterator[Misfit]:
    """How far each sensor is from the others: the farthest first, which the next ones are not held against. Of two,
    which are as far from each other, the first.

    against: misfit of one sensor against others, None where it cannot be told
    """
    left = list(sensors)
    while len(left) > 1:
        each = {one: found for one in left if (found := against(one, [s for s in left if s != one])) is not None}
        if not each:
            return
        worst = max(each, key=lambda one: round(abs(each[one].significance), 6))
        yield each[worst]
        left.remove(worst)


def size_of(direction: Direction, plan: Plan) -> float:
    """Its prior deviation."""
    if direction.quantity != FREQUENCY:
        return _SIZES[direction.quantity]
    low, high = plan.conditions[direction.test].window
    return _SIZES[FREQUENCY] * float(np.log(high / low))


def _held(fit: Fit) -> NDArray[np.bool_]:
    """(p,) whether each parameter stands at a bound: what it cannot make up for is a misfit."""
    p = fit.parametrisation
    near = _AT_BOUND * np.where(np.isfinite(p.deviation), p.deviation, 1.0)
    return np.asarray((fit.u - p.lower < near) | (p.upper - fit.u < near))


def whitened_with(a: Assembly, block: Floats, fit: Fit) -> tuple[Floats, Floats]:
    """The assembly's residual and a block of columns, with its scatter taken into account."""
    return whitened(replace(a, common=block), fit.compared.scatter)


def _directions(plan: Plan) -> list[Direction]:
    tests = range(len(plan.conditions))
    sensors = dict.fromkeys(s for c in plan.conditions for s in c.sensors)
    return [
        *(Direction(FREQUENCY, i) for i in tests),
        *(Direction(DAMPING, i) for i in tests),
        *(Direction(SENSOR, -1, s) for s in sensors if len(sensors) > 1),
    ]


def equations_with(fit: Fit, plan: Plan, directions: Sequence[Direction]) -> tuple[Floats, Floats]:
    """(values,) residuals of all assemblies with their scatter taken into account, and (values, p + directions) what a
    unit of each fitted parameter and direction takes from them."""
    residuals, columns = [], []
    for a in fit.compared.assemblies:
        block = np.concatenate([a.common, _columns(fit, plan, a.repeat, directions)], axis=1)
        r, c = whitened_with(a, block, fit)
        residuals.append(r)
        columns.append(c)
    return np.concatenate(residuals), np.concatenate(columns)


def _columns(fit: Fit, plan: Plan, repeat: int, directions: Sequence[Direction]) -> Floats:
    damping = fit.parametrisation.names.index(LOSS_FACTOR.name)
    blocks = []
    for m in (m for m in fit.compared.matched if m.observations.repeat == repeat):
        test, sensors = m.observations.test, plan.conditions[m.observations.test].sensors
        block = np.zeros((m.residual.size, len(directions)))
        for j, direction in enumerate(directions):
            if direction.quantity == FREQUENCY and direction.test == test:
                block[:, j] = m.by_observation[:, :, 0].ravel()
            elif direction.quantity == DAMPING and direction.test == test:
                block[:, j] = m.by_parameter[:, :, damping].ravel()
            elif direction.quantity == RUN and direction.test == test:
                block[:, j] = np.sum(m.by_observation[:, :, 1::2], axis=2).ravel()
            elif direction.quantity == SENSOR and direction.sensor in sensors:
                block[:, j] = m.by_observation[:, :, 1 + 2 * sensors.index(direction.sensor)].ravel()
        blocks.append(block)
    return np.concatenate(blocks)


def lack_of_fit(fit: Fit, plan: Plan) -> float:
    """Probability of a chi2 as large by chance, the noise known as well as it is."""
    return float(Freedom(fit.freedom, plan.noise_freedom).by_chance.sf(fit.compared.chi2 / fit.freedom))


def findings(fit: Fit, plan: Plan, found: Sequence[Misfit], told: Sequence[Finding] = ()) -> tuple[Finding, ...]:
    """Sentences on the misfits that stand out; none where the model is adequate. told: what is said already"""
    limit = float(norm.isf(RISK / 2 / max(len(found), 1)))
    standing = [m for m in found if abs(m.significance) > limit]
    sentences: list[Finding] = []
    for quantity in (FREQUENCY, DAMPING):
        for mode in dict.fromkeys(c.mode for c in plan.conditions):
            of_mode = [m for m in found if m.direction.quantity == quantity and _mode(plan, m) == mode]
            sentences += _of_mode(quantity, mode, of_mode, [m for m in standing if m in of_mode], plan)
    sentences += [_of_amplitude(m) for m in standing if m.direction.quantity == AMPLITUDE]
    sentences += [_of_sensor(m) for m in standing if m.direction.quantity == SENSOR]
    sentences.sort(key=lambda f: -abs(f.significance))
    if not sentences and not told and lack_of_fit(fit, plan) < RISK:
        sentences.append(_of_all(fit, plan))
    return tuple(sentences)


def _mode(plan: Plan, misfit: Misfit) -> str:
    return plan.conditions[misfit.direction.test].mode


def _of_mode(
    quantity: str, mode: str, all_levels: Sequence[Misfit], standing: Sequence[Misfit], plan: Plan
) -> list[Finding]:
    """One sentence: that all levels agree, or those that stand out, the largest first, and what holds at the others;
    and where nothing was read."""
    if not standing:
        return []
    thing = "resonance" if quantity == FREQUENCY else "damping"
    values = np.array([m.relative for m in all_levels])
    weights = np.array([1 / m.deviation**2 for m in all_levels])
    mean = float(np.sum(weights * values) / np.sum(weights))
    deviation = float(1 / np.sqrt(np.sum(weights)))
    alike = all(abs(m.relative - mean) < 3 * m.deviation + 0.2 * abs(mean) for m in all_levels)
    read = [m.direction.test for m in all_levels]
    unread = [i for i, c in enumerate(plan.conditions) if c.mode == mode and i not in read]
    not_read = f", not read at {levels_of(unread, plan)}" if unread else ""
    if len(all_levels) > 1 and alike and np.all(np.sign(values) == np.sign(mean)):
        kind = "force level" if plan.conditions[0].unit == "N" else "level"
        where = levels_of(read, plan) if unread else f"every {kind}"
        text = f"{mode}: {thing} {in_percent(mean)} at {where}{not_read}"
        return [Finding(text, mode, None, quantity, "", mean, mean / deviation)]
    by_size = sorted(standing, key=lambda m: -m.size)
    worst, named = by_size[0], [m for m in by_size if m.size >= FAR_LESS * by_size[0].size]
    sizes = dict.fromkeys(in_percent(m.relative) for m in named)
    parts = [f"{size} at {_at([m for m in named if in_percent(m.relative) == size], plan)}" for size in sizes]
    rest = {
        "far less": [m for m in standing if m not in named],
        "right": [m for m in all_levels if m not in standing],
    }
    parts += [f"{what} at {_at(some, plan)}" for what, some in rest.items() if some]
    level = plan.conditions[worst.direction.test].level
    text = f"{mode}: {thing} {', '.join(parts)}{not_read}"
    return [Finding(text, mode, level, quantity, "", worst.relative, worst.significance)]


def _of_amplitude(misfit: Misfit) -> Finding:
    text = f"amplitude {in_percent(misfit.relative)} in all runs, at all sensors"
    return Finding(text, "", None, AMPLITUDE, "", misfit.relative, misfit.significance)


def _of_sensor(misfit: Misfit) -> Finding:
    point, k = misfit.direction.sensor
    of_harmonic = f" in harmonic {k}" if k != 1 else ""
    text = (
        f"{point}: the model reads {in_percent(misfit.relative)}{of_harmonic}, against the other sensors, in all runs"
    )
    return Finding(text, "", None, SENSOR, point, misfit.relative, misfit.significance)


def _of_all(fit: Fit, plan: Plan) -> Finding:
    mean_squared = fit.compared.mean_squared_misfit
    errors = np.array([[m.observations.test, np.mean(m.residual**2)] for m in fit.compared.matched])
    of_test = {int(i): float(np.mean(errors[errors[:, 0] == i, 1])) for i in np.unique(errors[:, 0])}
    worst = max(of_test, key=lambda i: of_test[i])
    condition, size = plan.conditions[worst], float(np.sqrt(of_test[worst])) / fit.compared.scatter.noise
    text = (
        f"the curves differ in shape, most of all {condition.mode} at {level_of(plan, worst)} ({size:.1f} times the "
        f"scatter): the mean squared misfit is {mean_squared:.2f}, and no resonance, peak or sensor stands out of so "
        "large a one by itself"
    )
    relative = float(np.sqrt(mean_squared) - 1)
    return Finding(text, condition.mode, condition.level, AMPLITUDE, "", relative, _deviations(fit))


def _deviations(fit: Fit) -> float:
    """How many standard deviations chi2 is too large by (E. B. Wilson and M. M. Hilferty, PNAS 17 (1931) 684)."""
    k = fit.freedom
    return float((np.cbrt(fit.compared.chi2 / k) - (1 - 2 / (9 * k))) / np.sqrt(2 / (9 * k)))


def _at(misfits_there: Sequence[Misfit], plan: Plan) -> str:
    return levels_of([m.direction.test for m in misfits_there], plan)
