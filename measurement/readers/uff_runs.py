"""Which records of a universal file are one sweep: those of a run, and of a repeat where there are repeats."""

from collections import Counter
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

from updamp.measurement.readers.uff_file import Record
from updamp.measurement.readers.uff_record import names_of, place, run_label


@dataclass(frozen=True, eq=False)
class Part:
    """Records of one sweep; repeat: None where the file has none; notes: what was taken for granted"""

    run: str
    repeat: int | None
    records: tuple[Record, ...]
    notes: tuple[str, ...] = ()


def parts_of(path: Path, records: Sequence[Record], labels: Sequence[str]) -> list[Part]:
    """Record 6 has "version number, or sequence number": it is that of a repeat where a channel occurs more than once
    without it, else it only counts the records."""
    runs: dict[str, list[Record]] = {}
    for record in records:
        runs.setdefault(run_label(record), []).append(record)
    return [part for run, mine in runs.items() for part in _parts(path, run, mine, labels)]


def _parts(path: Path, run: str, records: Sequence[Record], labels: Sequence[str]) -> list[Part]:
    versions: dict[int, list[Record]] = {}
    for record in records:
        versions.setdefault(int(record["ver_num"]), []).append(record)
    if len(versions) == 1:
        return [Part(run, number or None, tuple(mine)) for number, mine in versions.items()]
    numbers = ", ".join(map(str, versions))
    if max(Counter(key for record in records for key in _keys(record, labels)).values(), default=1) == 1:
        note = f"{path.name}: version numbers {numbers} of run '{run}' only count its records; no channel occurs twice"
        return [Part(run, None, tuple(records), (note,))]
    return [Part(run, n or None, tuple(mine), _lacking(path, n, mine, records, labels)) for n, mine in versions.items()]


def _keys(record: Record, labels: Sequence[str]) -> list[tuple[object, ...]]:
    """Of each wanted channel that it may be."""
    kind = record["func_type"], record["abscissa_spec_data_type"], place(record, "ref")
    step = record["z_axis_spec_data_type"], record["z_axis_value"]
    return [(label, kind, step) for label in labels if label in names_of(record)]


def _lacking(
    path: Path, number: int, mine: Sequence[Record], records: Sequence[Record], labels: Sequence[str]
) -> tuple[str, ...]:
    """Of channels that have other version numbers only."""
    present = {name for record in mine for name in names_of(record)}
    others = {
        label: [r["ver_num"] for r in records if label in names_of(r)] for label in labels if label not in present
    }
    return tuple(
        f"{path.name}: '{label}' has the version number {', '.join(map(str, theirs))}, not {number}: the version "
        f"number is that of the repeat, because channels of one run occur more than once"
        for label, theirs in others.items()
        if theirs
    )
