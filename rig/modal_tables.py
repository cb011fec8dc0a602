"""A rig given by modes explained: what an oscillator of each mode is at the point of excitation, and where it moves."""

import math
from collections.abc import Iterator

from rich.table import Table

from updamp.rig.modal_rig import ModalRig, Mode


def modes_table(rig: ModalRig) -> Table:
    """A column for each mode."""
    table = Table(title="What follows", title_justify="left", header_style="bold")
    table.add_column("")
    for name in rig.modes:
        table.add_column(name, justify="right")
    table.add_column("unit")
    columns = [dict(_of_mode(mode, rig)) for mode in rig.modes.values()]
    for key in columns[0]:
        name, unit = key
        table.add_row(name, *(f"{column[key]:.4g}" for column in columns), unit)
    return table


def _of_mode(mode: Mode, rig: ModalRig) -> Iterator[tuple[tuple[str, str], float]]:
    """By name and unit; infinite where the mode does not move where it is excited, or has no loss."""
    w, shape = 2 * math.pi * mode.frequency, mode.normalised
    loss = mode.loss_factor if mode.loss_factor is not None else 2 * (mode.damping_ratio or 0.0)
    driven = shape.get(rig.excitation, 0.0)
    mass = 1 / driven**2 if driven else math.inf
    yield ("loss factor at resonance", "-"), loss
    yield ("half-power width", "Hz"), loss * mode.frequency
    yield (f"modal mass at {rig.excitation}", "kg"), mass
    yield (f"modal stiffness at {rig.excitation}", "N/m"), mass * w**2
    yield (f"peak receptance at {rig.excitation}", "m/N"), 1 / (mass * w**2 * loss) if loss else math.inf
    for point in rig.points:
        yield (f"shape at {point}", "kg^-1/2"), shape.get(point, 0.0)
