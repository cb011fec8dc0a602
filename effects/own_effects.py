"""Effects of the user's own, by their files: loaded, with names that are theirs alone, and tried on the model."""

from collections.abc import Sequence
from pathlib import Path

from updamp.effects.effect import Effect
from updamp.effects.own_effect_check import refuse_unusable
from updamp.effects.placed import effect_called
from updamp.effects.rig_model import RigModel
from updamp.effects.user_effect import EffectError, effect_from_file


def own_effect(path: Path) -> Effect:
    """raises: EffectError where the file defines no usable effect, or one with a name of the catalogue's"""
    effect = effect_from_file(path)
    if effect_called(effect.name) is not None:
        raise EffectError(f'{path}: "{effect.name}" is the name of an effect of the catalogue; give yours another one')
    return effect


def own_effects(paths: Sequence[Path], model: RigModel) -> tuple[Effect, ...]:
    """Each tried on the model.

    raises: as `own_effect`, and where two have one name; OwnCodeError as `refuse_unusable`
    """
    found: dict[str, Path] = {}
    effects = []
    for path in paths:
        effect = own_effect(path)
        if effect.name in found:
            raise EffectError(f'{path}: "{effect.name}" is the name of the effect of {found[effect.name]} too')
        found[effect.name] = path
        refuse_unusable(effect, path, model)
        effects.append(effect)
    return tuple(effects)
