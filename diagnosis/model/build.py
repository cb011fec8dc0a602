"""From the stages of a rig to the model that effects may change."""

from updamp.diagnosis.effects.chosen import resolved, with_effects
from updamp.diagnosis.model.calibration import calibrated
from updamp.diagnosis.model.rig_model import RigModel
from updamp.fem.contact_rest import StaticContact
from updamp.fem.damper_models import DAMPER_MODELS
from updamp.fem.reduced_model import ReducedModel
from updamp.hbm.harmonics import Harmonics
from updamp.hbm.linear_model import from_reduced
from updamp.hbm.rig_system import contact_elements, wires
from updamp.rig import Rig

Place = tuple[float, float, float]


def rig_model(reduced: ReducedModel, rest: StaticContact, rig: Rig) -> RigModel:
    """The rig with the calibration and the effects that its file has taken up, in that order, as a fit applies them.

    Without any its `system` is that of hbm.rig_system.rig_system.
    raises: ValueError naming an effect or factor that the rig has no place for
    """
    return with_effects(rig_before_effects(reduced, rest, rig), resolved(rig.effects))


def rig_before_effects(reduced: ReducedModel, rest: StaticContact, rig: Rig) -> RigModel:
    """The rig with the calibration of its file: the base of a `Parametrisation`, which applies the effects itself."""
    return calibrated(_as_built(reduced, rest, rig), rig.calibration)


def _as_built(reduced: ReducedModel, rest: StaticContact, rig: Rig) -> RigModel:
    """Only the study's damper model is applied; harmonics, samples and law are those of the
    rig file."""
    reduced, rest = DAMPER_MODELS[rig.damper_model].apply(reduced, rest)
    return RigModel(
        components=from_reduced(reduced, rig.material.loss_factor),
        owner=tuple(component.name for component in reduced.components for _ in component.omega),
        attachments=wires(rig),
        contacts=contact_elements(reduced.contacts.area, rest, rig),
        patches=reduced.contacts,
        excitation=f"blade_{rig.excitation.blade}.excitation.x",
        harmonics=Harmonics(rig.harmonic_balance.harmonics),
        time_samples=rig.harmonic_balance.time_samples,
        places=_places(rig),
        stated_pressure=float(rest.normal_force.sum() / reduced.contacts.area.sum()),
    )


def _places(rig: Rig) -> dict[str, Place]:
    """Of the blades' clamps and points; the left blade is the mirror image of the right one."""
    middle, outer = rig.blade.axis_offset, rig.blade.axis_offset + rig.blade.thickness / 2
    right = {
        "root": (middle, 0.0, 0.0),
        "excitation": (outer, rig.excitation.height, 0.0),
        "tip": (outer, rig.response_height, 0.0),
        "platform": (rig.platform.gap / 2, rig.platform.top, 0.0),
    }
    return {
        f"blade_{side}.{name}": (sign * x, y, z)
        for side, sign in (("left", -1.0), ("right", 1.0))
        for name, (x, y, z) in right.items()
    }
