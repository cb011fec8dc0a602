"""An effect from a Python file of the user's own."""

import hashlib
import importlib.util
import math
import sys
from pathlib import Path

from updamp.effects.effect import Effect, EffectParameter


class EffectError(ValueError):
    """An effect that cannot be used; the message says where and what to do."""


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
    return checked(module.EFFECT, str(path))


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
    if not p.lower <= p.typical <= p.upper or p.typical == p.null:
        return f"typical = {p.typical:g} has to lie within the bounds and apart from null = {p.null:g}"
    return ""
