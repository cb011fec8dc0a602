"""Springs that depend on the displacement alone: first harmonics in closed form, corners between samples, tangents."""

import numpy as np
import pytest

from updamp.hbm.contact.springs import (
    CubicParameters,
    QuinticSpring,
    SquareSpring,
    UnilateralParameters,
    UnilateralSpring,
)
from updamp.hbm.contact.stops import Clearance, Stop
from updamp.hbm.harmonics import Harmonics
from updamp.hbm.problem.elements import ElementGroup, departures, element_forces, force_only

HARMONICS = Harmonics((0, 1, 2, 3))
W, GAP, STIFFNESS = 500.0, 1e-4, 2e3
ROW = np.array([[0]])


def with_gap(law: UnilateralSpring, stiffness: float = STIFFNESS) -> ElementGroup:
    return ElementGroup(law, UnilateralParameters(np.array([stiffness]), np.array([GAP])), ROW)


def square() -> ElementGroup:
    return ElementGroup(SquareSpring(), CubicParameters(np.array([5e8])), ROW)


def quintic() -> ElementGroup:
    return ElementGroup(QuinticSpring(), CubicParameters(np.array([3e18])), ROW)


def harmonic(amplitude: float) -> np.ndarray:
    x = np.zeros((1, 1, HARMONICS.n_coefficients))
    HARMONICS.set_amplitude(x[0], 1, np.array([amplitude]))
    return x


def first_harmonic(group: ElementGroup, amplitude: float) -> complex:
    return complex(HARMONICS.amplitude(force_only(group, harmonic(amplitude), W, HARMONICS, 128)[0], 1)[0])


def test_first_harmonics_of_powers() -> None:
    assert first_harmonic(square(), 1e-4) == pytest.approx(8 / (3 * np.pi) * 5e8 * 1e-8, rel=1e-4)
    assert first_harmonic(quintic(), 1e-4) == pytest.approx(5 / 8 * 3e18 * 1e-20, rel=1e-12)


@pytest.mark.parametrize("times", [1.02, 1.3, 2.0, 10.0])
def test_first_harmonic_beyond_a_gap(times: float) -> None:
    """To a ten-thousandth of what the spring would carry without a gap."""
    t = np.arccos(1 / times)
    expected = STIFFNESS * times * GAP * (t - np.sin(t) * np.cos(t)) / np.pi
    tolerance = 1e-4 * STIFFNESS * times * GAP
    assert first_harmonic(with_gap(Stop()), times * GAP) == pytest.approx(expected, abs=tolerance)
    assert first_harmonic(with_gap(Clearance()), times * GAP) == pytest.approx(2 * expected, abs=2 * tolerance)


def test_a_stop_has_a_mean_force_and_a_clearance_has_none() -> None:
    stop, both = (
        force_only(with_gap(law), harmonic(2 * GAP), W, HARMONICS, 128)[0, 0] for law in (Stop(), Clearance())
    )
    t = np.pi / 3  # cos t = gap / amplitude
    assert stop[0] == pytest.approx(STIFFNESS * 2 * GAP * (np.sin(t) - t * np.cos(t)) / np.pi, rel=1e-3)
    assert abs(both[0]) < 1e-12 * stop[0]


@pytest.mark.parametrize("law", [Stop(), Clearance()])
def test_nothing_short_of_the_gap_and_nothing_without_stiffness(law: UnilateralSpring) -> None:
    assert not force_only(with_gap(law), harmonic(0.99 * GAP), W, HARMONICS, 128).any()
    none = with_gap(law, 0.0)
    assert len(none.may_slip_or_separate(harmonic(2 * GAP), HARMONICS, 64)) == 0
    assert not departures(none, harmonic(2 * GAP), W, HARMONICS, 64).tangent.any()


@pytest.mark.parametrize("law", [Stop(), Clearance()])
def test_the_force_bends_with_the_amplitude_while_samples_pass_the_gap(law: UnilateralSpring) -> None:
    """Taken at the samples its slope jumps whenever one of them comes to lie beyond."""
    amplitudes, times = GAP * np.linspace(1.5, 1.6, 201), 2 if isinstance(law, Clearance) else 1
    t = np.arccos(GAP / amplitudes)
    expected = STIFFNESS * (t - np.sin(t) * np.cos(t)) / np.pi * amplitudes

    def off(group: ElementGroup, times: int) -> float:
        """Largest error of the slope [N/m]"""
        found = np.array([first_harmonic(group, a).real for a in amplitudes])
        return float(np.abs(np.gradient(found - times * expected, amplitudes)).max()) / times

    assert off(with_gap(law), times) < 0.02 * off(with_gap(UnilateralSpring()), 1)


@pytest.mark.parametrize(
    "group", [square(), quintic(), with_gap(Stop()), with_gap(Clearance()), with_gap(Clearance(), -500.0)]
)
def test_tangents_are_those_of_differences(group: ElementGroup) -> None:
    x = 2 * GAP * np.random.default_rng(1).normal(size=(1, 1, HARMONICS.n_coefficients))
    dx, h = 1e-9 * np.random.default_rng(2).normal(size=x.shape), 1e-3
    found = element_forces(group, x, W, HARMONICS, 128)
    ahead, behind = (force_only(group, x + s * h * dx, W, HARMONICS, 128) for s in (1, -1))
    expected = (ahead - behind) / (2 * h)
    np.testing.assert_allclose(
        np.einsum("eicjd,ejd->eic", found.tangent, dx), expected, atol=1e-5 * np.abs(expected).max()
    )
