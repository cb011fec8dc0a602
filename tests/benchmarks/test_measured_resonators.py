"""The laboratory of measured resonators against closed forms."""

from functools import partial
from pathlib import Path

import numpy as np
import pytest

from updamp.benchmarks.measured_resonators.laws import (
    clearance,
    coulomb,
    cubic,
    microslip,
    quadratic_damping,
    quintic,
    saturating,
    square,
    threshold,
)
from updamp.benchmarks.measured_resonators.measured import Fault, measure
from updamp.benchmarks.measured_resonators.resonator import Resonator
from updamp.benchmarks.measured_resonators.run import cases
from updamp.effects.catalogue import OWN
from updamp.measurement.load import load_measurement
from updamp.model.rig_files import load_modal

A, W = np.array([1e-5, 4e-5]), 500.0


def test_masings_loop_of_a_uniform_distribution_has_its_closed_form() -> None:
    """chi = 0: backbone -r x^2 / 2, so a loop of area 2/3 r a^3 and a stiffness less by r a / 2 in the first harmonic
    (C A with C = r / 2)."""
    found = microslip(3e9, 0.0, A, W)
    np.testing.assert_allclose(np.pi * A**2 * found.imag, 2 / 3 * 3e9 * A**3, rtol=1e-4)
    np.testing.assert_allclose(found.real, -3e9 * A / 2, rtol=1e-4)


def test_a_threshold_of_nothing_is_a_dashpot_and_one_that_is_not_reached_nothing() -> None:
    np.testing.assert_allclose(threshold(2.0, 0.0, A, W), 2j * W, rtol=1e-12)
    assert not threshold(2.0, 5e-5, A, W).any()


def test_springs_are_what_their_forces_first_harmonics_are() -> None:
    phase = 2 * np.pi * np.arange(20000) / 20000
    x = A[:, None] * np.cos(phase)
    forces = {
        partial(quintic, 3e18): 3e18 * x**5,
        partial(square, 5e8): 5e8 * np.abs(x) * x,
        partial(saturating, 2e3, 2e-5): 2e3 * (2e-5 * np.tanh(x / 2e-5) - x),
        partial(clearance, 2e3, 2e-5): 2e3 * (x - np.clip(x, -2e-5, 2e-5)),
    }
    for law, force in forces.items():
        np.testing.assert_allclose(law(A, W), 2 * np.mean(force * np.cos(phase), axis=1) / A, rtol=1e-6)


def test_what_is_lost_a_cycle_is_what_each_law_takes() -> None:
    """pi a^2 Im k: 4 F a of Coulomb's friction, 8/3 c w^2 a^3 of the square law, nothing of a spring."""
    np.testing.assert_allclose(np.pi * A**2 * coulomb(0.2, A, W).imag, 4 * 0.2 * A)
    np.testing.assert_allclose(np.pi * A**2 * quadratic_damping(5.0, A, W).imag, 8 / 3 * 5.0 * W**2 * A**3)
    assert not cubic(1e12, A, W).imag.any()


def test_without_laws_a_sweep_is_that_of_the_linear_resonator() -> None:
    found = Resonator(2.0, 80.0, 0.005, ())
    f = np.linspace(78, 82, 31)
    w, w0 = 2 * np.pi * f, 2 * np.pi * 80.0
    np.testing.assert_allclose(found.sweep(f, 0.3), 1 / (2.0 * (w0**2 * (1 + 0.005j) - w**2)), rtol=1e-9)
    assert found.peak(0.3) == pytest.approx(80.0, rel=1e-6)


def test_a_hardening_spring_jumps_down_upwards_and_up_downwards() -> None:
    """Both sweeps balance the force everywhere, to a quarter of the least noise that is drawn; the upward one goes on
    to the resonance on the backbone."""
    linear = Resonator(2.0, 80.0, 0.005, ())
    force, k3 = 0.3, 6 * linear.stiffness * 0.005 / (0.75 * (0.3 / (linear.stiffness * 0.005)) ** 2)
    hard = Resonator(2.0, 80.0, 0.005, (lambda a, w: cubic(k3, a, w),))
    f = np.linspace(79.5, 82.5, 121)
    up, down = hard.sweep(f, force), hard.sweep(f[::-1], force)[::-1]
    for h in (up, down):
        w = 2 * np.pi * f
        left = [hard.resisting(np.array([abs(x) * force]), v)[0] * x - 1 for x, v in zip(h, w, strict=True)]
        assert np.abs(left).max() < 1e-3
    assert f[np.argmax(np.abs(up))] == pytest.approx(hard.peak(force), abs=0.1)
    assert f[np.argmax(np.abs(down))] < f[np.argmax(np.abs(up))] - 0.4


def test_faults_are_read_as_the_catalogues_are() -> None:
    h = np.array([1.0 - 1j, 2.0, 1j])
    found = Fault(lag=0.2, background=0.1 + 0.05j, trend=0.3).read(h)
    np.testing.assert_allclose(found, (h * np.exp(-0.2j) + 0.1 + 0.05j) * np.exp([0, 0.15, 0.3]))


def test_its_files_are_read_and_the_same_seed_makes_the_same(tmp_path: Path) -> None:
    for place in ("one", "two"):
        measure(7, ("cubic", "phase"), tmp_path / place)
    for name in ("rig.toml", "measurement.toml", "data.csv"):
        assert (tmp_path / "one" / name).read_bytes() == (tmp_path / "two" / name).read_bytes()
    load_modal(tmp_path / "one" / "rig.toml")
    assert len(load_measurement(tmp_path / "one" / "measurement.toml").runs) >= 2


def test_what_is_hidden_has_its_name_in_the_catalogue() -> None:
    for case in cases(1, Path("x")):
        assert all(name in OWN for name in case.expected if name)
