"""A rig file explained: its values in SI, and what follows from them."""

import math
from collections.abc import Iterator, Mapping
from typing import Any

from pydantic import BaseModel
from rich.box import SIMPLE_HEAD
from rich.table import Table

from updamp.rig.damper_mass import damper_mass
from updamp.rig.effects import Calibration, RigEffect
from updamp.rig.fields import Quantity
from updamp.rig.modal_rig import ModalRig
from updamp.rig.rig import Rig
from updamp.rig.size import size_of


def values_table(rig: Rig | ModalRig) -> Table:
    """Every key of the rig file with its value in SI."""
    table = Table(title=f"Rig {rig.name}", title_justify="left", header_style="bold")
    for heading, align in (("key", "left"), ("value", "right"), ("unit", "left")):
        table.add_column(heading, justify=align)  # type: ignore[arg-type]
    for key, value, unit in _entries(rig):
        table.add_row(key, value, unit)
    return table


def _entries(model: BaseModel, prefix: str = "") -> Iterator[tuple[str, str, str]]:
    for name, field in type(model).model_fields.items():
        value, key = getattr(model, name), f"{prefix}{name}"
        if isinstance(value, Calibration):
            yield from ((f"{key}.{entry}", _written(factor), "") for entry, factor in value.factors.items())
        elif isinstance(value, BaseModel):
            yield from _entries(value, f"{key}.")
        elif name == "effects":
            for effect in value:
                yield from _effect(effect)
        elif isinstance(value, Mapping):
            for entry, table in value.items():
                if isinstance(table, BaseModel):
                    yield from _table(table, f"{key}.{entry}")
        else:
            yield key, _written(value), _unit(field)


def _effect(effect: RigEffect) -> Iterator[tuple[str, str, str]]:
    for parameter, value in effect.values.items():
        yield f"effects.{effect.name}.{parameter}", _written(value), effect.units[parameter]


def _table(model: BaseModel, prefix: str) -> Iterator[tuple[str, str, str]]:
    """A mesh preset or a mode of the study: one line for those whose entries are all integers."""
    entries = list(_entries(model, f"{prefix}."))
    if all(isinstance(value, int) for value in model.__dict__.values()):
        yield prefix, ", ".join(f"{name} {value}" for name, value in model.__dict__.items()), ""
    else:
        yield from entries


def _unit(field: Any) -> str:
    """Of a quantity, or of the quantities in a tuple."""
    found = [entry.si for entry in field.metadata if isinstance(entry, Quantity)]
    return found[0] if found else _unit_within(field.annotation)


def _unit_within(annotation: Any) -> str:
    for entry in getattr(annotation, "__metadata__", ()):
        if isinstance(entry, Quantity):
            return entry.si
    for part in getattr(annotation, "__args__", ()):
        if unit := _unit_within(part):
            return unit
    return ""


def _written(value: Any) -> str:
    if value is None:
        return "not stated"
    if isinstance(value, float):
        return f"{value:.6g}"
    if isinstance(value, tuple):
        return ", ".join(_written(entry) for entry in value) if len(value) < 20 else f"{len(value)} entries"
    return str(value)


def sizes_table(rig: Rig, free: float) -> Table:
    """What each mesh preset takes. free: memory that there is [bytes]"""
    table = Table(title="What each mesh takes, about", title_justify="left", header_style="bold", box=SIMPLE_HEAD)
    for heading in ("mesh", "unknowns", "GB", "time", "contacts", "unknowns a curve", "GB a curve", ""):
        table.add_column(heading, justify="left" if heading in ("mesh", "") else "right")
    for name in rig.mesh:
        size = size_of(rig, name)
        memory, curve = size.elements_memory(), size.curve_memory()
        table.add_row(
            name,
            f"{size.unknowns:,}",
            f"{memory / 1e9:.2g}",
            _duration(size.elements_seconds()),
            f"{size.contacts}",
            f"{size.balance:,}",
            f"{curve / 1e9:.2g}",
            f"[red]more than the {free / 1e9:.3g} GB that are free[/]" if max(memory, curve) > free else "",
        )
    table.caption = "time: from mesh to reduced model on two processors; a curve takes seconds, with jumps minutes"
    return table


def _duration(seconds: float) -> str:
    return (
        f"{seconds:.0f} s"
        if seconds < 90
        else f"{seconds / 60:.0f} min"
        if seconds < 5400
        else f"{seconds / 3600:.3g} h"
    )


def derived_table(rig: Rig) -> Table:
    """Quantities that a designer looks at first."""
    table = Table(title="What follows", title_justify="left", show_header=False)
    for name, value in _derived(rig):
        table.add_row(name, value)
    return table


def _derived(rig: Rig) -> Iterator[tuple[str, str]]:
    def mm(length: float) -> str:
        return f"{1e3 * length:.3f} mm"

    angle, contact = rig.platform.underside_angle, rig.contact
    yield "length of the platform's underside", mm(rig.underside_length)
    yield "junction of underside and stem, height", mm(rig.junction_height)
    yield "damper's faces, upper end (half-width, height)", ", ".join(map(mm, rig.face_top))
    yield "damper's faces, lower end (half-width, height)", ", ".join(map(mm, rig.face_bottom))
    yield "damper's mass", f"{1e3 * damper_mass(rig):.2f} g"
    yield "area of one face", f"{1e6 * rig.face_area:.2f} mm^2"
    divisor = 2 * rig.face_area * (math.cos(angle) + contact.friction_coefficient * math.sin(angle))
    yield "uniform pressure, eq. (5) of Pesaresi et al. 2017", f"{rig.load.pull / divisor / 1e6:.4f} MPa"
    for name, stiffness in (("tangential", contact.tangential_stiffness), ("normal", contact.normal_stiffness)):
        yield f"{name} stiffness of one face", f"{stiffness * rig.face_area / 1e6:.1f} N/um"
    yield "response points, height", mm(rig.response_height)
    yield "pull over force", ", ".join(f"{rig.load.pull / force:.0f}" for force in rig.study.force_levels)
    for name, mesh in rig.mesh.items():
        yield f"contact elements of mesh '{name}'", f"{mesh.contact_elements}"
