"""An effect from a Python file of the user's own."""

import hashlib
import importlib.util
import math
import sys
import traceback
from collections.abc import Callable
from dataclasses import dataclass, replace
from pathlib import Path

from updamp.effects.effect import Effect, EffectParameter, Values
from updamp.effects.rig_model import RigModel
from updamp.rig.fields import Quantity


class EffectError(ValueError):
    """An effect that cannot be used; the message says where and what to do."""


class OwnCodeError(RuntimeError):
    """The user's code has failed: no effect without a place in the model, which is a ValueError."""


@dataclass(frozen=True)
class _Told:
    """The user's own `apply`, which tells what it stumbles over, and where."""

    apply: Callable[[RigModel, Values], RigModel]
    name: str
    path: Path

    def __call__(self, model: RigModel, values: Values) -> RigModel:
        """raises: ValueError, KeyError as they are: that the model has no place for the effect; else OwnCodeError"""
        try:
            changed = self.apply(model, values)
        except (ValueError, KeyError):
            raise
        except Exception as error:
            raise OwnCodeError(
                f'{place_of(error, self.path)}: apply of the effect "{self.name}" cannot be run: {in_words(error)}'
            ) from error
        if not isinstance(changed, RigModel):
            raise OwnCodeError(
                f'{self.path}: apply of the effect "{self.name}" returns {type(changed).__name__}: end it with return '
                "and the changed model"
            )
        return changed


def place_of(error: BaseException, path: Path) -> str:
    """The file with the last of its lines that the error went through."""
    lines = [frame.lineno for frame in traceback.extract_tb(error.__traceback__) if frame.filename == str(path)]
    return f"{path}, line {lines[-1]}" if lines else str(path)


def in_words(error: BaseException) -> str:
    """Its kind and the first line of what it says; the rest, of JAX for one, is not for a person."""
    return f"{type(error).__name__}: {(str(error).splitlines() or [''])[0]}"


def effect_from_file(path: Path) -> Effect:
    """The file's EFFECT. Other processes that load the same file get an effect that is pickled alike.

    raises: EffectError where the file is missing, cannot be run or does not define a usable EFFECT
    """
    path = path.resolve()
    if not path.is_file():
        raise EffectError(f"{path}: no such file; give a Python file that defines EFFECT")
    name = f"updamp_user_effect_{hashlib.sha256(str(path).encode()).hexdigest()[:12]}"
    spec = importlib.util.spec_from_file_location(name, path)
    if spec is None or spec.loader is None:
        raise EffectError(f"{path}: not a Python file; its name has to end in .py")
    module = importlib.util.module_from_spec(spec)
    sys.modules[name] = module
    try:
        spec.loader.exec_module(module)
    except Exception as error:  # whatever the user's code stumbles over
        del sys.modules[name]
        raise EffectError(f"{path}: cannot be run: {type(error).__name__}: {error}") from error
    if not hasattr(module, "EFFECT"):
        raise EffectError(f"{path}: defines no EFFECT; end it with EFFECT = Effect(name, sentence, parameters, apply)")
    effect = checked(module.EFFECT, str(path))
    return replace(effect, apply=_Told(effect.apply, effect.name, path))


def checked(effect: object, origin: str) -> Effect:
    """raises: EffectError where it is no effect, or one of its parameters makes no sense"""
    if not isinstance(effect, Effect):
        raise EffectError(f"{origin}: EFFECT is a {type(effect).__name__}; make it an updamp.effects.effect.Effect")
    for p in effect.parameters:
        if problem := _problem(p):
            raise EffectError(f'{origin}: parameter "{p.name}" of "{effect.name}": {problem}')
    if len({p.name for p in effect.parameters}) < len(effect.parameters) or not effect.parameters:
        raise EffectError(f'{origin}: "{effect.name}" needs parameters, each with a name of its own')
    return effect


def _problem(p: EffectParameter) -> str:
    if not all(map(math.isfinite, (p.null, p.lower, p.upper, p.typical))):
        return "null, lower, upper and typical have to be finite"
    if not p.lower <= p.null <= p.upper:
        return f"null = {p.null:g} has to lie within lower = {p.lower:g} and upper = {p.upper:g}"
    if p.unit and not _is_unit(p.unit):
        return f'unit = "{p.unit}": no such unit; write it as "N*s/m", or "" where there is none'
    if not p.lower <= p.typical <= p.upper or p.typical == p.null:
        return f"typical = {p.typical:g} has to lie within the bounds and apart from null = {p.null:g}"
    return ""


def _is_unit(text: str) -> bool:
    try:
        Quantity(text, f"1 {text}").to_si(f"1 {text}")
    except ValueError:
        return False
    return True
