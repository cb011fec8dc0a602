"""The effects that updamp knows, by name, and a user's own."""

from collections.abc import Mapping
from importlib.metadata import entry_points
from types import MappingProxyType, ModuleType

from updamp.effects import (
    amplifier_drift,
    asymmetric_preload,
    blade_cubic_stiffness,
    blade_mistuning,
    blade_square_stiffness,
    blade_stop,
    blade_thickness,
    breathing_crack,
    clamp_flexibility,
    contact_viscosity,
    edge_gap,
    face_angle,
    face_length,
    feed_through,
    friction_by_face,
    friction_gradient,
    friction_running_in,
    joint_clearance,
    joint_cubic,
    joint_cubic_damping,
    joint_friction,
    joint_microslip,
    joint_quadratic,
    joint_quintic,
    joint_slider,
    joint_square,
    joint_viscoelastic,
    joint_viscous,
    material_damping,
    phase_lag,
    platform_friction,
    platform_height,
    power_law_damping,
    pressure_crown,
    pressure_dependent_stiffness,
    pressure_slope,
    resonance_drift,
    sensor_compression,
    sensor_delay,
    sensor_gain,
    shaker_attachment,
    static_dynamic_coupling,
    sub_patch_microslip,
    threshold_damping,
    tip_friction,
    velocity_dependent_friction,
    wire_stiffness,
)
from updamp.effects.effect import Effect
from updamp.effects.user_effect import EffectError, checked

GROUP = "updamp.effects"


def _by_name(*modules: ModuleType) -> Mapping[str, Effect]:
    """Their effects, in this order. raises: ValueError for a name that two of them have"""
    found: dict[str, Effect] = {}
    for module in modules:
        effect: Effect = module.EFFECT
        if effect.name in found:
            raise ValueError(f'{module.__name__}: there is an effect "{effect.name}" already')
        found[effect.name] = effect
    return MappingProxyType(found)


# Of bladed rigs with a damper; in the order in which they are applied where several are.
CATALOGUE = _by_name(
    face_length,
    platform_height,
    blade_thickness,
    face_angle,
    clamp_flexibility,
    blade_mistuning,
    shaker_attachment,
    wire_stiffness,
    asymmetric_preload,
    pressure_crown,
    pressure_slope,
    edge_gap,
    friction_gradient,
    friction_by_face,
    friction_running_in,
    pressure_dependent_stiffness,
    sub_patch_microslip,
    velocity_dependent_friction,
    contact_viscosity,
    material_damping,
    power_law_damping,
    threshold_damping,
    tip_friction,
    platform_friction,
    blade_square_stiffness,
    blade_cubic_stiffness,
    blade_stop,
    breathing_crack,
    static_dynamic_coupling,
)

# Of models whose modes were identified in a test: they stand for a joint that the modes do not show.
JOINTS = _by_name(
    joint_viscous,
    joint_viscoelastic,
    joint_square,
    joint_cubic,
    joint_quintic,
    joint_clearance,
    joint_quadratic,
    joint_cubic_damping,
    joint_friction,
    joint_slider,
    joint_microslip,
)

# Faults of the measurement, of any rig.
FAULTS = _by_name(
    phase_lag,
    sensor_delay,
    feed_through,
    sensor_gain,
    amplifier_drift,
    resonance_drift,
    sensor_compression,
)
OWN: Mapping[str, Effect] = MappingProxyType({**CATALOGUE, **JOINTS, **FAULTS})


def catalogue() -> Mapping[str, Effect]:
    """updamp's own effects, and those that installed packages offer under the entry point group
    "updamp.effects": each names a module that defines EFFECT, or the effect itself.

    raises: EffectError for an entry point that cannot be loaded, is no effect or has a name that is taken
    """
    found = dict(OWN)
    for point in entry_points(group=GROUP):
        origin = f'entry point "{point.name}" ({point.value}) of {GROUP}'
        try:
            loaded = point.load()
        except Exception as error:  # whatever a foreign module stumbles over
            raise EffectError(f"{origin} cannot be loaded: {error}; correct or uninstall its package") from error
        effect = checked(getattr(loaded, "EFFECT", loaded), origin)
        if effect.name in found:
            raise EffectError(f'{origin}: there is an effect "{effect.name}" already; rename it')
        found[effect.name] = effect
    return MappingProxyType(found)
