"""From amplitudes one by one to sweeps: grouped by run, repeat and direction, ordered as they were met."""

from dataclasses import dataclass
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from updamp.measurement.measurement import MeasurementError
from updamp.measurement.readers.table import Codes
from updamp.measurement.recorded import Complex, Floats, RecordedChannel, RecordedSweep


@dataclass(frozen=True, eq=False)
class Samples:
    """n amplitudes of whatever channel, run, repeat and sweep. labels: channels wanted; frequency: (n,) [Hz]; notes: on
    the file, for each of its sweeps"""

    run: Codes
    repeat: Codes
    sweep: Codes
    channel: Codes
    frequency: Floats
    harmonic: Floats
    amplitude: Complex
    labels: tuple[str, ...]
    notes: tuple[str, ...] = ()


def sweeps_from_samples(path: Path, samples: Samples) -> tuple[RecordedSweep, ...]:
    """raises: MeasurementError where channels of a sweep do not share their frequencies, or harmonics are no numbers"""
    harmonic = samples.harmonic
    good = (harmonic >= 0) & (harmonic == np.floor(harmonic)) & (harmonic < 1e4)
    if not good.all():
        bad = harmonic[~good][0]
        raise MeasurementError(f"{path}: harmonic = {bad:g}: wanted is a whole number, 1 for that of the excitation")
    return tuple(_sweep(path, samples, rows) for rows in group_rows(samples.run, samples.repeat, samples.sweep))


def group_rows(*columns: Codes) -> list[NDArray[np.intp]]:
    """Rows that have the same texts in all the columns, in the order of their first row."""
    key = np.zeros(len(columns[0].codes), np.int64)
    for column in columns:
        key = key * max(len(column.number), 1) + column.codes
    return _groups(key)


def _groups(key: NDArray[np.int64]) -> list[NDArray[np.intp]]:
    order = np.argsort(key, kind="stable")
    groups = np.split(order, np.flatnonzero(np.diff(key[order])) + 1)
    return sorted(groups, key=lambda rows: int(rows[0]))


def _sweep(path: Path, samples: Samples, rows: NDArray[np.intp]) -> RecordedSweep:
    run = text_of(samples.run, rows)
    channels: dict[str, RecordedChannel] = {}
    others: list[str] = []
    frequency: Floats | None = None
    for group in _groups(samples.channel.codes[rows].astype(np.int64)):
        label = text_of(samples.channel, rows[group])
        if label not in samples.labels:
            others.append(label)
            continue
        harmonics: dict[int, Complex] = {}
        for part in _groups(samples.harmonic[rows[group]].astype(np.int64)):
            mine = rows[group[part]]
            f, k = samples.frequency[mine], int(samples.harmonic[mine[0]])
            frequency = f if frequency is None else frequency
            _check_common(path, f"run '{run}' channel '{label}' harmonic {k}", frequency, f)
            harmonics[k] = samples.amplitude[mine]
        ordered = tuple(sorted(harmonics))
        channels[label] = RecordedChannel(np.array([harmonics[k] for k in ordered]), ordered)
    return RecordedSweep(
        run=run,
        repeat=repeat_number(path, run, text_of(samples.repeat, rows)),
        sweep=sweep_direction(path, run, text_of(samples.sweep, rows)),
        frequency=np.zeros(0) if frequency is None else frequency,
        channels=channels,
        others=tuple(others),
        notes=samples.notes,
    )


def _check_common(path: Path, what: str, wanted: Floats, found: Floats) -> None:
    if len(wanted) != len(found):
        raise MeasurementError(
            f"{path}: {what} has {len(found)} frequencies, the channels before it {len(wanted)}; every channel and "
            f"harmonic of a sweep needs the same ones (a sweep made twice under one repeat number looks like this too)"
        )
    differing = ~np.isclose(wanted, found, rtol=1e-9, atol=0, equal_nan=True)
    if differing.any():
        i = int(np.argmax(differing))
        raise MeasurementError(
            f"{path}: {what}: frequency {found[i]:g} Hz where the channels before it have {wanted[i]:g} Hz; every "
            f"channel of a sweep needs the same frequencies in the same order"
        )


def text_of(column: Codes, rows: NDArray[np.intp]) -> str:
    """That of the first row."""
    return column.label[int(column.codes[rows[0]])].strip()


def repeat_number(path: Path, run: str, text: str) -> int | None:
    """raises: MeasurementError where it is no whole number"""
    if not text.strip():
        return None
    try:
        return int(text)
    except ValueError:
        raise MeasurementError(
            f"{path}: run '{run}': repeat = \"{text}\": wanted is a whole number, that of the assembly"
        ) from None


def sweep_direction(path: Path, run: str, text: str) -> str:
    """raises: MeasurementError where it is neither up nor down nor empty"""
    word = text.strip().lower()
    if word not in ("", "up", "down"):
        raise MeasurementError(f"{path}: run '{run}': sweep = \"{text}\": allowed are up and down")
    return word
