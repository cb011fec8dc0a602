"""The effects that updamp knows, by name, and a user's own."""

from collections.abc import Mapping
from importlib.metadata import entry_points
from types import MappingProxyType

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

# Of bladed rigs with a damper; in the order in which they are applied where several are.
CATALOGUE: Mapping[str, Effect] = MappingProxyType(
    {
        effect.name: effect
        for effect in (
            face_length.EFFECT,
            platform_height.EFFECT,
            blade_thickness.EFFECT,
            face_angle.EFFECT,
            clamp_flexibility.EFFECT,
            blade_mistuning.EFFECT,
            shaker_attachment.EFFECT,
            wire_stiffness.EFFECT,
            asymmetric_preload.EFFECT,
            pressure_crown.EFFECT,
            pressure_slope.EFFECT,
            edge_gap.EFFECT,
            friction_gradient.EFFECT,
            friction_by_face.EFFECT,
            friction_running_in.EFFECT,
            pressure_dependent_stiffness.EFFECT,
            sub_patch_microslip.EFFECT,
            velocity_dependent_friction.EFFECT,
            contact_viscosity.EFFECT,
            material_damping.EFFECT,
            power_law_damping.EFFECT,
            threshold_damping.EFFECT,
            tip_friction.EFFECT,
            platform_friction.EFFECT,
            blade_square_stiffness.EFFECT,
            blade_cubic_stiffness.EFFECT,
            blade_stop.EFFECT,
            breathing_crack.EFFECT,
            static_dynamic_coupling.EFFECT,
        )
    }
)


# Of models whose modes were identified in a test: they stand for a joint that the modes do not show.
JOINTS: Mapping[str, Effect] = MappingProxyType(
    {
        effect.name: effect
        for effect in (
            joint_viscous.EFFECT,
            joint_viscoelastic.EFFECT,
            joint_square.EFFECT,
            joint_cubic.EFFECT,
            joint_quintic.EFFECT,
            joint_clearance.EFFECT,
            joint_quadratic.EFFECT,
            joint_cubic_damping.EFFECT,
            joint_friction.EFFECT,
            joint_microslip.EFFECT,
        )
    }
)


# Faults of the measurement, of any rig.
FAULTS: Mapping[str, Effect] = MappingProxyType(
    {
        effect.name: effect
        for effect in (
            phase_lag.EFFECT,
            feed_through.EFFECT,
            sensor_gain.EFFECT,
            amplifier_drift.EFFECT,
            resonance_drift.EFFECT,
            sensor_compression.EFFECT,
        )
    }
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
