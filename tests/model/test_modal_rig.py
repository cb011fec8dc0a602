"""Rigs given by modes: what a rig file says is what the model's receptance shows, and what is wrong is named."""

import io
import re
from pathlib import Path

import numpy as np
import pytest
from rich.console import Console

from updamp.comparison.prediction.parameters import Parametrisation
from updamp.model.build import modal_model
from updamp.model.calibration import MODAL_MASS, MODAL_STIFFNESS, nuisances
from updamp.model.rig_files import is_modal, load_modal
from updamp.rig.errors import RigError
from updamp.rig.modal_tables import modes_table

RIGS = Path(__file__).parents[2] / "rigs"
TWO_MODES = """
kind = "modal"
name = "beam"
excitation = "beam.drive.x"

[modes.first]
frequency = "0.08 kHz"
loss_factor = 0.006
modal_mass = "500 g"
shape = { "beam.drive.x" = 2.0, "beam.end.x" = -1 }

[modes.second]
frequency = "150 Hz"
damping_ratio = 0.01
shape = { "beam.drive.x" = "0.7 kg^-0.5", "beam.middle.y" = "0.04 1/g^0.5" }
"""


@pytest.fixture
def write(tmp_path: Path):
    def to_file(text: str) -> Path:
        path = tmp_path / "rig.toml"
        path.write_text(text)
        return path

    return to_file


def test_only_files_that_say_so_are_modal(write):
    assert is_modal(RIGS / "brake_reuss.toml")
    assert not is_modal(RIGS / "pesaresi2017.toml")
    assert not is_modal(write("kind = "))
    assert not is_modal(RIGS / "missing.toml")


def test_receptance_is_that_of_the_modes(write):
    rig = load_modal(write(TWO_MODES))
    assert rig.points == ("beam.drive.x", "beam.end.x", "beam.middle.y")
    shapes = np.array([[2.0, -1.0, 0.0], [0.7, 0.0, 0.04 * np.sqrt(1000)]])
    model = modal_model(rig)
    for f in (60.0, 80.0, 149.0):
        w, w1, w2 = 2 * np.pi * f, 2 * np.pi * 80, 2 * np.pi * 150
        first = np.outer(shapes[0], shapes[0]) / 0.5 / (w1**2 * (1 + 0.006j) - w**2)
        second = np.outer(shapes[1], shapes[1]) / (w2**2 + 2j * 0.01 * w2 * w - w**2)
        np.testing.assert_allclose(model.components.receptance(w), first + second, rtol=1e-12)
    assert model.system.free.n_relative == 1
    np.testing.assert_allclose(model.system.stuck.frequencies, [80, 150])


def test_modal_mass_and_stiffness_are_known_only_roughly(write):
    base = modal_model(load_modal(write(TWO_MODES)))
    parametrisation = Parametrisation(base, nuisances(base))
    assert parametrisation.names[:3] == ("modal_stiffness", "loss_factor", "modal_mass")
    w = 2 * np.pi * 79.0
    heavier = MODAL_MASS.apply(base, 1.3)
    np.testing.assert_allclose(heavier.components.receptance(w), base.components.receptance(w) / 1.3)
    stiffer = MODAL_STIFFNESS.apply(base, 1.21)
    np.testing.assert_allclose(stiffer.system.stuck.frequencies, [88, 165])


@pytest.mark.parametrize(
    ("old", "new", "message"),
    [
        ('"500 g"', '"500 mm"', r'modes\.first\.modal_mass = "500 mm": wrong dimension'),
        ('"0.08 kHz"', "80", r'modes\.first\.frequency = 80: state its unit as text, such as "430 Hz"'),
        ("loss_factor = 0.006\n", "", r"modes\.first\.loss_factor, damping_ratio: neither is stated"),
        ("damping_ratio = 0.01", "damping_ratio = 0.01\nloss_factor = 0.02", r"modes\.second.*both are stated"),
        ("= 2.0", '= "2 kg^-0.5"', r"modes\.first\.shape.*with modal_mass the shape is a plain number"),
        ('"0.7 kg^-0.5"', "0.7", r"modes\.second\.shape.*state the unit as text.*or add modal_mass"),
        ('"0.7 kg^-0.5"', '"0.7 kg"', r"modes\.second\.shape.*wrong dimension"),
        ("= 2.0, ", "= nan, ", r"modes\.first\.shape.*plain number"),
        ('excitation = "beam.drive.x"', 'excitation = "beam.nose.x"', r"no mode has a shape there; points are beam"),
        ("[modes.first]", "[modes.first]\nloss_facto = 1", r"unknown key; did you mean loss_factor"),
        ('"beam.end.x"', '"beam.end"', r"modes\.first\.shape"),
    ],
)
def test_what_is_wrong_is_named(write, old, new, message):
    assert old in TWO_MODES
    with pytest.raises(RigError, match=message):
        load_modal(write(TWO_MODES.replace(old, new)))


def test_a_file_that_is_missing_or_no_toml_is_named(write, tmp_path):
    with pytest.raises(RigError, match="no such file"):
        load_modal(tmp_path / "none.toml")
    with pytest.raises(RigError, match="not valid TOML"):
        load_modal(write("kind = "))


def test_each_of_several_modes_is_off_by_itself(write):
    """What is known roughly of a mode identified in a test is its own: a rig of two has a factor for either, beside
    those that both share, and it leaves the other mode as it is."""
    model = modal_model(load_modal(write(TWO_MODES)))
    own = {n.name: n for n in nuisances(model)}
    assert list(own)[:3] == ["modal_stiffness", "loss_factor", "modal_mass"]
    changed = model
    for name, factor in (("second_modal_stiffness", 1.1), ("second_loss_factor", 1.2), ("second_modal_mass", 1.3)):
        changed = own[name].apply(changed, factor)
    before, after = model.components, changed.components
    np.testing.assert_allclose(after.omega_squared / before.omega_squared, [1.0, 1.1])
    np.testing.assert_allclose(np.diag(after.viscous)[1] / np.diag(before.viscous)[1], 1.2)
    np.testing.assert_allclose(np.diag(after.hysteretic)[0], np.diag(before.hysteretic)[0])
    moving = before.phi[:, 1] != 0
    np.testing.assert_allclose(after.phi[moving, 1] / before.phi[moving, 1], 1.3**-0.5)
    np.testing.assert_allclose(after.phi[:, 0], before.phi[:, 0])


def test_a_factor_of_one_mode_may_be_stated_and_of_a_mode_that_is_not_there_is_refused(write):
    stated = load_modal(write(TWO_MODES + "\n[calibration]\nsecond_loss_factor = 1.2\n"))
    np.testing.assert_allclose(np.diag(modal_model(stated).components.viscous)[1], 1.2 * 2 * 0.01 * 2 * np.pi * 150)
    with pytest.raises(RigError, match=r"calibration\.second_loss_factor = 99"):
        load_modal(write(TWO_MODES + "\n[calibration]\nsecond_loss_factor = 99\n"))
    other = load_modal(write(TWO_MODES + "\n[calibration]\nthird_loss_factor = 1.2\n"))
    with pytest.raises(ValueError, match=r"third_loss_factor: this model has no place for it; it has .*second"):
        modal_model(other)


def test_check_shows_each_mode_where_it_is_driven_and_where_it_moves(write):
    console = Console(width=200, file=io.StringIO())
    console.print(modes_table(load_modal(write(TWO_MODES))))
    rows = {cells[0].strip(): [c.strip() for c in cells[1:]] for line in console.file.getvalue().splitlines()
            if len(cells := [c for c in re.split("[│┃]", line) if c.strip()]) == 4}  # fmt: skip
    mass = 0.5 / 2**2
    assert rows["modal mass at beam.drive.x"] == [f"{mass:.4g}", f"{1 / 0.7**2:.4g}", "kg"]
    peak = 1 / (mass * (2 * np.pi * 80) ** 2 * 0.006)
    assert rows["peak receptance at beam.drive.x"][0] == f"{peak:.4g}"
    assert rows["loss factor at resonance"] == ["0.006", "0.02", "-"]
    assert rows["shape at beam.end.x"][1:] == ["0", "kg^-1/2"]


def test_what_a_table_of_harmonic_balance_leaves_out_is_as_without_one() -> None:
    usual = load_modal(RIGS / "brake_reuss.toml").harmonic_balance
    changed = load_modal(RIGS / "brake_reuss.toml", {"harmonic_balance.harmonics": [1, 3, 5]}).harmonic_balance
    assert (changed.harmonics, changed.time_samples, changed.cycles) == ((1, 3, 5), usual.time_samples, usual.cycles)
