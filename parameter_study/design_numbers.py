"""The seven numbers that a damper design is judged by, of one resonance: Table 1b of Pesaresi et al. (2017)."""

from dataclasses import dataclass

import numpy as np

from updamp.hbm.newton.observe import friction_share
from updamp.model.small_amplitude import without_contacts
from updamp.parameter_study.families import CurveName
from updamp.parameter_study.solved_study import SolvedStudy
from updamp.rig.damper_mass import damper_mass


@dataclass(frozen=True)
class DesignNumbers:
    """All without unit. u: along x, v: along y, of the excited blade; first harmonic at the resonance.

    force_ratio: A, pull over excitation
    acceleration_ratio: B, acceleration that would make the damper weigh the pull, over that of the tip
    displacement_ratio: C, u of the platform over u of the tip; platform_ratio: D, u over v of the platform
    frequency_shift: E, resonance over the free blade's first frequency
    energy_ratio: F, friction loss over the work of the excitation
    contact_strain: G, mean pressure at rest over the blades' Young's modulus
    """

    force_ratio: float
    acceleration_ratio: float
    displacement_ratio: float
    platform_ratio: float
    frequency_shift: float
    energy_ratio: float
    contact_strain: float


LETTERS = dict(zip(DesignNumbers.__dataclass_fields__, "ABCDEFG", strict=True))


def design_numbers(solved: SolvedStudy, name: CurveName) -> DesignNumbers:
    """raises: UnknownResultError where the curve is missing or not complete"""
    curve, model = solved.curve(name), solved.model(name.variant)
    rig = solved.variants[name.variant].geometry
    peak = solved.peak_of(name, curve)
    i, blade = peak.place, f"blade_{rig.excitation.blade}"
    tip, u, v = (float(abs(curve.amplitude(f"{blade}.{at}")[i])) for at in ("tip.x", "platform.x", "platform.y"))
    w = 2 * np.pi * float(curve.frequency[i])
    assert model.stated_pressure is not None, "a rig with geometry has contacts"
    return DesignNumbers(
        force_ratio=rig.load.pull / name.force,
        acceleration_ratio=rig.load.pull / damper_mass(rig) / (tip * w**2),
        displacement_ratio=u / tip,
        platform_ratio=u / v,
        frequency_shift=peak.frequency / without_contacts(model, blade, 0),
        energy_ratio=friction_share(float(curve.friction_loss[i]), float(curve.work_in[i])),
        contact_strain=model.stated_pressure / rig.material.youngs_modulus,
    )
