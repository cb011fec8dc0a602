"""A stepped sine on the bench: frequency by frequency at held force, each from where the last one left the rig.

Where the motion cannot be continued, or only past a fold, the step is divided; where that does not help either the rig
has jumped, and the motion is sought from the stuck one with the force raised in steps.
"""

from collections.abc import Iterator
from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray

from updamp.benchmarks.virtual_rig.assembled import Assembled
from updamp.benchmarks.virtual_rig.periodic import Motion, NotSolvedError, SolverOptions, motion_at

Floats = NDArray[np.float64]

# Of a step of frequency and force, by which it is taken back to see which way the motion goes.
_PART = 1e-3
# Tip's receptance [m/N] at about which half of the unrecorded drop of force is reached: near that of stuck resonances.
DROP_AT = 2e-6


@dataclass
class StepMotor:
    """The rig as the sweep goes on. motion: where it is"""

    rig: Assembled
    options: SolverOptions
    motion: Motion | None = None
    before: Motion | None = None
    lost: int = field(default=0)

    def step(self, frequency: float, force: float) -> Motion:
        """The motion at the next frequency [Hz] and recorded force [N]. raises: NotSolvedError"""
        w = 2 * np.pi * frequency
        try:
            found = self._continued(w, force, 0)
        except NotSolvedError:
            found = self._from_rest(w, force)
        self.before, self.motion = self.motion, found
        return found

    def _continued(self, w: float, force: float, depth: int) -> Motion:
        last = self.motion
        if last is None:
            return self.settled(w, force, None)
        for start in self._starts(w):
            try:
                found = self.settled(w, force, start)
            except NotSolvedError:
                continue
            if not self._past_a_fold(last, found, force):
                return found
        if depth == 4:
            raise NotSolvedError(f"{w / 2 / np.pi:.3f} Hz: not reached in steps")
        self.before, self.motion = last, self._continued((last.w + w) / 2, (last.force + force) / 2, depth + 1)
        return self._continued(w, force, depth + 1)

    def _past_a_fold(self, last: Motion, found: Motion, force: float) -> bool:
        """Whether Newton's method has come to the unstable side of a fold, where no rig stays: the same change of
        frequency and force moves it the other way there."""
        step = found.w - last.w, force - last.force
        try:
            ways = [self._back(motion, step).x - motion.x for motion in (last, found)]
        except NotSolvedError:
            return False
        return float(np.vdot(*ways)) < 0

    def _back(self, motion: Motion, step: tuple[float, float]) -> Motion:
        """The motion a little before. raises: NotSolvedError"""
        return self.settled(motion.w - _PART * step[0], motion.force - _PART * step[1], motion.x)

    def _starts(self, w: float) -> Iterator[Floats]:
        last, before = self.motion, self.before
        assert last is not None
        if before is not None and before.w != last.w and before.x.shape == last.x.shape:
            share = (w - last.w) / (last.w - before.w)
            if 0 < share < 3:
                yield last.x + share * (last.x - before.x)
        yield last.x

    def _from_rest(self, w: float, force: float) -> Motion:
        """raises: NotSolvedError"""
        for steps in (1, 4, 12):
            try:
                x = None
                for share in np.linspace(1 / steps, 1, steps):
                    found = self.settled(w, share * force, x if x is None else x * share / (share - 1 / steps))
                    x = found.x
                return found
            except NotSolvedError:
                continue
        self.lost += 1
        raise NotSolvedError(f"{w / 2 / np.pi:.3f} Hz, {force:g} N: neither continued nor reached from rest")

    def settled(self, w: float, force: float, start: Floats | None) -> Motion:
        """The motion, with the loss factor and the force on the blade that go with its own amplitude."""
        bench = self.rig.bench
        if bench.loss_growth == 0 and bench.force_drop == 0:
            return motion_at(self.rig, w, force, start, self.options)
        last = self.motion
        tips = last.tips if last is not None else {}
        actual = force_on_blade(force, last.tips["blade_right"] if last is not None else 0.0, bench.force_drop)
        for _ in range(60):
            found = motion_at(self.rig, w, actual, start, self.options, tips)
            new, start = found.tips, found.x
            wanted = force_on_blade(force, new["blade_right"], bench.force_drop)
            change = max(abs(wanted / actual - 1), *(abs(new[b] / tips.get(b, 1e-30) - 1) for b in new))
            if change < 100 * self.options.tolerance:
                return found
            tips = {b: tips.get(b, new[b]) + 0.6 * (new[b] - tips.get(b, new[b])) for b in new}
            actual += 0.6 * (wanted - actual)
        raise NotSolvedError(f"{w / 2 / np.pi:.3f} Hz, {force:g} N: amplitude and damping do not settle")


def force_on_blade(recorded: float, tip: float, drop: float) -> float:
    """Less than recorded where the rig answers much: recorded (1 - drop r^2 / (1 + r^2)), r the tip's receptance over
    DROP_AT."""
    r = (tip / recorded / DROP_AT) ** 2
    return recorded * (1 - drop * r / (1 + r))
