"""Response curves as other programs read them: the same numbers in CSV, UFF58 and MATLAB."""

import csv
from pathlib import Path

import numpy as np
import pytest
import scipy.io
from support.curves import softening_curve

from updamp.measurement.readers.matlab import MatlabOptions, read_matlab
from updamp.measurement.readers.registry import NoOptions
from updamp.measurement.readers.uff import read_uff
from updamp.workflow.response_files import write_responses

POINT = "blade_right.tip.x"


@pytest.fixture(scope="module")
def written(tmp_path_factory: pytest.TempPathFactory) -> Path:
    path = tmp_path_factory.mktemp("responses") / "frf_IP.csv"
    write_responses(path, [softening_curve(force=force, softening=4.0, n=41) for force in (3.84, 0.5)])
    assert {one.name for one in path.parent.iterdir()} == {"frf_IP.csv", "frf_IP.uff", "frf_IP.mat"}
    return path


@pytest.mark.parametrize(("number", "force"), [(0, 0.5), (1, 3.84)])
def test_uff58_holds_every_curve_as_a_run_in_the_order_of_the_branch(written: Path, number: int, force: float) -> None:
    curve = softening_curve(force=force, softening=4.0, n=41)
    sweep = read_uff(written.with_suffix(".uff"), ("force", POINT, "damper.corner_left.y"), NoOptions())[number]
    assert sweep.run == f"IP {force:g} N"
    np.testing.assert_allclose(sweep.frequency, curve.frequency, rtol=1e-12)
    assert sweep.channels["force"].amplitude == pytest.approx(np.full((1, 41), force))
    found = sweep.channels[POINT]
    assert (found.harmonics, found.unit, found.quantity) == (curve.orders, "m", "displacement")
    for k, amplitude in zip(found.harmonics, found.amplitude, strict=True):
        np.testing.assert_allclose(amplitude, curve.amplitude(POINT, k), rtol=1e-12)


def test_matlab_has_a_structure_for_each_curve(written: Path) -> None:
    curve = softening_curve(force=3.84, softening=4.0, n=41)
    options = MatlabOptions(frequency="IP_3_84N.frequency", harmonics=curve.orders)
    (sweep,) = read_matlab(written.with_suffix(".mat"), ("IP_3_84N.blade_right_tip_x",), options)
    np.testing.assert_allclose(sweep.frequency, curve.frequency, rtol=1e-12)
    np.testing.assert_allclose(
        sweep.channels["IP_3_84N.blade_right_tip_x"].amplitude[1], curve.amplitude(POINT), rtol=1e-12
    )
    plain = scipy.io.loadmat(written.with_suffix(".mat"), squeeze_me=True)["IP_0_5N"]
    assert (str(plain["mode"]), float(plain["force"])) == ("IP", 0.5)
    assert len(plain["stability"].item()) == 41


def test_csv_has_the_same_numbers(written: Path) -> None:
    with written.open(encoding="utf-8") as file:
        lines = [one for one in csv.DictReader(file) if one["point"] == POINT and one["harmonic"] == "1"]
    curve = softening_curve(force=0.5, softening=4.0, n=41)
    assert [one["force_N"] for one in lines] == ["0.5"] * 41 + ["3.84"] * 41
    found = [complex(float(one["real_m"]), float(one["imag_m"])) for one in lines[:41]]
    np.testing.assert_allclose(found, curve.amplitude(POINT), rtol=1e-8)


def test_forces_that_differ_by_little_are_two_curves(tmp_path: Path) -> None:
    forces = (3.84, 3.840001)
    write_responses(tmp_path / "frf_IP.csv", [softening_curve(force=force, n=41) for force in forces])
    plain = scipy.io.loadmat(tmp_path / "frf_IP.mat", squeeze_me=True)
    assert {float(plain[name]["force"]) for name in ("IP_3_84N", "IP_3_840001N")} == set(forces)
    with (tmp_path / "frf_IP.csv").open(encoding="utf-8") as file:
        assert {float(one["force_N"]) for one in csv.DictReader(file)} == set(forces)
