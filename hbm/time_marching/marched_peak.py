"""Whether a test would see the motion that a curve reports at its peak: a few periods are marched from there.

The march shares no equation with the harmonic balance. Its first harmonic at the observed point after each period says
how far the motion has moved, and how fast it still moves. A lightly damped resonance takes hundreds of periods to
settle; a change decays by e in 2 E / W of them, E the energy of the vibration and W what is lost of it in a period. So
long marches are not affordable, and what is asked is where the motion is bound for:

    reach = moved so far + change of the last periods, a period * 2 E / W

A change that grows by e or more within the periods marched is said to leave, with its rate (growth.py); one with a
reach beyond what counts as the same response everywhere in updamp (`CompletenessLimits.change`) is said to move; all
else stays. Slower growth than 1 / (time marched) does not show: the stability of the peak says more there.
"""

import time
from collections.abc import Callable
from dataclasses import dataclass
from enum import IntEnum

import numpy as np
from numpy.typing import NDArray

from updamp.hbm.continuation.completeness import CompletenessLimits
from updamp.hbm.continuation.response_curve import ResponseCurve
from updamp.hbm.problem.system import Excitation, NonlinearSystem
from updamp.hbm.time_marching.contacts import not_marched
from updamp.hbm.time_marching.equilibrium import MarchError
from updamp.hbm.time_marching.growth import UNTOLD, Growth, growth
from updamp.hbm.time_marching.march import March, State

Floats = NDArray[np.float64]
Complex = NDArray[np.complex128]


class Verdict(IntEnum):
    """On the motion at the peak."""

    NOT_CHECKED = 0
    STAYS = 1
    MOVES = 2
    LEAVES = 3


@dataclass(frozen=True)
class MarchOptions:
    """periods: marched. A change that grows by e within them is told: at 400 Hz a growth of 20 1/s with 20 periods
    steps: a period. The third harmonic's frequency is off by (3 * 2 pi / steps)^2 / 12, 0.7 % with 64; the rig's
        motions moved by up to a third less than with 256, where its verdicts lie a factor of four or more from the
        limit (benchmarks/harmonic_balance/NOTES.md); IP at 17 N with harmonics 0-7, bound for 11 to 16 %, does not
    last: periods whose mean change is that of the end: one beat of the rig's damper, at 100 Hz, against the blades
    change: reach beyond which the motion is another one, relative
    linear: moved by more, changes are not taken as linear any more, and no growth is fitted to them: terms of second
        order are of this share

    raises: ValueError naming the option that is out of range
    """

    periods: int = 20
    steps: int = 64
    last: int = 5
    change: float = CompletenessLimits.change
    linear: float = 0.01

    def __post_init__(self) -> None:
        if not (self.steps >= 16 and 1 <= self.last <= self.periods and 0 < self.linear <= self.change < 1):
            raise ValueError(
                f"steps = {self.steps}: at least 16; last = {self.last}: from 1 to periods = {self.periods}; linear = "
                f"{self.linear}: above 0, up to change = {self.change}, which is below 1"
            )


@dataclass(frozen=True, eq=False)
class MarchedPeak:
    """Of one curve.

    frequency [Hz]; amplitude: (n + 1,) complex first harmonic at the observed point, of the harmonic balance and after
        each period [m]
    moved: at the end, relative to the first; reach: where it is bound for, likewise
    growth: [1/s], not a number where it cannot be told; growth_error: see `Growth`
    verdict: a `Verdict`; reason: why it was not checked or marched no further, "" otherwise; seconds: wall time spent
    """

    mode: str
    force: float
    frequency: float
    amplitude: Complex
    moved: float
    reach: float
    growth: float
    growth_error: float
    verdict: int
    reason: str
    seconds: float

    @property
    def periods(self) -> int:
        return max(len(self.amplitude) - 1, 0)

    @property
    def sentence(self) -> str:
        """What a person needs to know."""
        verdict, n = Verdict(self.verdict), self.periods
        if verdict is Verdict.NOT_CHECKED:
            return f"not checked: {self.reason}"
        if not n:
            return "stays: nothing slips or opens, and the stuck structure is damped"
        moved = f"{100 * self.moved:.2g} % in {n} periods marched in time"
        found = {
            Verdict.STAYS: f"stays: {moved}, bound for {100 * self.reach:.2g} %",
            Verdict.MOVES: f"moves: {moved}, and on; the harmonic balance has too few harmonics there, or no such "
            "motion exists at this frequency",
            Verdict.LEAVES: f"leaves, growing by {self.growth:.3g} 1/s: {moved}",
        }[verdict]
        return f"{found} (no further: {self.reason})" if self.reason else found


def marched_peak(
    system: NonlinearSystem,
    excitation: Excitation,
    curve: ResponseCurve,
    point: str,
    options: MarchOptions | None = None,
    report: Callable[[float], None] = lambda _: None,
) -> MarchedPeak:
    """From the point of the curve with the largest first harmonic at `point`. What cannot be marched is said to be not
    checked, with the reason.

    system: that the curve was traced on, with its excitation; report: takes the share done, 0 to 1
    raises: whatever `report` does
    """
    options, began = options or MarchOptions(), time.perf_counter()
    if reason := not_marched(system.groups) or ("" if len(curve) else "the curve has no point"):
        return _not_checked(curve, np.nan, np.zeros(0, dtype=np.complex128), reason, began)
    peak = int(np.abs(curve.amplitude(point)).argmax())
    frequency, X = float(curve.frequency[peak]), complex(curve.amplitude(point)[peak])
    if not curve.active[peak]:
        return _linear(curve, frequency, X, began)
    march = March.of(system, excitation, system.free.row(point), 2 * np.pi * frequency, options.steps)
    states, amplitudes, reason = _march(march, march.start(system, curve.displacement[peak]), options.periods, report)
    amplitude = np.array([X, *amplitudes])
    if len(amplitudes) < options.last:
        return _not_checked(curve, frequency, amplitude, reason, began)
    moved = np.abs(amplitude[1:] - X) / abs(X)
    settling = 2 * march.kinetic_energy(system, curve.displacement[peak]) / float(curve.work_in[peak])
    rate = abs(amplitude[-1] - amplitude[-1 - options.last]) / options.last / abs(X)
    reach, told = float(moved[-1] + rate * settling), _growth(march, states, moved, options)
    verdict = _verdict(reach, told, len(amplitudes) / frequency, options)
    return MarchedPeak(
        curve.mode, curve.force, frequency, amplitude, float(moved[-1]), reach, *told, int(verdict), reason,
        time.perf_counter() - began,
    )  # fmt: skip


def _march(
    march: March, state: State, periods: int, report: Callable[[float], None]
) -> tuple[list[State], list[complex], str]:
    """As far as it goes, and why no further"""
    states: list[State] = [state]
    amplitudes: list[complex] = []
    for done in range(periods):
        report(done / periods)
        try:
            period = march.period(states[-1])
        except (MarchError, np.linalg.LinAlgError) as error:
            return states, amplitudes, f"after {len(amplitudes)} periods: {error}"
        states.append(period.state)
        amplitudes.append(period.amplitude)
    return states, amplitudes, ""


def _growth(march: March, states: list[State], moved: Floats, options: MarchOptions) -> Growth:
    """From the periods that are near the start. Displacement and velocity of the modes count by their energy."""
    near = len(moved) if (moved <= options.linear).all() else int((moved > options.linear).argmax())
    omega = np.sqrt(np.maximum(march.model.omega_squared, 0.0))
    z = np.array([np.concatenate([omega * state.q, state.v]) for state in states[: near + 1]])
    changes = np.diff(z, axis=0)
    if len(changes) == 0 or np.abs(changes).max() <= 1e-9 * np.abs(z).max():  # as much as the steps' own equilibrium
        return UNTOLD
    return growth(changes, 2 * np.pi / march.w)


def _verdict(reach: float, told: Growth, marched: float, options: MarchOptions) -> Verdict:
    """marched: time [s]"""
    if told.rate * marched >= 1:  # not where it is not a number
        return Verdict.LEAVES
    return Verdict.MOVES if not reach <= options.change else Verdict.STAYS


def _linear(curve: ResponseCurve, frequency: float, X: complex, began: float) -> MarchedPeak:
    """Nothing slips or opens: what would be marched is the stuck structure, which is damped."""
    return MarchedPeak(
        curve.mode, curve.force, frequency, np.array([X]), 0.0, 0.0, *UNTOLD, int(Verdict.STAYS), "",
        time.perf_counter() - began,
    )  # fmt: skip


def _not_checked(curve: ResponseCurve, frequency: float, amplitude: Complex, reason: str, began: float) -> MarchedPeak:
    return MarchedPeak(
        curve.mode, curve.force, frequency, amplitude, np.nan, np.nan, *UNTOLD, int(Verdict.NOT_CHECKED), reason,
        time.perf_counter() - began,
    )  # fmt: skip
