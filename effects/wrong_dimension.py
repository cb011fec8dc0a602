"""What effects have in common that say a dimension of the rig is other than its file says."""

from dataclasses import dataclass

from updamp.effects.contact_faces import patches_of
from updamp.effects.dimension_blend import blended
from updamp.effects.effect import Effect, EffectParameter, Values
from updamp.effects.rig_model import RigModel
from updamp.rig.dimensions import DIMENSIONS

# Relative. Of the size of what a drawing leaves open: a chamfer at the ends of a face, a fillet, a worn surface.
TYPICAL = 0.02


@dataclass(frozen=True)
class WrongDimension:
    """name: of the effect, and of the dimension in `RigModel.dimensions`"""

    name: str

    def __call__(self, model: RigModel, values: Values) -> RigModel:
        """raises: ValueError where the model has no contacts, or was built without another value of the dimension"""
        change = values["change"]
        if change == 0:
            return model
        patches_of(model)
        if self.name not in model.dimensions:
            raise ValueError(
                f"this model was built for one value of {DIMENSIONS[self.name].key} alone; `updamp diagnose` builds "
                f"another (--dimensions {self.name}), and what it finds is stated in the rig file: "
                f"{DIMENSIONS[self.name].key} times {1 + change:.5g}"
            )
        return blended(model, model.dimensions[self.name], change)


def wrong_dimension(name: str, sentence: str, most: float, source: str) -> Effect:
    """most: bound on the size of its relative change; source: of the typical size"""
    change = EffectParameter("change", 0.0, -most, most, TYPICAL, "", source)
    return Effect(name, sentence, (change,), WrongDimension(name))
