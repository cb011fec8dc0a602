"""Contact laws written out for one step in time, the history a state: forces, tangents, and where sliders end.

A second writing beside hbm/contact/, which takes a settled period at once: nothing is shared but the parameters. Where
a slider ends follows from the displacement at the end of the step (return mapping; Simo and Hughes 1998, Computational
Inelasticity, sec. 1.4).
"""

from typing import NamedTuple, Protocol

import numpy as np
from numpy.typing import NDArray

from updamp.hbm.contact.friction import FrictionParameters
from updamp.hbm.contact.jenkins import JenkinsParameters
from updamp.hbm.contact.springs import CubicParameters, UnilateralParameters

Floats = NDArray[np.float64]


class LawStep(NamedTuple):
    """At the end of a step, of n elements with d directions and s sliders each.

    force: (n, d) less that at rest [N]; slider: (n, s) moved on [m]; tangent: (n, d, d) of the force by u [N/m]
    by_slider: (n, s) of the force in the slider's own direction by where it stood before [N/m]
    """

    force: Floats
    slider: Floats
    tangent: Floats
    by_slider: Floats


class LawInTime(Protocol):
    """Of all elements of a group."""

    def at_rest(self) -> Floats:
        """(n, s) sliders"""
        ...

    def step(self, u: Floats, slider: Floats) -> LawStep:
        """u: (n, d) displacement at the end of a step, slider: (n, s) before it [m]"""
        ...


class Box(NamedTuple):
    """Two Jenkins elements of equal stiffness and a unilateral normal spring: entries as in `FrictionParameters`."""

    mu: Floats
    kt: Floats
    kn: Floats
    n0: Floats
    t0: Floats
    gap: Floats

    @classmethod
    def of(cls, p: FrictionParameters) -> "Box":
        return cls(*(np.asarray(value) for value in p))

    def at_rest(self) -> Floats:
        return -self.t0 / self.kt[:, None]

    def step(self, u: Floats, slider: Floats) -> LawStep:
        normal = np.maximum(self.n0 + self.kn * (u[:, 2] - self.gap), 0.0)
        limit, kt = (self.mu * normal)[:, None], self.kt[:, None]
        trial = kt * (u[:, :2] - slider)
        sticks, closed = np.abs(trial) <= limit, normal > 0
        total = np.where(sticks, trial, np.sign(trial) * limit)
        tangent = np.zeros((len(u), 3, 3))
        tangent[:, (0, 1), (0, 1)] = np.where(sticks, kt, 0.0)
        tangent[:, :2, 2] = np.where(sticks, 0.0, np.sign(trial) * (self.mu * self.kn * closed)[:, None])
        tangent[:, 2, 2] = self.kn * closed
        rest = np.maximum(self.n0 - self.kn * self.gap, 0.0)
        force = np.column_stack([total - self.t0, normal - rest])
        return LawStep(force, u[:, :2] - total / kt, tangent, np.where(sticks, -kt, 0.0))


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
        return LawStep(force, u - force / kt, stiffness[:, :, None], -stiffness)


class Spring:
    """Of one direction, without history."""

    def __init__(self, n: int) -> None:
        self.nothing: Floats = np.zeros((n, 0))

    def at_rest(self) -> Floats:
        return self.nothing

    def _step(self, force: Floats, stiffness: Floats) -> LawStep:
        return LawStep(force, self.nothing, stiffness[:, :, None], self.nothing)


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
