"""Half of a problem with a plane of symmetry: the same responses as the whole, of half the unknowns."""

from dataclasses import replace

import numpy as np
import pytest
from support.three_masses import WINDOW, three_masses

from updamp.hbm.continuation.curve import CurveRequest, trace
from updamp.hbm.newton.equation import residual_alone
from updamp.hbm.problem.system import Excitation
from updamp.hbm.resonance.conditions import PhaseResonance
from updamp.hbm.resonance.resonance_curve import ResonanceRequest, trace_resonance
from updamp.hbm.stability.stability import stability


def request_for(system, force=0.3):
    excitation = Excitation(system.free.row("drive"), force)
    return CurveRequest("1", excitation, WINDOW, ("drive",))


@pytest.fixture(scope="module")
def curves():
    """The problem and the curve of its half."""
    system = three_masses()
    return system, list(trace(system, request_for(system)))[-1]


def test_half_of_the_contacts_and_the_symmetric_modes_are_left(curves):
    system, _ = curves
    assert system.half is not None
    assert system.half.free.n_relative == 6
    assert len(system.half.free.omega_squared) == 5
    assert system.half.groups[0].copies.tolist() == [2.0, 1.0]


def test_the_curve_is_that_of_the_whole(curves):
    """At a force at which no motion leaves the symmetry: at 0.3 the whole problem passes places where that begins, and
    whether it is followed across them depends on round-off."""
    system, _ = curves
    half, whole = (list(trace(one, request_for(one, 0.2)))[-1] for one in (system, replace(system, as_a_whole=True)))
    assert half.complete
    assert whole.complete
    assert half.active.max() > 0, "contacts slip"
    assert half.peak("drive") == pytest.approx(whole.peak("drive"), rel=1e-3)


def test_its_points_solve_the_whole_problem_and_keep_its_energy_balance(curves):
    system, half = curves
    assert half.displacement.shape[1:] == (9, 7)
    excitation = request_for(system).excitation
    for i in range(0, len(half), 5):
        x = half.displacement[i]
        residual = residual_alone(system, excitation, x, 2 * np.pi * half.frequency[i])
        assert np.abs(residual).max() < 1e-8 * np.abs(x).max()
        balance = half.work_in[i] - half.friction_loss[i] - half.material_loss[i]
        assert abs(balance) < 2e-3 * half.work_in[i]


def test_a_resonance_followed_in_force_is_that_of_the_whole(curves):
    system, _ = curves
    request = ResonanceRequest("1", "drive", "drive", WINDOW, (0.1, 0.3), PhaseResonance())
    half, whole = (list(trace_resonance(one, request))[-1] for one in (system, replace(system, as_a_whole=True)))
    assert half.complete
    assert half.displacement.shape[1:] == (9, 7)
    np.testing.assert_allclose(half.frequency[-1], whole.frequency[-1], rtol=1e-6)
    np.testing.assert_array_equal(half.states[-1], whole.states[-1])
    np.testing.assert_allclose(half.friction_loss[-1], whole.friction_loss[-1], rtol=1e-5)


@pytest.mark.parametrize(
    "system", [three_masses(kn=(2.0, 2.1, 1.0)), three_masses(off=0.01)], ids=["contacts", "structure"]
)
def test_what_is_not_its_own_image_is_solved_as_a_whole(system):
    assert system.half is None


def test_so_is_what_is_driven_from_one_side():
    system = three_masses()
    assert system.half_driven_at(0) is None
    assert system.half_driven_at(system.free.row("drive")) is not None


def test_stability_of_both_halves_is_that_of_the_whole(curves):
    """Exponents of both halves are those of the whole."""
    system, curve = curves
    whole = replace(system, mirror=None)
    assert system.other_half is not None
    assert len(system.half.free.omega_squared) + len(system.other_half.free.omega_squared) == 9
    slipping, compared = np.flatnonzero(curve.active > 0), 0
    for i in slipping[:: max(1, len(slipping) // 4)]:
        x, w = curve.displacement[i], 2 * np.pi * curve.frequency[i]
        halves, one = stability(system, x, w), stability(whole, x, w)
        assert halves.trusted == one.trusted
        if one.trusted:  # what is not known may be not a number in the one and a number in the other
            assert halves.stable == one.stable
            assert halves.decisive.real == pytest.approx(one.decisive.real, rel=1e-3)
            compared += 1
    assert compared >= 3


def test_a_motion_that_is_not_symmetric_is_judged_in_the_whole_problem(curves):
    system, curve = curves
    i = int(curve.active.argmax())
    x = curve.displacement[i].copy()
    assert system.mirror.keeps(x)
    x[1] += 1e-3 * np.abs(x).max()
    assert not system.mirror.keeps(x)
