"""Iwan's sliders, compiled."""

from typing import Any

import numpy as np

from updamp.hbm.contact.compiled import iwan
from updamp.hbm.contact.compiled.kernel_forces import KernelForces
from updamp.hbm.contact.compiled.tables import tables
from updamp.hbm.harmonics import Harmonics


def iwan_forces(
    cycles: int, n_sliders: int, reference_displacement: float, harmonics: Harmonics, n_time: int
) -> KernelForces:
    """Of `IwanMicroslip`."""
    arguments = (cycles, n_sliders, reference_displacement, tables(harmonics, n_time))
    return KernelForces(iwan.force_with_tangent, iwan.perturbed_tangent, iwan.loop_areas, _own, arguments)


def _own(p: Any) -> Any:
    return type(p)(*(np.array(value, dtype=np.float64) for value in p))
