"""Contact laws written out for one step in time, the history a state: forces, tangents, and where sliders end.

A second writing beside hbm/contact/, which takes a settled period at once: nothing is shared but the parameters. Where
a slider ends follows from the displacement at the end of the step (return mapping; Simo and Hughes 1998, Computational
Inelasticity, sec. 1.4).
"""

from typing import NamedTuple, Protocol

import numpy as np
from numpy.typing import NDArray

from updamp.hbm.contact.jenkins import JenkinsParameters
from updamp.hbm.contact.springs import CubicParameters, UnilateralParameters

Floats = NDArray[np.float64]


class LawStep(NamedTuple):
    """At the end of a step, of n elements with d directions and s sliders each.

    force: (n, d) less that at rest [N]; slider: (n, s) moved on [m]; tangent: (n, d, d) of the force by u [N/m], with
    opposite sign that by where the sliders stood before
    """

    force: Floats
    slider: Floats
    tangent: Floats


class LawInTime(Protocol):
    """Of all elements of a group."""

    def at_rest(self) -> Floats:
        """(n, s) sliders"""
        ...

    def step(self, u: Floats, slider: Floats) -> LawStep:
        """u: (n, d) displacement at the end of a step, slider: (n, s) before it [m]"""
        ...


class Friction(NamedTuple):
    """A slider behind a spring in the plane of the contact and a unilateral normal spring: entries as in
    `FrictionParameters`. The laws differ in what they do with a trial force beyond the limit."""

    mu: Floats
    kt: Floats
    kn: Floats
    n0: Floats
    t0: Floats
    gap: Floats

    def at_rest(self) -> Floats:
        return -self.t0 / self.kt[:, None]

    def normal(self, u: Floats) -> Floats:
        """(n,) pressing force, preload included [N]"""
        return np.maximum(self.n0 + self.kn * (u[:, 2] - self.gap), 0.0)

    def result(self, u: Floats, total: Floats, by_trial: Floats, by_limit: Floats) -> LawStep:
        """total: (n, 2) tangential force [N]; by_trial: (n, 2, 2), by_limit: (n, 2) its derivatives by the trial
        force and by the limit [-]"""
        normal = self.normal(u)
        stiffness = self.kn * (normal > 0)
        tangent = np.zeros((len(u), 3, 3))
        tangent[:, :2, :2] = by_trial * self.kt[:, None, None]
        tangent[:, :2, 2] = by_limit * (self.mu * stiffness)[:, None]
        tangent[:, 2, 2] = stiffness
        rest = np.maximum(self.n0 - self.kn * self.gap, 0.0)
        force = np.column_stack([total - self.t0, normal - rest])
        return LawStep(force, u[:, :2] - total / self.kt[:, None], tangent)


class Box(Friction):
    """Each direction has the limit mu N of its own."""

    def step(self, u: Floats, slider: Floats) -> LawStep:
        limit = (self.mu * self.normal(u))[:, None]
        trial = self.kt[:, None] * (u[:, :2] - slider)
        sticks, sign = np.abs(trial) <= limit, np.sign(trial)
        by_trial = np.zeros((len(u), 2, 2))
        by_trial[:, (0, 1), (0, 1)] = sticks
        return self.result(u, np.where(sticks, trial, sign * limit), by_trial, np.where(sticks, 0.0, sign))


class Circle(Friction):
    """The force stays within the circle mu N, drawn back along its radius."""

    def step(self, u: Floats, slider: Floats) -> LawStep:
        limit = self.mu * self.normal(u)
        trial = self.kt[:, None] * (u[:, :2] - slider)
        size = np.hypot(trial[:, 0], trial[:, 1])
        sticks = size <= limit
        radial = trial / np.where(sticks, 1.0, size)[:, None]
        share = np.where(sticks, 1.0, limit / np.where(sticks, 1.0, size))
        along_radius = np.where(sticks, 0.0, share)[:, None, None] * radial[:, :, None] * radial[:, None, :]
        by_trial = share[:, None, None] * np.eye(2) - along_radius
        return self.result(u, share[:, None] * trial, by_trial, np.where(sticks[:, None], 0.0, radial))


class Slider(NamedTuple):
    """A Jenkins element in one direction. kt: (n,) [N/m]; limit: (n,) [N]"""

    kt: Floats
    limit: Floats

    @classmethod
    def of(cls, p: JenkinsParameters) -> "Slider":
        return cls(np.asarray(p.kt).ravel(), np.asarray(p.limit).ravel())

    def at_rest(self) -> Floats:
        return np.zeros((len(self.kt), 1))

    def step(self, u: Floats, slider: Floats) -> LawStep:
        kt, limit = self.kt[:, None], self.limit[:, None]
        trial = kt * (u - slider)
        sticks = np.abs(trial) <= limit
        force = np.where(sticks, trial, np.sign(trial) * limit)
        stiffness = np.where(sticks, kt, 0.0)
        return LawStep(force, u - force / kt, stiffness[:, :, None])


class Spring:
    """Of one direction, without history."""

    def __init__(self, n: int) -> None:
        self.nothing: Floats = np.zeros((n, 0))

    def at_rest(self) -> Floats:
        return self.nothing

    def _step(self, force: Floats, stiffness: Floats) -> LawStep:
        return LawStep(force, self.nothing, stiffness[:, :, None])


class Cubic(Spring):
    """force = coefficient u^3"""

    def __init__(self, p: CubicParameters) -> None:
        self.coefficient = np.asarray(p.coefficient).reshape(-1, 1)
        super().__init__(len(self.coefficient))

    def step(self, u: Floats, slider: Floats) -> LawStep:  # noqa: ARG002  it has none
        return self._step(self.coefficient * u**3, 3 * self.coefficient * u**2)


class Unilateral(Spring):
    """force = stiffness max(u - gap, 0)"""

    def __init__(self, p: UnilateralParameters) -> None:
        self.stiffness, self.gap = (np.asarray(value).reshape(-1, 1) for value in p)
        super().__init__(len(self.gap))

    def step(self, u: Floats, slider: Floats) -> LawStep:  # noqa: ARG002  it has none
        open_by = u - self.gap
        return self._step(self.stiffness * np.maximum(open_by, 0.0), self.stiffness * (open_by > 0))


def along(law: LawInTime, motion: Floats) -> Floats:
    """(n, s) sliders after the samples (n_time, n, d) of a period have been passed through twice, from rest: where the
    harmonic balance's motion leaves them. Jenkins elements settle in two periods."""
    slider = law.at_rest()
    for u in (*motion, *motion):
        slider = law.step(u, slider).slider
    return slider
