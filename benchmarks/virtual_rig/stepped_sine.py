"""A stepped sine on the bench: frequency by frequency at held force, each from where the last one left the rig.

Where the motion cannot be continued, or only to one that no rig stays in, the step is divided; where that does not help
either the rig has jumped, and the motion is sought from the stuck one with the force raised in steps.

Newton's method finds motions between two folds as well, and near a jump it may come to one from anywhere. At a fixed
frequency the response is S-shaped in the force there: between the folds a motion that is less takes more force, and is
unstable (A. H. Nayfeh and D. T. Mook, Nonlinear Oscillations, 1979, chapter 4). That does not depend on where the
sweep came from.
"""

from collections.abc import Iterator
from contextlib import suppress
from dataclasses import dataclass, field, replace

import numpy as np
from numpy.typing import NDArray

from updamp.benchmarks.virtual_rig.assembled import Assembled
from updamp.benchmarks.virtual_rig.periodic import Motion, NotSolvedError, SolverOptions, motion_at

Floats = NDArray[np.float64]

# Shares of the force by which it is changed to see which way the motion goes: three times what a force is held to,
# since where contacts change their states a branch turns back within some thousandths, dozens of times, and such folds
# are none; and as much as it is held to, next to a fold beyond which there is no motion nearby.
_CHANGED = (0.01, -0.01, 0.003, -0.003)
# What they change is ten-thousandths of the motion at least. What is not soon found, or is farther away than a tenth of
# the motion, is not nearby: between parts of a branch phases differ by that and more.
_SOON, _ROUGHLY, _NEARBY = 15, 1e-5, 0.1
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
            if not self.is_unstable(found):
                return found
        if depth == 4:
            raise NotSolvedError(f"{w / 2 / np.pi:.3f} Hz: not reached in steps")
        self.before, self.motion = last, self._continued((last.w + w) / 2, (last.force + force) / 2, depth + 1)
        return self._continued(w, force, depth + 1)

    def is_unstable(self, motion: Motion) -> bool:
        """Whether contacts move less under more force; where there is no motion nearby under more or less force that is
        not known, and it counts as stable."""
        aside = StepMotor(self.rig, replace(self.options, iterations=_SOON, tolerance=_ROUGHLY), self.motion)
        size = float(np.linalg.norm(motion.x))
        for more in _CHANGED:
            with suppress(NotSolvedError):
                x = aside.settled(motion.w, motion.force * (1 + more), motion.x).x
                if np.linalg.norm(x - motion.x) < _NEARBY * size:
                    return bool(more * (np.linalg.norm(x) - size) < 0)
        return False

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
                if not self.is_unstable(found):
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
