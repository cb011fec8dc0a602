"""The laboratory's files: CSV in long form, UFF58, measurement.toml, and the sealed truth."""

import csv
import json
import warnings
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

import pyuff
import tomlkit

from updamp.benchmarks.virtual_rig.plan import TestPlan
from updamp.benchmarks.virtual_rig.sensors import Recorded
from updamp.rig.rig import Rig

COLUMNS = ("run", "repeat", "sweep", "frequency_Hz", "channel", "harmonic", "real", "imag")
CSV, UFF, DESCRIPTION, SEALED = "sweeps.csv", "sweeps.uff", "measurement.toml", "sealed.json"


def write_csv(path: Path, sweeps: Sequence[Recorded], harmonics: Sequence[int]) -> None:
    with path.open("w", encoding="utf-8", newline="") as file:
        writer = csv.writer(file, lineterminator="\n")
        writer.writerow(COLUMNS)
        for s in sweeps:
            label = (s.run.name, s.repeat, "up" if s.run.upwards else "down")
            amplitudes = {("force", 1): s.force}
            amplitudes |= {(name, k): values[i] for name, values in s.response.items() for i, k in enumerate(harmonics)}
            for (channel, k), values in amplitudes.items():
                for f, value in zip(s.frequency.tolist(), values.tolist(), strict=True):
                    writer.writerow((*label, repr(f), channel, k, f"{value.real:.9e}", f"{value.imag:.9e}"))


def write_uff(path: Path, sweeps: Sequence[Recorded], harmonics: Sequence[int]) -> None:
    """Data sets 58b: channel and run in the identification lines, repeat as the version, harmonic as the order."""
    path.unlink(missing_ok=True)
    file = pyuff.UFF(str(path))
    for s in sweeps:
        amplitudes = [("force", 1, 13, "N", s.force)]
        amplitudes += [(c, k, 8, "m", v[i]) for c, v in s.response.items() for i, k in enumerate(harmonics)]
        for node, (channel, k, kind, unit, values) in enumerate(amplitudes, 1):
            record = {
                "type": 58, "binary": 1, "func_type": 0, "id1": channel, "id2": s.run.name, "ver_num": s.repeat,
                "rsp_node": node, "rsp_dir": 1, "ref_node": 0, "ref_dir": 0,
                "abscissa_spec_data_type": 18, "abscissa_axis_lab": "Frequency", "abscissa_axis_units_lab": "Hz",
                "ordinate_spec_data_type": kind, "ordinate_axis_units_lab": unit, "orddenom_spec_data_type": 0,
                "z_axis_spec_data_type": 20, "z_axis_value": float(k),
                "abscissa_spacing": 0, "data": values, "x": s.frequency,
            }  # fmt: skip
            with warnings.catch_warnings():  # pyuff leaves its files to the garbage collector
                warnings.simplefilter("ignore", ResourceWarning)
                file.write_sets([record], mode="add")


def write_description(path: Path, rig: Rig, plan: TestPlan, data: str) -> None:
    """measurement.toml: what an engineer would write, and nothing of what is hidden."""
    excitation = f"blade_{rig.excitation.blade}.excitation.x"
    channels = {"force": _channel("force", excitation, "N")}
    channels |= {name: _channel("displacement", point, "m") for name, point in plan.channels.items()}
    runs = [
        {
            "name": run.name, "mode": run.mode, "file": data, "held": "force", "level": f"{run.force:g} N",
            "sweep": "up" if run.upwards else "down", "taken": number,
        }
        for number, run in enumerate(plan.runs, 1)
    ]  # fmt: skip
    table = {
        "title": f"Virtual laboratory: {rig.name}, {plan.assemblies} assemblies",
        "rig": rig.name,
        "damper_load": f"{rig.load.pull:g} N",
        "excitation": excitation,
        "time_convention": "exp(+iwt)",
        "channels": channels,
        "runs": runs,
    }
    path.write_text(tomlkit.dumps(table), encoding="utf-8")


def _channel(quantity: str, point: str, unit: str) -> dict[str, str]:
    place, _, axis = point.rpartition(".")
    return {"quantity": quantity, "point": place, "direction": axis, "unit": unit, "amplitude": "peak"}


def write_sealed(path: Path, truth: Mapping[str, Any]) -> None:
    path.write_text(json.dumps(truth, indent=1) + "\n", encoding="utf-8")
