"""Restarts beyond a place where a branch stops from both ends, and first points outside or inside the window."""

from dataclasses import replace

import numpy as np
import pytest
from support.peers import one_degree_of_freedom, solved

from updamp.hbm.contact.springs import CubicParameters, CubicSpring
from updamp.hbm.continuation import continuation
from updamp.hbm.continuation import curve as curve_module
from updamp.hbm.continuation.continuation import BranchStoppedError, ContinuationOptions, continue_branch, first_point
from updamp.hbm.continuation.curve import CurveRequest, trace
from updamp.hbm.continuation.restart import Restart
from updamp.hbm.newton.newton import Status
from updamp.hbm.problem.elements import ElementGroup
from updamp.hbm.problem.system import Excitation

WINDOW = (0.5 / 2 / np.pi, 2.0 / 2 / np.pi)


def linear_oscillator():
    d = solved("a_duffing_1dof")["definition"]
    group = ElementGroup(CubicSpring(), CubicParameters(np.array([0.0])), np.array([[0]]))
    system = one_degree_of_freedom(d["c"], group, (0, 1), 16)
    return system, CurveRequest("1", Excitation(system.free.row("mass"), d["P"]), WINDOW, ("mass",))


def test_restarts_cross_what_both_segments_leave_out(monkeypatch):
    """Both segments are stopped with a tenth of the window between them."""
    system, request = linear_oscillator()
    *_, whole = trace(system, request)
    left_out = np.quantile(WINDOW, (0.5, 0.6))

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
    assert widths.max() < 0.05 * (WINDOW[1] - WINDOW[0])
    assert abs(crossed.peak("mass")[1] / whole.peak("mass")[1] - 1) < 1e-3
    assert abs(crossed.frequency[0] / whole.frequency[0] - 1) < 1e-12


def test_a_branch_that_comes_back_is_traced_from_the_other_end(monkeypatch):
    """A branch that turns round and leaves the window where it began is not the one that leads through it. It is met
    where it had not turned yet, and what it traced after that is left out.
    """
    system, request = linear_oscillator()
    *_, whole = trace(system, request)
    turn = np.quantile(WINDOW, 0.2)

    def turning(system, excitation, window, options, upwards, resume=()):
        points = []
        for point in continue_branch(system, excitation, window, options, upwards, resume):
            points.append(point)
            yield point
            if upwards and point.frequency > turn:
                below = next(continue_branch(system, excitation, (0.99 * window[0], window[1]), options))
                yield from (*points[-2::-1], below)
                return

    monkeypatch.setattr(curve_module, "continue_branch", turning)
    *_, curve = trace(system, request)
    assert curve.complete
    assert curve.frequency.max() >= WINDOW[1]
    assert not curve.after_gap.any()
    assert (np.diff(curve.frequency) > 0).all()
    assert abs(curve.peak("mass")[1] / whole.peak("mass")[1] - 1) < 1e-3


def test_restarts_go_on_from_a_segment_that_came_back(monkeypatch):
    """The segment from below turns back at 0.2 of the window, the one from above stops at 0.3."""
    system, request = linear_oscillator()
    *_, whole = trace(system, request)
    turn, end = np.quantile(WINDOW, (0.2, 0.3))

    def ending(system, excitation, window, options, upwards, resume=()):
        for point in continue_branch(system, excitation, window, options, upwards, resume):
            if not upwards and point.frequency < end:
                raise BranchStoppedError(point.frequency, 1.0, Status.STALLED)
            if upwards and point.frequency > turn:
                yield next(continue_branch(system, excitation, (0.99 * window[0], window[1]), options))
                return
            yield point

    monkeypatch.setattr(curve_module, "continue_branch", ending)
    *_, curve = trace(system, request)
    assert curve.complete
    assert not curve.stopped
    assert abs(curve.peak("mass")[1] / whole.peak("mass")[1] - 1) < 1e-3


@pytest.mark.parametrize("upwards", [True, False])
def test_a_branch_is_led_into_the_window_where_its_end_has_no_first_point(monkeypatch, upwards):
    """First points are found only 0.15 of the window's width outside: the branch is handed out from the end on."""
    system, request = linear_oscillator()
    *_, whole = trace(system, request)
    width = WINDOW[1] - WINDOW[0]

    def far_out(system, excitation, w, options=None):
        if WINDOW[0] - 0.15 * width < w / 2 / np.pi < WINDOW[1] + 0.15 * width:
            raise BranchStoppedError(w / 2 / np.pi, 1.0, Status.STALLED)
        return first_point(system, excitation, w, options)

    monkeypatch.setattr(continuation, "first_point", far_out)
    points = list(continue_branch(system, request.excitation, WINDOW, upwards=upwards))
    frequency = np.array([point.frequency for point in points])[:: 1 if upwards else -1]
    assert (np.diff(frequency) > 0).all()
    assert WINDOW[0] - 0.1 * width < frequency[0] < WINDOW[0] or not upwards
    assert WINDOW[1] < frequency[-1] < WINDOW[1] + 0.1 * width
    *_, curve = trace(system, request)
    assert curve.complete
    assert abs(curve.peak("mass")[1] / whole.peak("mass")[1] - 1) < 1e-3


def test_where_no_start_is_found_the_end_of_the_window_is_named(monkeypatch):
    system, request = linear_oscillator()

    def nowhere(_system, _excitation, w, _options=None):
        raise BranchStoppedError(w / 2 / np.pi, 1.0, Status.STALLED)

    monkeypatch.setattr(continuation, "first_point", nowhere)
    with pytest.raises(BranchStoppedError) as stop:
        next(iter(continue_branch(system, request.excitation, WINDOW)))
    assert stop.value.frequency == pytest.approx(WINDOW[0])


@pytest.mark.parametrize("upwards", [True, False])
def test_a_branch_begins_a_little_inside_where_its_end_has_no_first_point(monkeypatch, upwards):
    """First points are found from 0.02 of the window's width inside on, and nowhere outside."""
    system, request = linear_oscillator()
    *_, whole = trace(system, request)
    width = WINDOW[1] - WINDOW[0]

    def far_in(system, excitation, w, options=None):
        if not WINDOW[0] + 0.02 * width < w / 2 / np.pi < WINDOW[1] - 0.02 * width:
            raise BranchStoppedError(w / 2 / np.pi, 1.0, Status.STALLED)
        return first_point(system, excitation, w, options)

    monkeypatch.setattr(continuation, "first_point", far_in)
    points = list(continue_branch(system, request.excitation, WINDOW, upwards=upwards))
    left_out = points[0].frequency - WINDOW[0] if upwards else WINDOW[1] - points[0].frequency
    assert left_out == pytest.approx(0.04 * width)
    *_, curve = trace(system, request)
    assert curve.complete
    assert abs(curve.peak("mass")[1] / whole.peak("mass")[1] - 1) < 1e-3


@pytest.mark.parametrize(("left_out", "complete"), [(0.03, True), (0.1, False)])
def test_segments_that_end_close_to_each_other_are_one_curve_with_a_gap(monkeypatch, left_out, complete):
    """Close: no further than the furthest restart that is tried, since what lies beyond is known already."""
    system, request = linear_oscillator()
    low, high = np.quantile(WINDOW, (0.5, 0.5 + left_out))

    def stopped(system, excitation, window, options, upwards, resume=()):
        for point in continue_branch(system, excitation, window, options, upwards, resume):
            if low < point.frequency < high:
                raise BranchStoppedError(point.frequency, 1.0, Status.STALLED)
            yield point

    monkeypatch.setattr(curve_module, "continue_branch", stopped)
    monkeypatch.setattr(Restart, "_start", lambda *_: None)
    request = replace(request, options=ContinuationOptions(largest_step=0.06))
    *_, curve = trace(system, request)
    assert curve.complete == complete
    assert bool(curve.stopped) != complete
    assert len(curve.gaps()) == 1
    assert np.ptp(curve.gaps()) >= 0.99 * (high - low)
