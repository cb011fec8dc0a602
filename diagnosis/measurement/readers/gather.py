"""From amplitudes one by one to sweeps: grouped by run, repeat and direction, ordered as they were met."""

from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from updamp.diagnosis.measurement.measurement_errors import MeasurementError
from updamp.diagnosis.measurement.recorded import Floats, RecordedChannel, RecordedSweep


@dataclass(frozen=True, eq=False)
class Samples:
    """n amplitudes of whatever channel.

    run, repeat, sweep, channel: what their codes stand for
    codes: (4, n) of run, repeat, sweep and channel
    values: (4, n) frequency [Hz], harmonic, real, imaginary
    labels: channels wanted
    """

    run: Mapping[int, str]
    repeat: Mapping[int, str]
    sweep: Mapping[int, str]
    channel: Mapping[int, str]
    codes: NDArray[np.int32]
    values: Floats
    labels: tuple[str, ...]


def sweeps_from_samples(path: Path, samples: Samples) -> tuple[RecordedSweep, ...]:
    """raises: MeasurementError where channels of a sweep do not share their frequencies, or harmonics are no numbers"""
    harmonic = samples.values[1]
    if not np.all((harmonic >= 0) & (harmonic == np.floor(harmonic)) & (harmonic < 1e4)):
        bad = harmonic[~((harmonic >= 0) & (harmonic == np.floor(harmonic)) & (harmonic < 1e4))][0]
        raise MeasurementError(f"{path}: harmonic = {bad:g}: wanted is a whole number, 1 for that of the excitation")
    run, repeat, sweep, _ = (samples.codes[i].astype(np.int64) for i in range(4))
    key = (run * (repeat.max() + 1) + repeat) * (sweep.max() + 1) + sweep
    return tuple(_sweep(path, samples, rows) for rows in _groups(key))


def _groups(key: NDArray[np.int64]) -> list[NDArray[np.intp]]:
    """Rows of each value of the key, in the order of the first row."""
    order = np.argsort(key, kind="stable")
    groups = np.split(order, np.flatnonzero(np.diff(key[order])) + 1)
    return sorted(groups, key=lambda rows: int(rows[0]))


def _sweep(path: Path, samples: Samples, rows: NDArray[np.intp]) -> RecordedSweep:
    run, repeat, sweep, _ = samples.codes[:, rows[0]].tolist()
    name = samples.run[run]
    channels: dict[str, RecordedChannel] = {}
    others: list[str] = []
    frequency: Floats | None = None
    for group in _groups(samples.codes[3, rows].astype(np.int64)):
        label = samples.channel[int(samples.codes[3, rows[group[0]]])]
        if label not in samples.labels:
            others.append(label)
            continue
        harmonics: dict[int, NDArray[np.complex128]] = {}
        for part in _groups(samples.values[1, rows[group]].astype(np.int64)):
            f, k, real, imag = samples.values[:, rows[group[part]]]
            frequency = f if frequency is None else frequency
            _check_common(path, f"run '{name}' channel '{label}' harmonic {k[0]:g}", frequency, f)
            harmonics[int(k[0])] = real + 1j * imag
        ordered = tuple(sorted(harmonics))
        channels[label] = RecordedChannel(np.array([harmonics[k] for k in ordered]), ordered)
    frequency = np.zeros(0) if frequency is None else frequency
    direction = _direction(path, name, samples.sweep[sweep])
    number = repeat_number(path, name, samples.repeat[repeat])
    return RecordedSweep(name, number, direction, frequency, channels, tuple(others))


def _check_common(path: Path, what: str, wanted: Floats, found: Floats) -> None:
    if len(wanted) != len(found):
        raise MeasurementError(
            f"{path}: {what} has {len(found)} frequencies, the channels before it {len(wanted)}; every "
            f"channel and harmonic of a sweep needs the same ones (a sweep made twice under one repeat number looks like "
            f"this too)"
        )
    differing = ~np.isclose(wanted, found, rtol=1e-9, atol=0, equal_nan=True)
    if differing.any():
        i = int(np.argmax(differing))
        raise MeasurementError(
            f"{path}: {what}: frequency {found[i]:g} Hz where the channels before it have {wanted[i]:g} Hz; every "
            f"channel of a sweep needs the same frequencies in the same order"
        )


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


def _direction(path: Path, run: str, text: str) -> str:
    word = text.strip().lower()
    if word not in ("", "up", "down"):
        raise MeasurementError(f"{path}: run '{run}': sweep = \"{text}\": allowed are up and down")
    return word
