"""Repeats that are none: one number twice, or the very values of another run."""

from collections.abc import Sequence

import numpy as np

from updamp.measurement.measurement import MeasuredRun, MeasurementError


def check_numbers(where: str, runs: Sequence[MeasuredRun]) -> None:
    """raises: MeasurementError where two runs of one name have one repeat number"""
    listed: set[tuple[str, int]] = set()
    for run in runs:
        if (key := (run.name, run.repeat)) in listed:
            raise MeasurementError(
                f"{where}: run '{run.name}' has repeat = {run.repeat} more than once; number its repeats by "
                f"assemblies, or take out the one that is listed twice"
            )
        listed.add(key)


def copies(where: str, runs: Sequence[MeasuredRun]) -> list[str]:
    """In sentences, which runs have the very values of one before: measured twice, they would differ by their noise."""
    first: dict[tuple[bytes, ...], MeasuredRun] = {}
    notes = []
    for run in runs:
        order = np.argsort(run.frequency)
        values = run.frequency[order], run.force[order], run.response[..., order]
        other = first.setdefault(tuple(part.tobytes() for part in values), run)
        if other is not run:
            notes.append(
                f"{where}: {_called(run)} has the very values of {_called(other)}: is it a copy? Then take it out: "
                f"it is no repeat, and no test of another level or direction"
            )
    return notes


def _called(run: MeasuredRun) -> str:
    return f"run '{run.name}' repeat {run.repeat}"
