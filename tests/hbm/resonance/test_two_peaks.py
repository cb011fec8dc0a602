"""Two linear peaks close together: each can be followed by a window of its own."""

from dataclasses import replace

import numpy as np
import pytest

from updamp.hbm.contact.springs import CubicParameters, CubicSpring
from updamp.hbm.continuation.curve import CurveRequest, whole_curve
from updamp.hbm.harmonics import Harmonics
from updamp.hbm.problem.elements import ElementGroup
from updamp.hbm.problem.linear_model import from_matrices
from updamp.hbm.problem.system import Excitation, NonlinearSystem
from updamp.hbm.resonance.conditions import MaximumResonance, PhaseResonance, ResonanceCondition
from updamp.hbm.resonance.linear_peak import linear_peak
from updamp.hbm.resonance.resonance import ResonanceProblem
from updamp.hbm.resonance.resonance_curve import ResonanceRequest, whole_resonance
from updamp.notebook.resonance import Resonance


@pytest.fixture(scope="module")
def absorber() -> NonlinearSystem:
    """A cubic spring's mass with a vibration absorber: its receptance is largest at 0.1431 and 0.1675 Hz, and the
    undamped modes lie at 0.1390 and 0.1737 Hz."""
    k, c = 0.0454, 0.0128
    M, C = np.diag([1.0, 0.05]), np.array([[0.002 + c, -c], [-c, c]])
    K, relative = np.array([[1.0 + k, -k], [-k, k]]), np.array([[1.0, 0.0], [1.0, -1.0]])
    springs = ElementGroup(CubicSpring(), CubicParameters(np.array([1.0, 0.0042])), np.array([[0], [1]]))
    linear = from_matrices(M, C, K, relative, {"mass": np.array([1.0, 0.0])})
    return NonlinearSystem(linear, (springs,), Harmonics((1, 3, 5)), 128)


def requested(window: tuple[float, float], condition: ResonanceCondition) -> ResonanceRequest:
    return ResonanceRequest("1", "mass", "mass", window, (1e-5, 0.01, 0.1), condition)


@pytest.mark.parametrize("window", [(0.165, 0.25), (0.16, 0.2), (0.155, 0.18)])
def test_the_second_peak_is_followed_where_the_window_holds_it_alone(absorber, window) -> None:
    """It began at the first one, outside the window, and said that it had stalled and needed more time samples."""
    row = absorber.free.row("mass")
    w = 2 * np.pi * np.linspace(*window, 20001)
    size = np.abs([absorber.free.receptance(each, [row], [row])[0, 0] for each in w])
    assert linear_peak(ResonanceProblem(absorber, row, row), window, 0.0).w == pytest.approx(w[size.argmax()], rel=1e-5)
    curve = whole_resonance(absorber, requested(window, MaximumResonance()))
    assert curve.complete, curve.stopped
    at = curve.at_forces()
    assert at.frequency[0] == pytest.approx(w[size.argmax()] / (2 * np.pi), rel=1e-4)
    assert np.abs(at.receptance[0]) == pytest.approx(size.max(), rel=1e-5)


def test_the_second_peak_followed_is_that_of_the_response_curve(absorber) -> None:
    followed = whole_resonance(absorber, requested((0.165, 0.25), MaximumResonance())).at_forces()
    request = CurveRequest("1", Excitation(absorber.free.row("mass"), 0.1), (0.175, 0.25), ("mass",))
    frequency, receptance = whole_curve(absorber, request).peak("mass")
    assert followed.frequency[-1] == pytest.approx(frequency, rel=1e-4)
    assert np.abs(followed.receptance[-1]) == pytest.approx(receptance, rel=1e-5)


def test_the_first_peak_too_is_begun_at_in_a_window_of_its_own(absorber) -> None:
    """It began at the second one."""
    curve = whole_resonance(absorber, requested((0.12, 0.15), MaximumResonance()))
    assert curve.frequency[0] == pytest.approx(0.143132, rel=1e-5)


def test_what_is_found_outside_the_window_is_told_as_such(absorber) -> None:
    """A quarter period's lag lies between both peaks."""
    curve = whole_resonance(absorber, requested((0.165, 0.25), PhaseResonance()))
    assert not curve.complete
    assert "lies at 0.161096 Hz, outside the window from 0.165 to 0.25 Hz: widen the window" in curve.stopped
    assert "stalled" not in curve.stopped
    assert "samples" not in curve.stopped


@pytest.mark.parametrize(("asked_for", "peak"), [(0.14, 0.143132), (0.17, 0.167498)])
def test_of_two_that_overlap_the_one_that_is_asked_for_is_begun_at(absorber, asked_for, peak) -> None:
    """In a window that holds both each was taken for the other."""
    row = absorber.free.row("mass")
    found = linear_peak(ResonanceProblem(absorber, row, row), (0.1, 0.3), 0.0, mode_frequency=asked_for)
    assert found.w / (2 * np.pi) == pytest.approx(peak, rel=1e-5)


def test_that_a_resonance_turned_back_in_force_is_told(absorber) -> None:
    """Followed from the upper peak at a phase of its own it turns where both peaks come near each other, and from there
    on the lower one is what is met: 0.206 Hz at 0.15 N, 0.178 Hz at 0.16 N."""
    forces = (0.01, 0.13, 0.15, 0.16)
    request = ResonanceRequest("1", "mass", "mass", (0.155, 0.3), forces, MaximumResonance())
    whole = Resonance(whole_resonance(absorber, request))
    before = Resonance(whole_resonance(absorber, replace(request, forces=forces[:3])))
    assert len(before.turned) == 0
    assert "turned" not in repr(before)
    assert whole.frequency[-1] < whole.frequency[-2] - 0.02
    assert np.all((whole.turned > 0.15) & (whole.turned < 0.16))
    assert "turned back in force near 0.15" in repr(whole)
