"""What a record of data set 58 says of itself: names, run, directions, units, and whether it can be used."""

import math
import re
from collections.abc import Sequence
from pathlib import Path

import numpy as np

from updamp.measurement.measurement import MeasurementError
from updamp.measurement.quantities import QUANTITIES as SI
from updamp.measurement.quantities import label_factor, spellings
from updamp.measurement.readers.uff_file import Record
from updamp.rig.fields import Quantity

QUANTITIES = {8: "displacement", 9: "force", 11: "velocity", 12: "acceleration", 13: "force"}
KNOWN_KINDS = (0, 8, 9, 11, 12, 13)
ORDER, FREQUENCY, TIME = 20, 18, 17
HERTZ, SECONDS = ("Hz", "kHz", "rad/s"), ("s", "ms")
RESPONSE_FUNCTION = 4
FUNCTIONS = {  # record 6, field 1
    1: "time response", 2: "auto spectrum", 3: "cross spectrum", 4: "frequency response function",
    5: "transmissibility", 6: "coherence", 9: "power spectral density", 12: "spectrum", 26: "multiple coherence",
}  # fmt: skip
# What data set 164 has for a metre and a newton (a value over it is in SI), in as few digits as programs write.
LENGTHS = {"m": 1.0, "mm": 1e3, "cm": 100.0, "ft": 3.28084, "in": 39.3701, "um": 1e6}
FORCES = {"N": 1.0, "mN": 1e3, "cN": 100.0, "kN": 1e-3, "lbf": 0.224809, "kgf": 0.101972, "pdl": 7.23301}
_AMPLITUDES_ALONE = '; write amplitudes alone as CSV, reader = "csv_columns", with phase = "none" for the channel'
Place = tuple[int, str]  # node (0 where none is stated) and direction
_DIRECTED = re.compile(r"(\d+)([+-][XYZ])")


def stated(text: object) -> str:
    """A field of text; "" where it is the format's word for nothing, NONE."""
    words = str(text).strip()
    return "" if words.upper() == "NONE" else words


def run_label(record: Record) -> str:
    return stated(record["id2"])


def names_of(record: Record) -> tuple[str, ...]:
    """What a channel's label may be: first line, entity name, node and direction."""
    names = stated(record["id1"]), stated(record["rsp_ent_name"]), f"{record['rsp_node']}{direction(record)}"
    return tuple(name for name in names if name)


def called(record: Record) -> str:
    """For people: its first line, or else as `_point`."""
    return stated(record["id1"]) or _point(record)


def _point(record: Record) -> str:
    """Node and direction; its entity's name where there is no node."""
    here = f"{record['rsp_node']}{direction(record)}"
    return here if record["rsp_node"] else stated(record["rsp_ent_name"]) or here


def called_apart(records: Sequence[Record]) -> tuple[str, ...]:
    """For people: each once, as `_point` where several points have the same first line."""
    points: dict[str, set[str]] = {}
    for record in records:
        points.setdefault(stated(record["id1"]), set()).add(_point(record))
    return tuple(dict.fromkeys(called(r) if len(points[stated(r["id1"])]) == 1 else _point(r) for r in records))


def direction(record: Record, end: str = "rsp") -> str:
    """Of the response, or of the reference (end = "ref"), such as "-X"; "" for a scalar or a rotation."""
    number = int(record[f"{end}_dir"])
    return ("+" if number > 0 else "-") + "XYZ"[abs(number) - 1] if 1 <= abs(number) <= 3 else ""


def place(record: Record, end: str = "rsp") -> Place:
    """Node (0 where none is stated) and direction of response or reference."""
    return int(record[f"{end}_node"]), direction(record, end)


def place_of_label(label: str) -> Place:
    """Of a label such as "12+X"; (0, "") for any other."""
    match = _DIRECTED.fullmatch(label)
    return (int(match[1]), match[2]) if match else (0, "")


def same_force(one: Place, other: Place) -> bool:
    """Whether node and axis agree as far as both state them."""
    return (one[0] == other[0] or not one[0] or not other[0]) and (
        one[1][1:] == other[1][1:] or not one[1] or not other[1]
    )


def is_ratio(record: Record) -> bool:
    """Whether it is a frequency response function: a response divided by a force."""
    return int(record["func_type"]) == RESPONSE_FUNCTION


def stated_unit(record: Record) -> str:
    """The label's, or else what data set 164 has for the quantity; "" where neither says anything."""
    return stated(record["ordinate_axis_units_lab"]) or _file_unit(record, int(record["ordinate_spec_data_type"]))


def _file_unit(record: Record, kind: int) -> str:
    quantity = QUANTITIES.get(kind)
    if record["file_units"] is None or quantity is None:
        return ""
    length, force = record["file_units"]
    known, factor = (FORCES, force) if quantity == "force" else (LENGTHS, length)
    unit = next((name for name, one in known.items() if math.isclose(one, factor, rel_tol=1e-4)), "")
    return unit + SI[quantity].si.removeprefix("m").removeprefix("N") if unit else ""


def units_of_ratio(path: Path, record: Record) -> tuple[str, str]:
    """Of a frequency response function's response and force: record 10's, or after the last "/" of record 9's.

    raises: MeasurementError where these two contradict each other
    """
    whole, below = stated_unit(record), stated(record["orddenom_axis_units_lab"])
    above, _, inside = whole.rpartition("/")
    if not above or not _is_force(inside.strip("() ")):
        return whole, below or _file_unit(record, int(record["orddenom_spec_data_type"]))
    inside = inside.strip("() ")
    if below and _is_force(below) and not math.isclose(label_factor(inside, "force"), label_factor(below, "force")):
        raise MeasurementError(
            f'{path}: record \'{called(record)}\' is in "{whole}" (record 9) but divided by "{below}" (record 10); '
            f"correct one of them"
        )
    return above.strip("() "), below or inside


def _is_force(unit: str) -> bool:
    try:
        return label_factor(unit, "force") > 0
    except ValueError:
        return False


def in_unit(path: Path, record: Record, axis: str, units: Sequence[str]) -> float:
    """Factor of the axis ("abscissa" or "z_axis") to the first of the units, by its label; 1 where it has none.

    raises: MeasurementError where the label is none of these units' kinds
    """
    label = stated(record["z_axis_axis_units_lab" if axis == "z_axis" else "abscissa_axis_units_lab"])
    for spelled in spellings(label) if label else ():
        for unit in units:
            try:
                factor = Quantity(unit, f"1 {unit}").to_si(f"1 {spelled}")
            except ValueError:
                continue
            return factor / (2 * np.pi) if unit == "rad/s" else factor
    if label:
        raise MeasurementError(
            f"{path}: record '{called(record)}': the unit of its {axis.replace('_', '-')}, \"{label}\", is not "
            f"understood; write {', '.join(units)} or NONE there"
        )
    return 1.0


def unusable(record: Record, as_force: bool) -> str:
    """Why the record is no amplitude over frequency, or not that of a force; "" where it is."""
    kind, abscissa, ordinate, below = (
        int(record[key])
        for key in ("func_type", "abscissa_spec_data_type", "ordinate_spec_data_type", "orddenom_spec_data_type")
    )
    if kind not in (0, 4, 12) or abscissa not in (0, FREQUENCY) or not np.iscomplexobj(record["data"]):
        return (
            f"is of function type {kind} ({FUNCTIONS.get(kind, 'another')}) with abscissa type {abscissa}"
            f"{'' if np.iscomplexobj(record['data']) else ' and real values'}; wanted are complex spectra (0 or 12) or "
            f"frequency response functions (4) over frequency (18): power spectra and coherences have no phase"
            f"{_AMPLITUDES_ALONE if kind in (0, 4, 12) and not np.iscomplexobj(record['data']) else ''}"
        )
    if as_force and is_ratio(record):
        return "is a frequency response function, divided by a force, and no force"
    if ordinate not in KNOWN_KINDS:
        return (
            f"holds data of type {ordinate} ({record['ordinate_axis_lab']}); wanted are displacement (8), velocity "
            f"(11), acceleration (12) or force (13)"
        )
    if is_ratio(record) and below not in (0, 9, 13):
        return f"is divided by data of type {below}, wanted is force (13)"
    return ""
