"""The effects that a rig file has taken up:

[[effects]]
name = "edge_gap"
file = "my_effect.py"             # for an effect of the user's own only
values = { depth = "0.3 um" }     # text with a unit; a plain number where a parameter has none
origin = "fitted to ..., 2026-11-20"
"""

import hashlib
import inspect
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from difflib import get_close_matches
from pathlib import Path
from types import MappingProxyType
from typing import Any

from updamp.effects.catalogue import OWN, catalogue
from updamp.effects.effect import Effect, EffectParameter
from updamp.effects.own_effect_check import refuse_unusable
from updamp.effects.own_effects import own_effect
from updamp.effects.placed import effect_called
from updamp.effects.rig_model import RigModel
from updamp.effects.user_effect import EffectError
from updamp.rig.effects import RigEffect
from updamp.rig.errors import RigError
from updamp.rig.fields import Quantity

KEYS = ("name", "file", "values", "origin")


@dataclass(frozen=True)
class ChosenEffect:
    """values: of all its parameters, in their units; origin: where they come from, "" if not stated
    file: that the effect was read from, None for one of the catalogue

    Another process that gets one reads the file itself, wherever that process has been started.
    """

    effect: Effect
    values: Mapping[str, float]
    origin: str = ""
    file: Path | None = None

    def __reduce__(self) -> tuple[Any, ...]:
        file = self.file.resolve() if self.file is not None else None
        return _restored, (self.effect.name, file, dict(self.values), self.origin)

    def apply(self, model: RigModel) -> RigModel:
        """raises: ValueError naming the effect where the model has no place for it"""
        try:
            return self.effect.apply(model, self.values)
        except (ValueError, KeyError) as error:  # KeyError: a point that the model does not have
            raise ValueError(f'the effect "{self.effect.name}" cannot be applied: {error.args[0]}') from error


def with_effects(model: RigModel, chosen: Sequence[ChosenEffect]) -> RigModel:
    """The model with all of them, in the order of the rig file.

    raises: ValueError naming the effect that the model has no place for, and how to take it off the file
    """
    for one in chosen:
        try:
            model = one.apply(model)
        except ValueError as error:
            raise ValueError(f"{error} (to take it off: updamp remove)") from error
    return model


def with_tried_effects(model: RigModel, chosen: Sequence[ChosenEffect]) -> RigModel:
    """As `with_effects`, the user's own tried first: once, where a model is made, and not at each step of a fit.

    raises: ValueError likewise; OwnCodeError for one of the user's own whose code fails
    """
    for one in chosen:
        if one.file is not None:
            refuse_unusable(one.effect, one.file, model)
    return with_effects(model, chosen)


def read_effects(tables: object, folder: Path) -> tuple[RigEffect, ...]:
    """As `chosen_effects`, in the form that a rig keeps; raises as it does"""
    return tuple(
        RigEffect(
            name=one.effect.name,
            values=dict(one.values),
            code=code_of(one.effect, one.file),
            units={p.name: p.unit for p in one.effect.parameters},
            origin=one.origin,
            file=one.file,
        )
        for one in chosen_effects(tables, folder)
    )


def resolved(rig_effects: Sequence[RigEffect]) -> tuple[ChosenEffect, ...]:
    """The effects of a rig, in its order, ready to be applied; raises: RigError where one is not there any more"""
    return tuple(_restored(one.name, one.file, one.values, one.origin) for one in rig_effects)


def _restored(name: str, file: Path | None, values: Mapping[str, float], origin: str) -> ChosenEffect:
    return ChosenEffect(_effect(name, file, "effects"), MappingProxyType(dict(values)), origin, file)


def code_of(effect: Effect, file: Path | None) -> str:
    """Hash of the file that defines an effect, "" for one of updamp's own: those have a version.

    file: that the effect was read from, None where it comes from the catalogue
    """
    if file is not None:
        return hashlib.sha256(file.read_bytes()).hexdigest()
    if effect.joint or effect is OWN.get(effect.name):
        return ""
    module = inspect.getmodule(effect.apply)
    source = module.__file__ if module is not None else None
    return hashlib.sha256(Path(source).read_bytes()).hexdigest() if source else ""


def chosen_effects(tables: object, folder: Path) -> tuple[ChosenEffect, ...]:
    """From the tables [[effects]] of a rig file, as read.

    tables: the array of tables; folder: where files that they name are sought
    raises: RigError with every problem found, one a line
    """
    if not isinstance(tables, Sequence) or isinstance(tables, str) or not all(isinstance(t, Mapping) for t in tables):
        raise RigError("effects: an array of tables is wanted: [[effects]] with name and values")
    found: list[ChosenEffect] = []
    problems: list[str] = []
    for i, table in enumerate(tables):
        try:
            found.append(_chosen(table, f"effects[{i}]", folder))
        except (RigError, EffectError) as error:
            problems += str(error).splitlines()
    names = [one.effect.name for one in found]
    problems += [
        f'effects: "{name}" is there {names.count(name)} times; keep one'
        for name in dict.fromkeys(names)
        if names.count(name) > 1
    ]
    if problems:
        raise RigError("\n".join(problems))
    return tuple(found)


def _chosen(table: Mapping[str, Any], path: str, folder: Path) -> ChosenEffect:
    problems = [f"{path}.{key}: unknown key; {_instead(key, KEYS)}" for key in table if key not in KEYS]
    name, origin, values, file = (table.get(key) for key in ("name", "origin", "values", "file"))
    if not isinstance(name, str):
        raise RigError("\n".join([*problems, f'{path}.name: missing; add it, such as name = "edge_gap"']))
    if origin is not None and not isinstance(origin, str):
        problems.append(f"{path}.origin = {origin!r}: text is wanted that says where the values come from")
    if file is not None and not isinstance(file, str):
        raise RigError("\n".join([*problems, f"{path}.file = {file!r}: the name of a Python file is wanted"]))
    effect = _effect(name, folder / file if file else None, path)
    if not isinstance(values, Mapping):
        example = ", ".join(f"{p.name} = {_example(p)}" for p in effect.parameters)
        problems.append(f"{path}.values: missing; add it, such as values = {{ {example} }}")
        values = {}
    problems += _problems(effect, values, f"{path}.values")
    if problems:
        raise RigError("\n".join(problems))
    given = {p.name: _value(p, values[p.name]) if p.name in values else p.null for p in effect.parameters}
    return ChosenEffect(effect, MappingProxyType(given), origin or "", folder / file if file else None)


def _effect(name: str, file: Path | None, path: str) -> Effect:
    if file is None:
        found = effect_called(name)
        if found is None:
            raise RigError(
                f'{path}.name = "{name}": no such effect; {_instead(name, tuple(catalogue()))}; one of your own needs '
                'the Python file that defines it, such as file = "my_effect.py"'
            )
        return found
    try:
        effect = own_effect(file)
    except EffectError as error:
        raise RigError(f"{path}.file: {error}") from error
    if effect.name != name:
        raise RigError(f'{path}.name = "{name}": {file} defines "{effect.name}"; state that name')
    return effect


def _problems(effect: Effect, values: Mapping[str, Any], path: str) -> Iterator[str]:
    names = tuple(p.name for p in effect.parameters)
    yield from (f"{path}.{key}: unknown parameter; {_instead(key, names)}" for key in values if key not in names)
    for p in effect.parameters:
        if p.name in values:
            try:
                _value(p, values[p.name])
            except ValueError as error:
                yield f"{path}.{p.name} = {values[p.name]!r}: {error}"


def _value(p: EffectParameter, stated: Any) -> float:
    """raises: ValueError saying what would be allowed"""
    if p.unit:
        value = Quantity(p.unit, f"{p.typical:g} {p.unit}").to_si(stated)
    elif isinstance(stated, (int, float)) and not isinstance(stated, bool):
        value = float(stated)
    else:
        raise ValueError(f"a number is wanted, such as {p.typical:g}")
    if not p.allows(value):
        raise ValueError(f"out of range: allowed is {p.allowed}")
    return value


def _example(p: EffectParameter) -> str:
    return f'"{p.typical:g} {p.unit}"' if p.unit else f"{p.typical:g}"


def _instead(wrong: str, known: Sequence[str]) -> str:
    close = get_close_matches(wrong, known, n=1)
    return f"did you mean {close[0]}?" if close else f"allowed are {', '.join(known)}"
