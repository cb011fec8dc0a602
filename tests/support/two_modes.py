"""A beam of two identified modes that is driven at one point and whose tip each mode moves otherwise."""

from updamp.effects.rig_model import RigModel
from updamp.model.build import modal_before_effects
from updamp.rig.modal_rig import ModalRig

DRIVE, TIP = "arm.drive.x", "arm.tip.x"
# Angular frequencies [rad/s], damping ratio, mass-normalised shapes at drive and tip [kg^-1/2].
MODES = {"first": (40.0, 0.004, 0.4, 1.5), "second": (97.0, 0.005, 0.9, -1.1)}


def two_modes(tip: dict[str, float] | None = None) -> RigModel:
    """tip: other shapes there, by mode"""
    modes = {
        name: {
            "frequency": f"{frequency} Hz",
            "damping_ratio": damping,
            "shape": {DRIVE: f"{drive} kg^-0.5", TIP: f"{(tip or {}).get(name, at_tip)} kg^-0.5"},
        }
        for name, (frequency, damping, drive, at_tip) in MODES.items()
    }
    rig = ModalRig.model_validate({"kind": "modal", "name": "arm", "excitation": DRIVE, "modes": modes})
    return modal_before_effects(rig)
