"""Random damage to sound files: each is read, or refused in words of the project; no traceback, no hang.

What is accepted was not damaged: the same values are read, or such as the file now states within its bounds.
"""

import math
from collections.abc import Callable
from functools import partial
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st
from support.broken.measurements import POINTS, WRITERS
from support.broken.rig_files import MODAL, REFERENCE
from support.measured_oscillator import TOML, recorded
from support.one_sweep import sweep_of_beam

from updamp.measurement.load import load_measurement
from updamp.measurement.measurement import Measurement, MeasurementError
from updamp.model.rig_files import load_any
from updamp.rig.errors import RigError
from updamp.rig.rig import Rig
from updamp.workflow.limits import check_size

# The same cases every time: a test that fails today and not tomorrow tells nothing.
QUICK = settings(
    max_examples=60, deadline=5000, derandomize=True, database=None,
    suppress_health_check=[HealthCheck.function_scoped_fixture, HealthCheck.too_slow],
)  # fmt: skip

ODD = (
    "",
    "\x00",
    "\ufeff",
    "é",
    "=",
    '"',
    "'",
    ",",
    ";",
    "[",
    "]",
    "#",
    "\n",
    "nan",
    "inf",
    "-",
    "1e999",
    "0",
    " ",
    "μ",
)


@st.composite
def damaged(draw: Callable, content: bytes) -> bytes:
    """One to three injuries: bytes turned, taken out, doubled, put in, or the rest cut off."""
    for _ in range(draw(st.integers(1, 3))):
        start = draw(st.integers(0, max(len(content) - 1, 0)))
        length = draw(st.integers(0, 40))
        part = content[start : start + length]
        new = draw(
            st.one_of(
                st.just(b""),
                st.just(part * 2),
                st.binary(max_size=8),
                st.sampled_from(ODD).map(str.encode),
                st.just(part[::-1]),
            )
        )
        rest = b"" if draw(st.integers(0, 9)) == 0 else content[start + length :]
        content = content[:start] + new + rest
    return content


@st.composite
def restated(draw: Callable, text: str) -> str:
    """A value replaced by another: any number, any unit, any kind."""
    lines = text.splitlines()
    stated = [i for i, line in enumerate(lines) if "=" in line and not line.startswith("#")]
    place = draw(st.sampled_from(stated))
    number = draw(st.one_of(st.integers(-(10**20), 10**20), st.floats(), st.integers(-3, 200)))
    unit = draw(st.sampled_from(["mm", "m", "N", "Hz", "kHz", "GPa", "MPa", "deg", "kg", "N/m", "furlong", "", "%"]))
    value = draw(
        st.sampled_from(
            [f'"{number} {unit}"', f"{number}", "true", "[]", "{}", '""', f"[{number}, {number}]", "1979-05-27"]
        )
    )
    lines[place] = f"{lines[place].split('=')[0]}= {value}"
    return "\n".join(lines)


def sound_rig(path: Path) -> None:
    """Read, every number of it finite, and its size known; or refused with the file named."""
    rig, refusal = attempt(lambda: load_any(path), RigError)
    assert refusal is None or refusal.startswith(str(path))
    if rig is None:
        return
    assert all(math.isfinite(value) for value in numbers(rig.model_dump(mode="python")))
    if isinstance(rig, Rig):
        assert 1e-6 <= rig.blade.thickness < rig.blade.axis_offset * 2
        for preset in rig.mesh:
            _, refusal = attempt(partial(check_size, rig, preset, memory=8e9), ValueError)
            assert refusal is None or preset in refusal or "reduction" in refusal


def attempt(work: Callable[[], Any], expected: type[Exception]) -> tuple[Any, str | None]:
    """What it gives, or the words of its refusal; any other error comes through."""
    try:
        return work(), None
    except expected as error:
        return None, str(error)


def numbers(value: object) -> list[float]:
    if isinstance(value, dict):
        return [n for entry in value.values() for n in numbers(entry)]
    if isinstance(value, (list, tuple)):
        return [n for entry in value for n in numbers(entry)]
    return [float(value)] if isinstance(value, (int, float)) else []


def sound_measurement(path: Path) -> Measurement | None:
    """Read, all of it finite, and held to its level; or refused with a file named."""
    found, refusal = attempt(lambda: load_measurement(path, POINTS, rig="oscillator"), MeasurementError)
    assert refusal is None or str(path.parent) in refusal
    if found is None:
        return None
    for run in found.runs:
        assert np.isfinite(run.response).all()
        assert np.isfinite(run.force).all()
        assert (np.diff(run.frequency) != 0).all()
    return found


@pytest.mark.parametrize("text", [REFERENCE, MODAL], ids=["geometry", "modal"])
def test_bytes_of_a_rig_file(tmp_path: Path, text: str) -> None:
    path = tmp_path / "rig.toml"

    @QUICK
    @given(damaged(text.encode()))
    def try_it(content: bytes) -> None:
        path.write_bytes(content)
        sound_rig(path)

    try_it()


@pytest.mark.parametrize("text", [REFERENCE, MODAL], ids=["geometry", "modal"])
def test_values_of_a_rig_file(tmp_path: Path, text: str) -> None:
    path = tmp_path / "rig.toml"

    @QUICK
    @given(restated(text))
    def try_it(content: str) -> None:
        path.write_text(content, encoding="utf-8")
        sound_rig(path)

    try_it()


@pytest.mark.parametrize("strategy", [damaged, restated], ids=["bytes", "values"])
def test_a_measurement_file(tmp_path: Path, strategy: Callable) -> None:
    WRITERS[".csv"](tmp_path / "data.csv", [recorded()])
    path = tmp_path / "measurement.toml"

    @QUICK
    @given(strategy(TOML.encode() if strategy is damaged else TOML))
    def try_it(content: bytes | str) -> None:
        path.write_bytes(content if isinstance(content, bytes) else content.encode())
        sound_measurement(path)

    try_it()


@pytest.mark.parametrize("ending", [".csv", ".uff", ".h5"])
def test_a_data_file(tmp_path: Path, ending: str) -> None:
    """Binary forms have checksums or headers; of text a digit may be another one, and nobody can know. MATLAB's is left
    out: scipy's reader can end the process that reads a damaged one.
    """
    data = tmp_path / f"data{ending}"
    WRITERS[ending](data, [recorded()])
    sound, path = data.read_bytes(), tmp_path / "measurement.toml"
    path.write_text(TOML.replace("data.csv", data.name), encoding="utf-8")

    @QUICK
    @given(damaged(sound))
    def try_it(content: bytes) -> None:
        data.write_bytes(content)
        sound_measurement(path)

    try_it()


def test_what_the_damage_is_done_to_is_sound(tmp_path: Path) -> None:
    """Or nothing above would tell anything."""
    for ending, write in WRITERS.items():
        write(tmp_path / f"data{ending}", [recorded()])
        path = tmp_path / "measurement.toml"
        path.write_text(TOML.replace("data.csv", f"data{ending}"), encoding="utf-8")
        assert sound_measurement(path) is not None
    assert load_any(Path(__file__).parents[2] / "rigs" / "pesaresi2017.toml")
    assert sweep_of_beam(tmp_path).is_file()
