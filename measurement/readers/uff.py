"""Universal file format: data sets 58 (text) and 58b (binary) with amplitudes over frequency, through pyuff.

A record belongs to the channel whose label is its first identification line, its entity name, or node and direction
as in "12+X". The second line is the run, as the format's note 3 has it; a z-axis of the kind "order" (20) is the
harmonic, which is 1 elsewhere; what the version number means is in `uff_runs.py`.
"""

import warnings
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
import pyuff

from updamp.measurement.measurement import MeasurementError
from updamp.measurement.per_force import FrequencyResponse
from updamp.measurement.readers.registry import NoOptions, register
from updamp.measurement.readers.uff_file import Record, uff_records
from updamp.measurement.readers.uff_record import (
    FREQUENCY,
    HERTZ,
    ORDER,
    QUANTITIES,
    TIME,
    Place,
    called,
    called_apart,
    direction,
    in_unit,
    is_ratio,
    names_of,
    place,
    place_of_label,
    run_label,
    same_force,
    stated,
    stated_unit,
    units_of_ratio,
    unusable,
)
from updamp.measurement.readers.uff_runs import Part, parts_of
from updamp.measurement.recorded import Floats, RecordedChannel, RecordedSweep


@register("uff", endings=(".uff", ".unv", ".uf", ".uff58"))
def read_uff(path: Path, labels: tuple[str, ...], options: NoOptions) -> tuple[RecordedSweep, ...]:  # noqa: ARG001
    """Spectra (function types 0 and 12) and frequency response functions (type 4)."""
    records = uff_records(path)
    if all(record["abscissa_spec_data_type"] == TIME for record in records):
        raise MeasurementError(f'{path}: holds time signals; read them with reader = "uff_time"')
    return tuple(_sweep(path, part, labels) for part in parts_of(path, records, labels))


def write_uff58(path: Path, sweeps: Sequence[RecordedSweep], binary: bool = True) -> None:
    """binary: 58b, with all digits; the text form has six digits of frequency and twelve of the amplitude.

    raises: ValueError where a value is not finite (pyuff would write 0), a channel carries noise, for which the format
        has no place, or a label is longer than the format's 80 characters
    """
    path.unlink(missing_ok=True)  # pyuff's own "overwrite" loses the header of binary records
    file = pyuff.UFF(str(path))
    for sweep in sweeps:
        for node, (name, channel) in enumerate(sweep.channels.items(), 1):
            if channel.noise is not None:
                raise ValueError(f"{path}: channel '{name}' carries noise, which this format cannot hold; write HDF5")
            for harmonic, values in zip(channel.harmonics, channel.amplitude, strict=True):
                start = path.stat().st_size if path.exists() else 0
                with warnings.catch_warnings():
                    warnings.simplefilter("ignore", ResourceWarning)  # pyuff leaves a handle to the garbage collector
                    file.write_sets([_record(path, sweep, name, node, channel, harmonic, values, binary)], mode="add")
                if binary:
                    _correct_byte_count(path, start, len(values))


def _correct_byte_count(path: Path, start: int, n: int) -> None:
    """pyuff states 8 bytes a value where frequency, real and imaginary part take 24; other readers trust the header."""
    with path.open("r+b") as file:
        file.seek(start + len("    -1\n    58b") + 6 + 6 + 12)
        file.write(b"%12d" % (24 * n))


@dataclass(frozen=True, eq=False)
class _Chosen:
    """Records of a label that can be used, and in sentences why others cannot."""

    records: tuple[Record, ...]
    notes: tuple[str, ...]


def _sweep(path: Path, part: Part, labels: tuple[str, ...]) -> RecordedSweep:
    usable = {label: _usable(path, part, label, label == labels[0]) for label in labels}
    driven, rivals = _driven(usable, labels[0])
    chosen = {
        label: one if label == labels[0] else _of_force(path, label, one, driven, rivals)
        for label, one in usable.items()
    }
    channels = {label: _channel(path, label, one.records) for label, one in chosen.items() if one.records}
    used = [record for one in chosen.values() for record in one.records]
    others = called_apart([r for r in part.records if not set(labels) & set(names_of(r))])
    notes = [*part.notes, *(note for one in chosen.values() for note in one.notes)]
    notes += [note for label, one in chosen.items() for note in _file_unit_notes(path, label, one.records)]
    if any(record["abscissa_spacing"] == 1 or not record["binary"] for record in used):
        notes.append(
            f"{path.name}: frequencies are known to six digits only, all that even spacing or the text form of a "
            f"universal file holds; export binary (58b) with uneven spacing, or CSV, where a narrow resonance matters"
        )
    return RecordedSweep(part.run, part.repeat, "", _frequency(path, used), channels, others, tuple(notes))


def _usable(path: Path, part: Part, label: str, as_force: bool) -> _Chosen:
    mine = [record for record in part.records if label in names_of(record)]
    reasons = [unusable(record, as_force) for record in mine]
    notes = [f"{path.name}: a record '{label}' is not used: it {reason}" for reason in dict.fromkeys(reasons) if reason]
    return _Chosen(tuple(r for r, reason in zip(mine, reasons, strict=True) if not reason), tuple(notes))


def _driven(usable: Mapping[str, _Chosen], force: str) -> tuple[Place, tuple[str, ...]]:
    """Node and direction of the force, by its record or else by its label; and the forces that functions are divided
    by, where it could be more than one of them."""
    records = usable[force].records
    known = place(records[0]) if records else place_of_label(force)
    references = [place(r, "ref") for one in usable.values() for r in one.records if is_ratio(r)]
    could_be = {
        (node, toward[1:]): f"{node}{toward}" for node, toward in references if same_force((node, toward), known)
    }
    return known, tuple(could_be.values()) if len(could_be) > 1 else ()


def _of_force(path: Path, label: str, chosen: _Chosen, driven: Place, rivals: tuple[str, ...]) -> _Chosen:
    """Without the frequency response functions that are divided by another force, or by nobody knows which."""
    out = [r for r in chosen.records if is_ratio(r) and (rivals or not same_force(place(r, "ref"), driven))]
    if not out:
        return chosen
    there, at = ", ".join(dict.fromkeys("{}{}".format(*place(r, "ref")) for r in out)), "{}{}".format(*driven)
    if rivals:
        reason = (
            f"the file has functions divided by the forces at {' and '.join(rivals)}; say which is meant by the label "
            f'of the force, such as label = "{rivals[0]}"'
        )
    elif len(out) == len(chosen.records):
        reason = f"the force is at {at}; name the force at {there}, or take functions whose reference is {at}"
    else:
        reason = f"the force is at {at}"
    note = (
        f"{path.name}: records '{label}' divided by the force at {there} (reference, record 6) are not used: {reason}"
    )
    left_out = {id(record) for record in out}
    return _Chosen(tuple(r for r in chosen.records if id(r) not in left_out), (*chosen.notes, note))


def _file_unit_notes(path: Path, label: str, records: Sequence[Record]) -> list[str]:
    units = dict.fromkeys(stated_unit(r) for r in records if not stated(r["ordinate_axis_units_lab"]))
    return [f"{path.name}: '{label}' has no unit label; data set 164 says {unit}" for unit in units if unit]


def _channel(path: Path, label: str, records: Sequence[Record]) -> RecordedChannel:
    harmonics: dict[int, Record] = {}
    for record in records:
        harmonic = round(record["z_axis_value"]) if record["z_axis_spec_data_type"] == ORDER else 1
        if harmonic in harmonics:
            raise MeasurementError(
                f"{path}: more than one record of '{label}', harmonic {harmonic}, in run '{run_label(record)}'; "
                f"{_advice(record, harmonics[harmonic])}"
            )
        harmonics[harmonic] = record
    ordered = tuple(sorted(harmonics))
    first = harmonics[ordered[0]]
    amplitude = np.array([harmonics[k]["data"] for k in ordered], dtype=complex)
    quantity, toward = QUANTITIES.get(int(first["ordinate_spec_data_type"]), ""), direction(first)
    if not is_ratio(first):
        unit = stated_unit(first)
        return RecordedChannel(amplitude, ordered, None, False, unit, quantity, toward)
    unit, force_unit = units_of_ratio(path, first)
    return FrequencyResponse(
        amplitude,
        ordered,
        unit=unit,
        quantity=quantity,
        direction=toward,
        force_unit=force_unit,
        reference=direction(first, "ref"),
    )


def _advice(one: Record, other: Record) -> str:
    if is_ratio(one) != is_ratio(other):
        return "one is a spectrum, one a frequency response function: export either of them"
    return 'tell them apart by the second identification line (run) or by node and direction, such as label = "12+X"'


def _frequency(path: Path, records: Sequence[Record]) -> Floats:
    if not records:
        return np.zeros(0)
    first, *others = (np.asarray(r["x"], dtype=float) * in_unit(path, r, "abscissa", HERTZ) for r in records)
    for record, other in zip(records[1:], others, strict=True):
        if len(other) != len(first) or not np.allclose(other, first, rtol=1e-9, atol=0):
            raise MeasurementError(
                f"{path}: records '{called(records[0])}' and '{called(record)}' of run '{run_label(record)}' have "
                f"other frequencies; every channel of a sweep needs the same ones"
                f"{'' if run_label(record) else ' (give each run its own second identification line)'}"
            )
    return first


def _record(
    path: Path,
    sweep: RecordedSweep,
    name: str,
    node: int,
    channel: RecordedChannel,
    harmonic: int,
    values: np.ndarray[Any, np.dtype[np.complex128]],
    binary: bool,
) -> dict[str, Any]:
    if not (np.isfinite(values).all() and np.isfinite(sweep.frequency).all()):
        raise ValueError(f"{path}: channel '{name}' of run '{sweep.run}' has values that are not finite")
    if max(len(name), len(sweep.run)) > 80:
        raise ValueError(f"{path}: '{name}' or '{sweep.run}' is longer than 80 characters")
    axis = "XYZ".find(channel.direction[1:]) + 1 if channel.direction else 0
    kind = next((code for code, quantity in reversed(QUANTITIES.items()) if quantity == channel.quantity), 0)
    return {
        "type": 58, "binary": int(binary), "func_type": 4 if channel.per_force else 0,
        "id1": name, "id2": sweep.run or "NONE", "ver_num": sweep.repeat or 0,
        "rsp_node": node, "rsp_dir": -axis if channel.direction.startswith("-") else axis,
        "ref_node": 0, "ref_dir": 0,
        "abscissa_spec_data_type": FREQUENCY, "abscissa_axis_lab": "Frequency", "abscissa_axis_units_lab": "Hz",
        "ordinate_spec_data_type": kind, "ordinate_axis_units_lab": channel.unit or "NONE",
        "orddenom_spec_data_type": 13 if channel.per_force else 0,
        "orddenom_axis_units_lab": (channel.force_unit if isinstance(channel, FrequencyResponse) else "") or "NONE",
        "z_axis_spec_data_type": ORDER, "z_axis_value": float(harmonic),
        "abscissa_spacing": 0, "data": values, "x": sweep.frequency,
    }  # fmt: skip
