"""The box laws, compiled."""

from typing import Any

import numpy as np

from updamp.hbm.contact.compiled import jenkins_box, jenkins_box_sampled
from updamp.hbm.contact.compiled.kernel_forces import KernelForces
from updamp.hbm.contact.compiled.tables import tables
from updamp.hbm.contact.friction import FrictionParameters
from updamp.hbm.harmonics import Harmonics


def between_samples(cycles: int, harmonics: Harmonics, n_time: int) -> KernelForces:
    """Of `JenkinsBox`."""
    law, arguments = jenkins_box, (cycles, tables(harmonics, n_time))
    return KernelForces(law.force_with_tangent, law.perturbed_tangent, law.loop_areas, _own, arguments)


def at_samples(cycles: int, harmonics: Harmonics, n_time: int) -> KernelForces:
    """Of `SampledJenkinsBox`."""
    law, arguments = jenkins_box_sampled, (cycles, tables(harmonics, n_time))
    return KernelForces(law.force_with_tangent, law.perturbed_tangent, law.loop_areas, _own, arguments)


def _own(p: Any) -> FrictionParameters:
    """One friction coefficient an element, or one a sample."""
    mu, *others = (np.array(value, dtype=np.float64) for value in (p.mu, p.kt, p.kn, p.n0, p.t0, p.gap))
    return FrictionParameters(mu.reshape(len(mu), -1), *others)  # type: ignore[arg-type]
