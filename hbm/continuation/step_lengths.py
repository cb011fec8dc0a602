"""How long the steps of a continuation are: one control for response curves and for resonances followed in force."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np


@dataclass(frozen=True)
class StepLengths:
    """Steps are lengths of arc in a relative metric: about what a relative change of the amplitude, or one of the phase
    in radians, counts.

    first_step, smallest_step, largest_step: the corrector's failures shorten the step down to the smallest. Newton's
        method leaves 1e-9 of the displacement: in a step of 1e-6 the direction is known to a thousandth. Kinks may be
        as close to each other (3e-5 where seen, benchmarks/harmonic_balance/NOTES.md, Kinks closer than a step)
    short_step: what stops steps up to this is a kink
    shortening: what a step that has failed is divided by: a long one, and a short one
    wanted_iterations: steps grow where Newton needs fewer and shrink where it needs more
    most_growth: of a step over the one before, and the most that it shrinks by. After a step that had to be shortened
        there is none, as in the integration of differential equations (Hairer, Norsett and Wanner 1993, Solving
        Ordinary Differential Equations I, section II.4)
    frequency_scale: share of the window that counts as one unit of arc
    moved: least and largest distance from the last point at which a solution counts, as shares of the step: on a curve
        that bends evenly the plane across the tangent is met at a little more than the step; what lies elsewhere is
        another branch
    off_predicted: a solution no further off the predicted place than this share of the step is on the branch, what lies
        further off may be another one: branches lie close to each other where many contacts change their states, and
        nothing at both ends of a long step tells them apart (angle between predictor and curve: Allgower and Georg
        1990, Numerical Continuation Methods, section 6.1). The same of what the tangents at both ends do not account
        for, where the branch turns in a kink on the way. Tables in benchmarks/harmonic_balance/NOTES.md set it
    resolution: the most that a branch with a kink may be off the chord between two points [arc]: as a share of the
        vibration. One that turns by the angle a half way along a step s is s a / 4 off it. What comes back closer than
        this beside itself may be passed over
    sharp_turns: in steps up to this length the branch may turn by any angle: in a kink
    bend_within, bend_cosine: the predictor is bent by the change of the tangent from the point before, but for steps
        longer than so many times the one that the change is from, and where the tangents' cosine is below this:
        across a kink the change tells nothing

    raises: ValueError naming the option that is out of range
    """

    first_step: float = 0.05
    smallest_step: float = 1e-6
    largest_step: float = 0.2
    short_step: float = 0.01
    shortening: tuple[float, float] = (2.0, 4.0)
    wanted_iterations: int = 4
    most_growth: float = 2.0
    frequency_scale: float = 0.5
    moved: tuple[float, float] = (0.5, 1.6)
    off_predicted: float = 0.05
    resolution: float = 0.005
    sharp_turns: float = 2e-3
    bend_within: float = 4.0
    bend_cosine: float = 0.9

    def __post_init__(self) -> None:
        if not 0 < self.smallest_step < self.first_step <= self.largest_step:
            raise ValueError(
                f"smallest_step = {self.smallest_step}, first_step = {self.first_step}, largest_step = "
                f"{self.largest_step}: 0 < smallest_step < first_step <= largest_step is needed"
            )
        if self.frequency_scale <= 0:
            raise ValueError(f"frequency_scale = {self.frequency_scale}: it must be positive")
        if self.most_growth < 1:
            raise ValueError(f"most_growth = {self.most_growth}: at least 1")
        if min(self.shortening) <= 1:
            raise ValueError(f"shortening = {self.shortening}: each above 1")
        if not 0 < self.off_predicted < 1:
            raise ValueError(f"off_predicted = {self.off_predicted}: a share between 0 and 1")
        if not 0 <= self.resolution < 1:
            raise ValueError(f"resolution = {self.resolution}: a share below 1")
        if not 0 < self.moved[0] < 1 < self.moved[1]:
            raise ValueError(f"moved = {self.moved}: one share below 1 and one above it are needed")

    def scale_w(self, window: tuple[float, float]) -> float:
        """Angular frequency that counts as one unit of arc [rad/s]; window [Hz]."""
        return 2 * np.pi * self.frequency_scale * (window[1] - window[0])

    def no_shorter(self, lengths: Sequence[float]) -> tuple[float, ...]:
        """The lengths, those below the smallest step raised to it, each once."""
        return tuple(dict.fromkeys(max(length, self.smallest_step) for length in lengths))

    def shortened(self, step: float) -> float:
        long, short = self.shortening
        return max(step / (long if step > max(self.short_step, self.smallest_step) else short), self.smallest_step)

    def recovered(self, moved: float) -> float:
        """The step to try behind a place where no step was solved, and that was left by a step of this length."""
        return float(np.clip(moved, self.smallest_step, self.first_step))

    def following(self, step: float, moved: float, iterations: int, shortened: bool) -> float:
        """The step to try after one that Newton has solved in so many iterations.

        moved: how far it has led; shortened: whether a longer one had failed before
        """
        growth = 2.0 ** ((self.wanted_iterations - iterations) / 2)
        growth = float(np.clip(growth, 1 / self.most_growth, 1.0 if shortened else self.most_growth))
        return float(np.clip(max(step, moved) * growth, self.smallest_step, self.largest_step))

    def counts(self, moved: float, step: float) -> bool:
        """Whether a solution so far from the last point is the one that the step was to lead to."""
        return self.moved[0] * step < moved < self.moved[1] * step

    def as_predicted(self, off: float, moved: float) -> bool:
        """Whether a solution this far off the predicted place, and from the last point, is on the branch."""
        return moved < self.sharp_turns or off <= self.off_predicted * moved

    def one_turn(self, angle: float, off: float, moved: float) -> bool:
        """Whether a branch that turns once, by this angle [rad], leads so far [arc].

        off: what the tangents at both ends do not account for of the move [arc]"""
        return off <= self.off_predicted * moved and angle * moved <= 4 * self.resolution

    def bent(self, step: float, before: float, cosine: float) -> bool:
        """Whether the change of the tangent along the step before, and the cosine between both, say how the branch
        goes on."""
        return step <= self.bend_within * before and cosine >= self.bend_cosine
