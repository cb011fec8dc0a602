"""Resonances of a response curve by phase: of a linear structure, and coexisting ones beyond a fold."""

from dataclasses import replace

import numpy as np
import pytest
from scipy.optimize import brentq
from support.peers import one_degree_of_freedom, solved

from updamp.hbm.contact.springs import CubicParameters, CubicSpring
from updamp.hbm.continuation.curve import CurveRequest, trace
from updamp.hbm.problem.elements import ElementGroup
from updamp.hbm.problem.system import Excitation
from updamp.hbm.resonance.quadrature import quadrature_resonances

WINDOW = (0.5 / 2 / np.pi, 2.0 / 2 / np.pi)


@pytest.fixture(scope="module")
def duffing():
    d = solved("a_duffing_1dof")["definition"]
    group = ElementGroup(CubicSpring(), CubicParameters(np.array([d["g"]])), np.array([[0]]))
    system = one_degree_of_freedom(d["c"], group, tuple(range(8)), 128)
    *_, curve = trace(system, CurveRequest("1", Excitation(system.free.row("mass"), d["P"]), WINDOW, ("mass",)))
    return curve


def with_response(curve, frequency, receptance):
    """The curve with another frequency axis and first harmonic."""
    response = np.zeros((len(frequency), 1, curve.response.shape[2]))
    harmonics = curve.harmonics
    for i, value in enumerate(receptance):
        harmonics.set_amplitude(response[i], 1, np.array([curve.force * value]))
    return replace(curve, frequency=frequency, response=response, after_gap=np.zeros(len(frequency), dtype=bool))


def test_the_one_of_a_hardening_oscillator_is_near_its_peak(duffing):
    (found,) = quadrature_resonances(duffing, "mass")
    frequency, peak = duffing.peak("mass")
    assert found.frequency == pytest.approx(frequency, rel=2e-3)
    assert found.receptance == pytest.approx(peak, rel=2e-3)


EVEN = np.linspace(0.8, 2.4, 3001)
# As a continuation steps: many points at the resonances, few between them.
AS_TRACED = np.r_[
    0.8, 0.9, 1 + np.linspace(-0.05, 0.05, 101), 1.2, 1.5, 1.9, 2 + np.linspace(-0.05, 0.05, 101), 2.2, 2.4
]


@pytest.mark.parametrize("frequency", [EVEN, AS_TRACED], ids=["even", "as traced"])
@pytest.mark.parametrize("sign", [1.0, -1.0])
def test_antiresonances_are_none_and_the_sign_of_the_point_does_not_matter(duffing, sign, frequency):
    modes = [1 / (w**2 - frequency**2 + 0.02j * w * frequency) for w in (1.0, 2.0)]
    curve = with_response(duffing, frequency, sign * (modes[0] + modes[1]))
    found = quadrature_resonances(curve, "mass")
    assert [r.frequency for r in found] == pytest.approx([1.0, 2.0], rel=1e-3)
    assert [r.receptance for r in found] == pytest.approx([50.0, 12.5], rel=0.02)


def test_where_the_branch_was_not_followed_there_is_none(duffing):
    (found,) = quadrature_resonances(duffing, "mass")
    gap = np.zeros(len(duffing), dtype=bool)
    gap[found.place + 1] = True
    assert quadrature_resonances(replace(duffing, after_gap=gap), "mass") == []


def test_loss_that_grows_along_the_curve_is_read_off_four_points(duffing):
    """As friction's: 0.01 of the stiffness at rest and as much again at an amplitude of 50. Points at -28, -8, 7 and 25
    degrees; a circle through two of them is 0.3 % too large."""
    off = np.radians([-60.0, -28.0, -8.0, 7.0, 25.0, 60.0])

    def amplitude(phase):
        return brentq(lambda a: a * 0.01 * (1 + a / 50) - np.cos(phase), 1, 200)

    sizes = np.array([amplitude(phase) for phase in off])
    receptance = sizes * np.exp(-1j * (np.pi / 2 + off))
    (found,) = quadrature_resonances(with_response(duffing, np.sqrt(1 - np.sin(off) / sizes), receptance), "mass")
    assert found.receptance == pytest.approx(amplitude(0.0), rel=5e-4)
    assert found.frequency == pytest.approx(1.0, abs=1e-5)
