"""Contact elements in all states, and their laws in JAX alone, that compiled laws are held against."""

from dataclasses import dataclass
from typing import Any, ClassVar

import numpy as np

from updamp.hbm.contact.friction import FrictionParameters
from updamp.hbm.contact.law import force_for_analysis
from updamp.hbm.harmonics import Harmonics
from updamp.hbm.problem.elements import ElementGroup

HARMONICS = Harmonics((0, 1, 2, 3))
ELEMENTS = 60
HELD, GRAZING = slice(5, 9), slice(12, 18)


@dataclass(frozen=True)
class InJax:
    """The law without what is compiled."""

    law: Any
    directions: ClassVar[int] = 3
    decoupled_directions: ClassVar[tuple[int, ...]] = (0, 1)
    rate_dependent: ClassVar[bool] = False

    @property
    def cycles(self):
        return self.law.cycles

    def force(self, displacement, velocity, parameters):
        return force_for_analysis(self.law)(displacement, velocity, parameters)

    def reference_stiffness(self, parameters):
        return self.law.reference_stiffness(parameters)


@dataclass(frozen=True)
class AtSamples(InJax):
    """The force at the samples, of which loops are drawn."""

    def force(self, displacement, velocity, parameters):
        return self.law.force(displacement, velocity, parameters)


@dataclass(frozen=True)
class RateInJax(InJax):
    rate_dependent: ClassVar[bool] = True


class CoupledInJax(RateInJax):
    """Every direction's force depends on every motion."""

    decoupled_directions: ClassVar[tuple[int, ...]] = ()


@dataclass(frozen=True, eq=False)
class AllEvaluated(ElementGroup):
    """None of the elements is taken for stuck."""

    def may_slip_or_separate(self, displacement, *_):
        return np.arange(len(displacement))


def parameters(**changed):
    """All different; a third has no preload."""
    rng = np.random.default_rng(3)
    values = {
        "mu": 0.1 + rng.random(ELEMENTS), "kt": 0.5 + rng.random(ELEMENTS), "kn": 0.5 + rng.random(ELEMENTS),
        "n0": rng.random(ELEMENTS) * (np.arange(ELEMENTS) % 3 > 0), "t0": 0.05 * rng.normal(size=(ELEMENTS, 2)),
        "gap": 0.2 * rng.normal(size=ELEMENTS),
    }  # fmt: skip
    return FrictionParameters(**(values | changed))


def motions(p):
    """From motions that hardly slip to gross slip and separation."""
    rng = np.random.default_rng(4)
    motion = rng.normal(size=(ELEMENTS, 3, 7)) * np.array([0.4, 2, 2, 0.3, 0.3, 0.2, 0.2])
    motion *= np.geomspace(0.02, 3.0, ELEMENTS)[:, None, None]
    motion[:, 2] *= 0.6
    motion[HELD, :, 1:] = 0.0  # held away from rest
    motion[5] = 0.0  # at rest
    motion[9:12, 2, 1:] = 0.0  # constant normal force
    for e, lift in zip(range(12, 18), (1e-3, -1e-3, 1e-6, -1e-6, 1e-12, -1e-12), strict=True):
        lowest = (HARMONICS.synthesis(128) @ motion[e, 2]).min()
        motion[e, 2, 0] += lift - lowest - p.n0[e] / p.kn[e] + p.gap[e]  # grazing: just closed, just open
    motion[18:21, 2, 0] -= 20.0  # never in contact
    return motion


def of_springs(group, numbers):
    """Tangents of the reference springs alone."""
    return np.einsum("ed,df,ab->edafb", group.stiffness_of_one[numbers], np.eye(3), np.eye(7))
