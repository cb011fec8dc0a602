"""Folds without a rounded top, and new starts where a branch stops from both sides."""

import numpy as np
import pytest
from support.peers import one_degree_of_freedom, solved

from updamp.hbm import continuation
from updamp.hbm import curve as curve_module
from updamp.hbm.contact.springs import CubicParameters, CubicSpring, UnilateralParameters, UnilateralSpring
from updamp.hbm.continuation import BranchStoppedError, ContinuationOptions, continue_branch
from updamp.hbm.curve import CurveRequest, trace
from updamp.hbm.elements import ElementGroup
from updamp.hbm.newton import Status
from updamp.hbm.system import Excitation

ROW = np.array([[0]])
GAP = 1.0
WINDOW = (1.2 / 2 / np.pi, 1.6 / 2 / np.pi)


@pytest.fixture(scope="module", params=[10.0, 100.0, 1e4])
def against_a_stop(request):
    """One degree of freedom of 1 rad/s above its resonance, and a stiff stop seen at eight instants: met coming down
    in frequency, it sends the branch back up."""
    stiffness = request.param
    stop = ElementGroup(UnilateralSpring(), UnilateralParameters(np.array([stiffness]), np.array([GAP])), ROW)
    system = one_degree_of_freedom(0.01, stop, (1,), 8)
    force = GAP * abs(1 - 1.35**2)  # touches at 1.35 rad/s
    return system, Excitation(system.free.row("mass"), force)


def walked(system, excitation, points=60):
    found = []
    options = ContinuationOptions(max_points=points, leaps=())
    try:
        for point in continue_branch(system, excitation, WINDOW, options, upwards=False):
            found.append((point.w, float(np.linalg.norm(point.x))))
    except BranchStoppedError as stop:
        return np.array(found), stop
    return np.array(found), None


def test_branch_goes_round_a_fold_without_a_top(against_a_stop):
    found, stop = walked(*against_a_stop)
    assert stop is None
    w, size = found.T
    turn = int(np.argmin(w))
    assert w[turn] == pytest.approx(1.35, abs=0.01)
    assert 0 < turn < len(w) - 1
    assert (np.diff(w[turn + 1 :]) > 0).all(), "beyond the corner the branch goes up again"
    assert (size[turn + 1 :] > 0.99 * GAP).all(), "along the stop"


def test_without_the_far_sides_tangent_it_stops_there(against_a_stop, monkeypatch):
    monkeypatch.setattr(continuation, "ways_on", lambda *_: iter(()))
    found, stop = walked(*against_a_stop)
    assert stop is not None
    assert found[-1, 0] == pytest.approx(1.35, abs=0.01)


def test_new_starts_cross_what_both_pieces_leave_out(monkeypatch):
    """Both pieces are stopped on their ways, with a tenth of the window between them."""
    d = solved("a_duffing_1dof")["definition"]
    group = ElementGroup(CubicSpring(), CubicParameters(np.array([0.0 * d["g"]])), ROW)
    system = one_degree_of_freedom(d["c"], group, (0, 1), 16)
    window = (0.5 / 2 / np.pi, 2.0 / 2 / np.pi)
    request = CurveRequest("1", Excitation(system.free.row("mass"), d["P"]), window, ("mass",))
    *_, whole = trace(system, request)
    left_out = np.quantile(window, (0.5, 0.6))

    def stopped(system, excitation, window, options, upwards, resume=()):
        for point in continue_branch(system, excitation, window, options, upwards, resume):
            if left_out[0] < point.frequency < left_out[1]:
                raise BranchStoppedError(point.frequency, 1.0, Status.STALLED)
            yield point

    monkeypatch.setattr(curve_module, "continue_branch", stopped)
    *_, crossed = trace(system, request)
    assert crossed.complete
    assert not crossed.stopped
    widths = np.abs(np.diff(crossed.gaps(), axis=1))
    assert 1 <= len(widths) <= 3
    assert widths.max() < 0.05 * (window[1] - window[0])
    assert crossed.peak("mass") == pytest.approx(whole.peak("mass"), rel=1e-3)
    assert crossed.frequency[0] == pytest.approx(whole.frequency[0])
