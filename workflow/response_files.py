"""Response curves for other programs: CSV for all of them, UFF58 for modal analysis, a MATLAB file."""

import csv
import re
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

import numpy as np
import scipy.io

from updamp.hbm.continuation.response_curve import ResponseCurve
from updamp.hbm.stability.branch_stability import BranchStability
from updamp.measurement.readers.uff import write_uff58
from updamp.measurement.recorded import RecordedChannel, RecordedSweep
from updamp.workflow.stability_summary import words

WRITTEN_POINTS = ("tip.", "corner_")  # what is written of a curve: the places the lasers look at
FORMATS = (".uff", ".mat")  # beside the CSV
Known = Mapping[float, BranchStability]


def write_responses(path: Path, curves: Sequence[ResponseCurve], stability: Known | None = None) -> None:
    """path: of the CSV, which the others are written beside; stability: by force, as far as it is known

    Points are in the order of the branch, whose frequency rises and falls where it folds.
    """
    ordered, known = sorted(curves, key=lambda curve: curve.force), stability or {}
    _write_csv(path, ordered, known)
    whole = path.with_suffix(".part.uff")
    write_uff58(whole, [_recorded(curve) for curve in ordered])
    whole.replace(path.with_suffix(".uff"))
    _write_matlab(path.with_suffix(".mat"), ordered, known)


def written_points(curve: ResponseCurve) -> tuple[str, ...]:
    return tuple(p for p in curve.points if any(part in p for part in WRITTEN_POINTS))


def _write_csv(path: Path, curves: Sequence[ResponseCurve], stability: Known) -> None:
    """Tidy, one line a point, place and harmonic; amplitudes X_k = Xc_k - i Xs_k in metres."""
    with path.open("w", newline="", encoding="utf-8") as file:
        lines = csv.writer(file)
        lines.writerow(["mode", "force_N", "frequency_Hz", "point", "harmonic", "real_m", "imag_m", "stability"])
        for curve in curves:
            frequency = [f"{f:.9g}" for f in curve.frequency]
            stable = words(curve, stability.get(curve.force))
            for point in written_points(curve):
                for k in curve.orders:
                    amplitude = curve.amplitude(point, k)
                    start = (curve.mode, f"{curve.force:.12g}")
                    lines.writerows(
                        (*start, f, point, k, f"{x.real:.9g}", f"{x.imag:.9g}", state)
                        for f, x, state in zip(frequency, amplitude, stable, strict=True)
                    )


def _recorded(curve: ResponseCurve) -> RecordedSweep:
    """As a measured sweep would be written: spectra of the displacements [m] and of the force [N]"""
    force = np.full((1, len(curve)), complex(curve.force))
    channels = {"force": RecordedChannel(force, per_force=False, unit="N", quantity="force")}
    for point in written_points(curve):
        x = _amplitudes(curve, point)
        channels[point] = RecordedChannel(x, curve.orders, per_force=False, unit="m", quantity="displacement")
    return RecordedSweep(f"{curve.mode} {curve.force:.12g} N", None, "", curve.frequency, channels)


def _amplitudes(curve: ResponseCurve, point: str) -> np.ndarray[Any, np.dtype[np.complex128]]:
    """(n_harmonics, n) [m]"""
    return np.array([curve.amplitude(point, k) for k in curve.orders], dtype=np.complex128)


def _write_matlab(path: Path, curves: Sequence[ResponseCurve], stability: Known) -> None:
    """A structure for each curve, such as OOP_3_84N: its numbers, and for each point, such as blade_right_tip_x, the
    complex amplitudes (n_harmonics, n) [m]."""
    content: dict[str, dict[str, Any]] = {}
    for curve in curves:
        entry: dict[str, Any] = {
            "mode": curve.mode,
            "force": curve.force,
            "frequency": curve.frequency,
            "harmonics": np.array(curve.orders, dtype=float),
            "stability": np.array(words(curve, stability.get(curve.force)), dtype=object),
            "complete": curve.complete,
        }
        entry |= {matlab_name(point): _amplitudes(curve, point) for point in written_points(curve)}
        content[matlab_name(f"{curve.mode}_{curve.force:.12g}N")] = entry
    whole = path.with_suffix(".part.mat")
    scipy.io.savemat(str(whole), content, long_field_names=True, do_compression=True)
    whole.replace(path)


def matlab_name(text: str) -> str:
    """Letters, digits and underscores, as MATLAB wants its names"""
    return re.sub(r"\W", "_", text)
