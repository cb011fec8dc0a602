"""Universal file format: data sets 58 (text) and 58b (binary) with amplitudes over frequency, through pyuff.

A record belongs to the channel whose label is its first identification line, its entity name, or node and direction
as in "12+X". The second line is the run, as the format's note 3 has it; a z-axis of the kind "order" (20) is the
harmonic, which is 1 elsewhere; the version number is the repeat where it is not 0.
"""

import mmap
import re
import warnings
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

import numpy as np
import pyuff

from updamp.measurement.measurement import MeasurementError
from updamp.measurement.readers.registry import NoOptions, register, usable_file
from updamp.measurement.recorded import RecordedChannel, RecordedSweep

LARGEST = 2.5e8  # bytes: pyuff keeps every number as a Python object, 2.1 GB of memory at 240 MB
QUANTITIES = {8: "displacement", 9: "force", 11: "velocity", 12: "acceleration", 13: "force"}
KNOWN_KINDS = (0, 8, 9, 11, 12, 13)
ORDER, FREQUENCY, TIME = 20, 18, 17
_DELIMITER = re.compile(rb" {4}-1(?= *[\r\n]| *\Z)")

Record = Mapping[str, Any]


@register("uff", endings=(".uff", ".unv", ".uf", ".uff58"))
def read_uff(path: Path, labels: tuple[str, ...], options: NoOptions) -> tuple[RecordedSweep, ...]:  # noqa: ARG001
    """Spectra (function types 0 and 12) and frequency response functions (type 4)."""
    records = uff_records(path)
    if all(record["abscissa_spec_data_type"] == TIME for record in records):
        raise MeasurementError(f'{path}: holds time signals; read them with reader = "uff_time"')
    sweeps: dict[tuple[str, int], list[Record]] = {}
    for record in records:
        sweeps.setdefault((run_label(record), int(record["ver_num"])), []).append(record)
    return tuple(_sweep(path, run, number, part, labels) for (run, number), part in sweeps.items())


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


def uff_records(path: Path) -> tuple[Record, ...]:
    """Every data set 58 of the file, whole.

    raises: MeasurementError where the file is cut off, is something else, or has no data set 58
    """
    usable_file(path, LARGEST)
    with path.open("rb") as file, mmap.mmap(file.fileno(), 0, access=mmap.ACCESS_READ) as content:
        delimiters = sum(1 for _ in _DELIMITER.finditer(content))
    if delimiters == 0:
        raise MeasurementError(f"{path}: no data set in it (no line '    -1'); this is no universal file")
    if delimiters % 2:
        raise MeasurementError(f"{path}: cut off: its last data set has no end; copy or export the file again")
    try:
        file_58 = pyuff.UFF(str(path))
        kinds = np.asarray(file_58.get_set_types())
        found = file_58.read_sets(np.flatnonzero(kinds == 58).tolist()) if (kinds == 58).any() else []
    except Exception as error:  # pyuff wraps whatever it stumbles over in a bare Exception
        raise MeasurementError(f"{path}: cannot be read as a universal file ({error}); export it again") from None
    if not (kinds == 58).any():
        raise MeasurementError(f"{path}: no data set 58 in it, only {', '.join(map(str, kinds))}; export functions")
    records = tuple(found) if isinstance(found, list) else (found,)
    for record in records:
        _check_whole(path, record)
    return records


def _check_whole(path: Path, record: Record) -> None:
    wanted, found = int(record["num_pts"]), min(len(record["x"]), len(record["data"]))
    if found != wanted or wanted == 0:
        raise MeasurementError(
            f"{path}: record '{record['id1']}' has {found} values where its header says {wanted}; the file is cut "
            f"off or damaged, copy or export it again"
        )


def run_label(record: Record) -> str:
    text = str(record["id2"]).strip()
    return "" if text == "NONE" else text


def names_of(record: Record) -> tuple[str, ...]:
    """What a channel's label may be: first line, entity name, node and direction."""
    return str(record["id1"]).strip(), str(record["rsp_ent_name"]).strip(), f"{record['rsp_node']}{direction(record)}"


def direction(record: Record) -> str:
    number = int(record["rsp_dir"])
    return ("+" if number > 0 else "-") + "XYZ"[abs(number) - 1] if 1 <= abs(number) <= 3 else ""


def _sweep(path: Path, run: str, number: int, records: Sequence[Record], labels: tuple[str, ...]) -> RecordedSweep:
    channels: dict[str, RecordedChannel] = {}
    used: set[int] = set()
    for label in labels:
        mine = [record for record in records if label in names_of(record)]
        used |= {id(record) for record in mine}
        if mine:
            channels[label] = _channel(path, label, mine)
    frequency = _frequency(path, [record for record in records if id(record) in used])
    others = tuple(dict.fromkeys(names_of(record)[0] for record in records if id(record) not in used))
    rounded = any(not record["binary"] and record["abscissa_spacing"] == 0 for record in records)
    note = f"{path.name}: frequencies are known to six digits only, all that the text form of a universal file holds"
    return RecordedSweep(run, number or None, "", frequency, channels, others, (note,) if rounded else ())


def _channel(path: Path, label: str, records: Sequence[Record]) -> RecordedChannel:
    harmonics: dict[int, Record] = {}
    for record in records:
        harmonic = round(record["z_axis_value"]) if record["z_axis_spec_data_type"] == ORDER else 1
        if harmonic in harmonics:
            raise MeasurementError(
                f"{path}: more than one record of '{label}', harmonic {harmonic}, in run '{run_label(record)}'; tell "
                f'them apart by the second identification line (run) or by node and direction, such as label = "12+X"'
            )
        harmonics[harmonic] = record
        _check_kind(path, label, record)
    ordered = tuple(sorted(harmonics))
    first = harmonics[ordered[0]]
    return RecordedChannel(
        amplitude=np.array([harmonics[k]["data"] for k in ordered], dtype=complex),
        harmonics=ordered,
        per_force=int(first["func_type"]) == 4,
        unit=stated_unit(first),
        quantity=QUANTITIES.get(int(first["ordinate_spec_data_type"]), ""),
        direction=direction(first),
    )


def _check_kind(path: Path, label: str, record: Record) -> None:
    kind, abscissa, ordinate = (
        int(record[key]) for key in ("func_type", "abscissa_spec_data_type", "ordinate_spec_data_type")
    )
    if kind not in (0, 4, 12) or abscissa not in (0, FREQUENCY) or not np.iscomplexobj(record["data"]):
        raise MeasurementError(
            f"{path}: record '{label}' is of function type {kind} with abscissa type {abscissa}"
            f"{'' if np.iscomplexobj(record['data']) else ' and real values'}; wanted are complex spectra (0 or 12) or "
            f"frequency response functions (4) over frequency (18): power spectra have no phase"
        )
    if ordinate not in KNOWN_KINDS:
        raise MeasurementError(
            f"{path}: record '{label}' holds data of type {ordinate} ({record['ordinate_axis_lab']}); wanted are "
            f"displacement (8), velocity (11), acceleration (12) or force (13)"
        )
    denominator = int(record["orddenom_spec_data_type"])
    if kind == 4 and denominator not in (0, 9, 13):
        raise MeasurementError(
            f"{path}: record '{label}' is divided by data of type {denominator}, wanted is force (13)"
        )


def stated_unit(record: Record) -> str:
    text = str(record["ordinate_axis_units_lab"]).strip()
    return "" if text.upper() == "NONE" else text


def _frequency(path: Path, records: Sequence[Record]) -> np.ndarray[Any, np.dtype[np.float64]]:
    if not records:
        return np.zeros(0)
    first = np.asarray(records[0]["x"], dtype=float)
    for record in records[1:]:
        if len(record["x"]) != len(first) or not np.allclose(record["x"], first, rtol=1e-9, atol=0):
            raise MeasurementError(
                f"{path}: records '{records[0]['id1']}' and '{record['id1']}' of run '{run_label(record)}' have other "
                f"frequencies; every channel of a sweep needs the same ones"
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
        "z_axis_spec_data_type": ORDER, "z_axis_value": float(harmonic),
        "abscissa_spacing": 0, "data": values, "x": sweep.frequency,
    }  # fmt: skip
