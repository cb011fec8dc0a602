"""All contacts of a system in one step: the groups' laws together, or why they cannot be marched."""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from updamp.hbm.contact.coulomb_circle import CoulombCircle
from updamp.hbm.contact.jenkins import Jenkins
from updamp.hbm.contact.jenkins_box import JenkinsBox
from updamp.hbm.contact.jenkins_box_sampled import SampledJenkinsBox
from updamp.hbm.contact.springs import CubicSpring, UnilateralSpring
from updamp.hbm.problem.elements import ElementGroup
from updamp.hbm.time_marching.laws import Box, Circle, Cubic, LawInTime, LawStep, Slider, Unilateral, along

Floats = NDArray[np.float64]
Integers = NDArray[np.int64]

# Laws that are written out for a step. Effects that change a law give it a class of its own, and are not among them.
IN_TIME: Mapping[type, Callable[[Any], LawInTime]] = {
    JenkinsBox: lambda p: Box(*p),
    SampledJenkinsBox: lambda p: Box(*p),
    CoulombCircle: lambda p: Circle(*p),
    Jenkins: Slider.of,
    CubicSpring: Cubic,
    UnilateralSpring: Unilateral,
}


def not_marched(groups: Sequence[ElementGroup]) -> str:
    """Why these cannot be marched, "" where they can."""
    unknown = dict.fromkeys(type(group.law).__name__ for group in groups if type(group.law) not in IN_TIME)
    return f"the law {', '.join(unknown)} is not written for marching in time" if unknown else ""


@dataclass(frozen=True, eq=False)
class Contacts:
    """laws: of the groups; rows: of each (n, d), that its elements act on"""

    laws: tuple[LawInTime, ...]
    rows: tuple[Integers, ...]

    @staticmethod
    def of(groups: Sequence[ElementGroup]) -> "Contacts":
        """raises: ValueError where one cannot be marched, with the reason"""
        if reason := not_marched(groups):
            raise ValueError(reason)
        if any(group.copies is not None for group in groups):
            raise ValueError("half of a symmetric problem is not marched: take the whole")
        return Contacts(tuple(IN_TIME[type(g.law)](g.values) for g in groups), tuple(g.rows for g in groups))

    def along(self, motion: Floats) -> tuple[Floats, ...]:
        """Sliders of each group; motion: (n_time, n_relative)"""
        return tuple(along(law, motion[:, rows]) for law, rows in zip(self.laws, self.rows, strict=True))

    def step(self, x: Floats, sliders: Sequence[Floats]) -> tuple[Floats, tuple[LawStep, ...]]:
        """(n_relative,) force at the end of a step, and of each group what its law gives; x: (n_relative,)"""
        force, groups = np.empty_like(x), zip(self.laws, self.rows, sliders, strict=True)
        steps = tuple(law.step(x[rows], slider) for law, rows, slider in groups)
        for rows, step in zip(self.rows, steps, strict=True):
            force[rows] = step.force
        return force, steps
