"""What MATLAB users keep in their files: sizes and phases apart, arrays of structures, a force that is one number."""

import re
from pathlib import Path
from typing import Any

import h5py
import numpy as np
import pytest
import scipy.io

from updamp.measurement.measurement import MeasurementError
from updamp.measurement.readers.matlab import MatlabOptions, read_matlab
from updamp.measurement.recorded import Complex, RecordedSweep

FREQUENCY = np.linspace(70.0, 90.0, 21)
TIP = np.stack([1e-3 / (80.0**2 - FREQUENCY**2 + 4j * FREQUENCY), 1e-5 / (FREQUENCY + 3j)])
LABELS = ("force", "tip")


def written(folder: Path, version: str, content: dict[str, Any]) -> Path:
    path = folder / "a.mat"
    if version == "5":
        scipy.io.savemat(path, content)
        return path
    with h5py.File(path, "w", userblock_size=512) as file:
        for name, value in content.items():
            if isinstance(value, list):  # as MATLAB has an array of structures: references to what each field holds
                for field in value[0]:
                    each = [
                        file.create_dataset(f"#refs#/{i}{field}", data=_columns(v[field])) for i, v in enumerate(value)
                    ]
                    kept = np.array([[one.ref for one in each]], dtype=h5py.ref_dtype)
                    file.create_dataset(f"{name}/{field}", data=kept, dtype=h5py.ref_dtype)
            else:
                file[name] = _columns(value)
    return path


def _columns(value: Any) -> Any:
    return np.atleast_2d(np.asarray(value)).T


def content(**changed: Any) -> dict[str, Any]:
    plain = {"frequency": FREQUENCY, "force": np.full(21, 2.0), "tip": np.abs(TIP[0]), "angle": np.angle(TIP[0])}
    return {**plain, **changed}


def tip(sweeps: tuple[RecordedSweep, ...]) -> Complex:
    return sweeps[0].channels["tip"].amplitude


@pytest.mark.parametrize("version", ["5", "7.3"])
@pytest.mark.parametrize("unit", ["rad", "deg"])
def test_sizes_and_phases_in_variables_of_their_own(tmp_path: Path, version: str, unit: str) -> None:
    angle = np.angle(TIP[0]) * (180 / np.pi if unit == "deg" else 1)
    path = written(tmp_path, version, content(angle=angle, spare=1.0))
    sweeps = read_matlab(path, LABELS, MatlabOptions(phase={"tip": "angle"}, phase_unit=unit))
    np.testing.assert_allclose(tip(sweeps), TIP[:1], rtol=1e-12)
    assert sweeps[0].others == ("spare",)


def test_an_imaginary_part_of_its_own_at_two_harmonics(tmp_path: Path) -> None:
    path = written(tmp_path, "5", content(tip=TIP.real, tip_imag=TIP.imag))
    sweeps = read_matlab(path, LABELS, MatlabOptions(imaginary={"tip": "tip_imag"}, harmonics=(1, 3)))
    np.testing.assert_allclose(tip(sweeps), TIP, rtol=1e-12)
    # the force has no third
    assert sweeps[0].channels["force"].harmonics == (1,)
    np.testing.assert_array_equal(sweeps[0].channels["force"].amplitude, np.full((1, 21), 2.0))


@pytest.mark.parametrize("version", ["5", "7.3"])
def test_one_number_is_the_force_at_every_frequency(tmp_path: Path, version: str) -> None:
    path = written(tmp_path, version, content(force=2.5, tip=TIP[0].real))
    (sweep,) = read_matlab(path, LABELS, MatlabOptions(frequency_unit="Hz"))
    np.testing.assert_array_equal(sweep.channels["force"].amplitude, np.full((1, 21), 2.5))
    assert sweep.notes == ("a.mat: 'force' is one number, and taken as the force at each of the frequencies",)


def test_one_number_is_no_response(tmp_path: Path) -> None:
    path = written(tmp_path, "5", content(tip=2.5))
    with pytest.raises(MeasurementError, match=r"'tip' is 1 x 1, wanted is 1 x 21"):
        read_matlab(path, LABELS, MatlabOptions())


def test_a_matrix_of_channels_is_told_how_to_be_saved(tmp_path: Path) -> None:
    path = written(tmp_path, "5", content(tip=np.stack([TIP[0], TIP[1]]).T))
    with pytest.raises(
        MeasurementError, match=r"'tip' is 21 x 2.* save each as a variable, such as tip_1 = tip\(:, 1\)"
    ):
        read_matlab(path, LABELS, MatlabOptions())


@pytest.mark.parametrize("version", ["5", "7.3"])
def test_one_of_an_array_of_structures(tmp_path: Path, version: str) -> None:
    runs = [content(tip=k * np.abs(TIP[0])) for k in (1.0, 2.0, 3.0)]
    tests = (
        runs if version != "5" else np.array([tuple(r.values()) for r in runs], dtype=[(k, object) for k in runs[0]])
    )
    path = written(tmp_path, version, {"test": tests})
    for k in (1, 2, 3):
        name = f"test({k})."
        options = MatlabOptions(frequency=f"{name}frequency", phase={f"{name}tip": f"{name}angle"}, phase_unit="rad")
        (sweep,) = read_matlab(path, (f"{name}force", f"{name}tip"), options)
        np.testing.assert_allclose(sweep.channels[f"{name}tip"].amplitude, k * TIP[:1], rtol=1e-12)
        assert sweep.others == ()
    with pytest.raises(MeasurementError, match=re.escape("no variable 'test(4).frequency'")):
        read_matlab(path, LABELS, MatlabOptions(frequency="test(4).frequency"))


@pytest.mark.parametrize(
    ("changed", "options", "words"),
    [
        ({}, {"phase": {"tip": "angel"}}, "no variable 'angel'"),
        ({}, {"phase": {"tap": "angle"}}, 'no channel has the label "tap"'),
        ({}, {"phase": {"tip": "tip"}}, "is the variable of the amplitude itself; name that of its phase"),
        ({"tip": TIP[0]}, {"phase": {"tip": "angle"}}, "'tip' is complex and has a phase"),
        ({"angle": TIP[0]}, {"phase": {"tip": "angle"}}, "'angle' is complex"),
        (
            {"tip": -np.abs(TIP[0])},
            {"phase": {"tip": "angle"}},
            r"tip\(1\): tip = -.*: an amplitude with a phase",
        ),
        ({"force": np.full(21, -2.0)}, {"phase": {"tip": "angle"}}, r"force\(1\): force = -2"),
        ({"angle": np.arange(21) * 170.0 % 360}, {"phase": {"tip": "angle"}}, 'state phase_unit = "deg"'),
    ],
)
def test_what_cannot_be_meant(tmp_path: Path, changed: dict[str, Any], options: dict[str, Any], words: str) -> None:
    path = written(tmp_path, "5", content(**changed))
    with pytest.raises(MeasurementError, match=words):
        read_matlab(path, LABELS, MatlabOptions(phase_unit="rad", **options))


def test_one_phase_is_not_that_of_two_harmonics(tmp_path: Path) -> None:
    path = written(tmp_path, "5", content(tip=np.abs(TIP)))
    with pytest.raises(MeasurementError, match="'angle' has one harmonic where its amplitudes have 2"):
        read_matlab(path, LABELS, MatlabOptions(phase={"tip": "angle"}, phase_unit="deg", harmonics=(1, 3)))
