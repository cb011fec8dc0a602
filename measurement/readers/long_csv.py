"""CSV in long form: one line an amplitude."""

import csv
from collections.abc import Iterable, Sequence
from pathlib import Path

import numpy as np

from updamp.measurement.measurement import MeasurementError
from updamp.measurement.readers.csv_form import CsvForm
from updamp.measurement.readers.gather import Samples, sweeps_from_samples
from updamp.measurement.readers.header import Wanted, header_of
from updamp.measurement.readers.registry import register
from updamp.measurement.readers.table import Codes, read_table
from updamp.measurement.readers.units_row import HERTZ, check_axis
from updamp.measurement.recorded import RecordedSweep, complex_of

COLUMNS = ("run", "repeat", "sweep", "frequency_Hz", "channel", "harmonic", "real", "imag")
OPTIONAL = ("repeat", "sweep", "harmonic")
REQUIRED = tuple(name for name in COLUMNS if name not in OPTIONAL)


@register("long_csv", endings=(".csv",), options=CsvForm)
def read_long_csv(path: Path, labels: tuple[str, ...], options: CsvForm) -> tuple[RecordedSweep, ...]:
    """Header `run,repeat,sweep,frequency_Hz,channel,harmonic,real,imag`, in any order; repeat, sweep and harmonic may
    be missing (harmonic 1 then). Lines above it are left out, and those that start with #, which are comments.
    options: its delimiter and decimal sign."""
    header = header_of(path, Wanted(REQUIRED), options)
    _check_header(path, header.names)
    numeric = [name for name in ("frequency_Hz", "harmonic", "real", "imag") if name in header.names]
    texts = [name for name in ("run", "repeat", "sweep", "channel") if name in header.names]
    table = read_table(path, header, numeric, texts, options)
    check_axis(path, table.units, "frequency_Hz", "Hz", HERTZ)
    n = len(table.numbers["real"])
    absent = Codes(np.zeros(n, np.int32), {"": 0})
    run, repeat, sweep = (table.texts.get(name, absent) for name in ("run", "repeat", "sweep"))
    values = table.numbers
    return sweeps_from_samples(
        path,
        Samples(
            run,
            repeat,
            sweep,
            table.texts["channel"],
            frequency=values["frequency_Hz"],
            harmonic=values.get("harmonic", np.ones(n)),
            amplitude=complex_of(values["real"], values["imag"]),
            labels=labels,
            notes=table.notes,
        ),
    )


def write_long_csv(path: Path, sweeps: Iterable[RecordedSweep]) -> None:
    """Numbers with all their digits, one line for each channel, frequency and harmonic.

    raises: ValueError where a channel is divided by force or carries noise, for which this form has no column
    """
    with path.open("w", encoding="utf-8", newline="") as file:
        writer = csv.writer(file, lineterminator="\n")
        writer.writerow(COLUMNS)
        for sweep in sweeps:
            repeat = "" if sweep.repeat is None else sweep.repeat
            for name, channel in sweep.channels.items():
                if channel.per_force or channel.noise is not None:
                    raise ValueError(f"{path}: channel '{name}' has noise or is divided by force; write HDF5 instead")
                for harmonic, values in zip(channel.harmonics, channel.amplitude.tolist(), strict=True):
                    for frequency, value in zip(sweep.frequency.tolist(), values, strict=True):
                        row = (sweep.run, repeat, sweep.sweep, frequency, name, harmonic, value.real, value.imag)
                        writer.writerow(row)


def _check_header(path: Path, header: tuple[str, ...]) -> None:
    missing = [name for name in REQUIRED if name not in header]
    unknown = [name for name in header if name and name not in COLUMNS]
    if missing or unknown:
        raise MeasurementError(
            f"{path}: header = {','.join(header)[:80]!r}: wanted is {','.join(COLUMNS)}"
            f"{_differing(missing, unknown)}; where each channel has "
            f'columns of its own, reader = "csv_columns"; for time signals reader = "time_csv"'
        )


def _differing(missing: Sequence[str], unknown: Sequence[str]) -> str:
    """In words, which columns are in the way, where most are there."""
    if len(missing) > len(COLUMNS) // 2:
        return ""
    lines = [f"there is no '{name}'" for name in missing] + [f"'{name[:40]}' is none of these" for name in unknown]
    return f" ({', '.join(lines)})"
