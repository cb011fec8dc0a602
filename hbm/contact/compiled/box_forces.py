"""The box laws, compiled."""

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

import numpy as np

from updamp.hbm.contact.compiled import jenkins_box, jenkins_box_sampled
from updamp.hbm.contact.compiled.by_friction import by_friction
from updamp.hbm.contact.compiled.kernel_forces import Floats, FrictionKernelForces, Integers, KernelForces, own
from updamp.hbm.contact.compiled.tables import tables
from updamp.hbm.contact.friction import FrictionParameters
from updamp.hbm.harmonics import Harmonics


@dataclass(frozen=True, eq=False)
class BoxForces(FrictionKernelForces):
    """states: as `evaluate`, writes `observe.ContactState`"""

    states: Callable[..., None]

    def contact_states(self, numbers: Integers, displacement: Floats, parameters: Any) -> Integers:
        states = np.empty(len(numbers), dtype=np.int64)
        self.states(numbers, own(displacement), self.own(parameters), *self.arguments, states)
        return states


def between_samples(cycles: int, harmonics: Harmonics, n_time: int) -> BoxForces:
    """Of `JenkinsBox`."""
    law, arguments = jenkins_box, (cycles, tables(harmonics, n_time))
    forces = law.force_with_tangent, law.perturbed_tangent, law.loop_areas
    return BoxForces(*forces, _own, arguments, by_friction, law.contact_states)


def at_samples(cycles: int, harmonics: Harmonics, n_time: int) -> KernelForces:
    """Of `SampledJenkinsBox`."""
    law, arguments = jenkins_box_sampled, (cycles, tables(harmonics, n_time))
    return KernelForces(law.force_with_tangent, law.perturbed_tangent, law.loop_areas, _own, arguments)


def _own(p: Any) -> FrictionParameters:
    """One friction coefficient an element, or one a sample."""
    mu, *others = (np.array(value, dtype=np.float64) for value in (p.mu, p.kt, p.kn, p.n0, p.t0, p.gap))
    return FrictionParameters(mu.reshape(len(mu), -1), *others)  # type: ignore[arg-type]
