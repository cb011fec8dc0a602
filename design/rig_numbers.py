"""A number of a rig by its dotted path: what it is now, its unit, and what the rig file would refuse there.

Paths are those of `updamp check`: "damper.face_length", "effects.edge_gap.depth", "calibration.loss_factor".
"""

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from difflib import get_close_matches
from typing import Annotated, Any, get_args

from pydantic import BaseModel, TypeAdapter, ValidationError
from pydantic.fields import FieldInfo

from updamp.effects.catalogue import catalogue
from updamp.effects.chosen import resolved
from updamp.effects.effect import EffectParameter
from updamp.effects.placed import effect_called
from updamp.model.calibration import read_calibration
from updamp.rig.fields import Quantity
from updamp.rig.modal_rig import ModalRig
from updamp.rig.rig import Rig

AnyRig = Rig | ModalRig


@dataclass(frozen=True)
class RigNumber:
    """value: at present, SI; quantity: how it is written with a unit, None for a plain number
    whole: whether it is an integer; check: raises ValueError for a value, written as in the file, that is refused there
    """

    path: str
    value: float
    quantity: Quantity | None
    whole: bool
    check: Callable[[Any], object]


def number_at(rig: AnyRig, path: str) -> RigNumber:
    """raises: ValueError naming the part of the path that is not there, and what is"""
    first, *rest = path.split(".")
    if first == "effects" and len(rest) >= 2:  # an effect's name may have the point of its joint in it
        return _of_effect(rig, path, ".".join(rest[:-1]), rest[-1])
    if first == "calibration" and len(rest) == 1:
        return _of_calibration(rig, path, rest[0])
    return _of_table(rig, path)


def _of_table(rig: AnyRig, path: str) -> RigNumber:
    *tables, last = path.split(".")
    here: Any = rig
    for depth, name in enumerate(tables):
        table = ".".join(tables[: depth + 1])
        here = _entry(here, name, table)
        if here is None:
            raise ValueError(f"{path}: the rig file has no table [{table}]; add it there, with all its keys")
        if not isinstance(here, BaseModel | Mapping):
            raise ValueError(f"{table} is no table, so {last} cannot be in it")
    value = _entry(here, last, path)
    field = type(here).model_fields[last] if isinstance(here, BaseModel) else None
    if field is None or isinstance(value, bool) or not isinstance(value, int | float):
        inside = f"; inside it are {', '.join(_names(value))}" if _names(value) else ""
        raise ValueError(f"{path} is not a number of the rig{inside}")
    return RigNumber(path, float(value), _quantity(field), isinstance(value, int), _checked_by(field))


def _quantity(field: FieldInfo) -> Quantity | None:
    """Its own, or that of a number that may be left out."""
    within = [entry for part in get_args(field.annotation) for entry in getattr(part, "__metadata__", ())]
    return next((entry for entry in (*field.metadata, *within) if isinstance(entry, Quantity)), None)


def _checked_by(field: FieldInfo) -> Callable[[Any], object]:
    kind: Any = Annotated[field.annotation, *field.metadata] if field.metadata else field.annotation
    adapter: TypeAdapter[Any] = TypeAdapter(kind)

    def check(value: Any) -> object:
        try:
            return adapter.validate_python(value)
        except ValidationError as error:
            first = error.errors()[0]
            raise ValueError(str(first.get("ctx", {}).get("error") or first["msg"])) from None

    return check


def _of_effect(rig: AnyRig, path: str, name: str, parameter: str) -> RigNumber:
    """Of one that the rig has, or of the catalogue: then it is absent as the rig stands."""
    own = {one.effect.name: one for one in resolved(rig.effects)}
    effect = own[name].effect if name in own else effect_called(name)
    if effect is None:
        raise ValueError(f"{path}: no such effect; {_instead(name, [*own, *catalogue()])}")
    parameters = {p.name: p for p in effect.parameters}
    if parameter not in parameters:
        raise ValueError(f"{path}: no such parameter; {_instead(parameter, parameters)}")
    p = parameters[parameter]
    value = own[name].values[parameter] if name in own else p.null
    quantity = Quantity(p.unit, f"{p.typical:g} {p.unit}") if p.unit else None
    return RigNumber(path, value, quantity, False, _within(p, quantity))


def _within(p: EffectParameter, quantity: Quantity | None) -> Callable[[Any], object]:
    def check(value: Any) -> object:
        number = quantity.to_si(value) if quantity else float(value)
        if not p.lower <= number <= p.upper:
            raise ValueError(f"out of range: allowed is {p.lower:g} to {p.upper:g} {p.unit}".rstrip())
        return number

    return check


def _of_calibration(rig: AnyRig, path: str, name: str) -> RigNumber:
    read_calibration({name: 1.0})  # raises for an unknown factor
    value = rig.calibration.factors.get(name, 1.0)
    return RigNumber(path, value, None, False, lambda factor: read_calibration({name: factor}))


def _entry(table: Any, name: str, path: str) -> Any:
    names = _names(table)
    if name not in names:
        raise ValueError(f"{path}: the rig file has no such key; {_instead(name, names)}")
    return table[name] if isinstance(table, Mapping) else getattr(table, name)


def _names(table: Any) -> list[str]:
    if isinstance(table, Mapping):
        return list(table)
    return list(type(table).model_fields) if isinstance(table, BaseModel) else []


def _instead(wrong: str, known: Any) -> str:
    close = get_close_matches(wrong, list(known), n=1)
    return f"did you mean {close[0]}?" if close else f"there are {', '.join(known)}"
