"""A branch traced from both ends in turn: met within the other segment, given up where what connects them is long."""

from dataclasses import replace

import numpy as np
import pytest
from support.peers import one_degree_of_freedom, solved

from updamp.hbm.contact.springs import CubicParameters, CubicSpring
from updamp.hbm.continuation import segments
from updamp.hbm.continuation.continuation import ContinuationOptions, continue_branch
from updamp.hbm.continuation.curve import CurveRequest, trace, whole_curve
from updamp.hbm.continuation.curve_records import CurveOptions
from updamp.hbm.continuation.sweeps import sweep, turning_points
from updamp.hbm.harmonics import Harmonics
from updamp.hbm.problem.elements import ElementGroup
from updamp.hbm.problem.linear_model import from_matrices
from updamp.hbm.problem.system import Excitation, NonlinearSystem


@pytest.fixture(scope="module")
def hysteresis():
    """Duffing's oscillator between two folds, some hundred points"""
    d = solved("a_duffing_1dof")["definition"]
    group = ElementGroup(CubicSpring(), CubicParameters(np.array([d["g"]])), np.array([[0]]))
    system = one_degree_of_freedom(d["c"], group, tuple(range(8)), 128)
    window = (0.5 / 2 / np.pi, 2.0 / 2 / np.pi)
    request = CurveRequest(
        "1",
        Excitation(system.free.row("mass"), d["P"]),
        window,
        ("mass",),
        options=ContinuationOptions(largest_step=0.1),
    )
    *_, curve = trace(system, request)
    return system, request, curve


@pytest.mark.parametrize("upwards", [True, False])
@pytest.mark.parametrize("alone", [2, 30])
def test_the_same_curve_from_both_ends(hysteresis, alone, upwards):
    system, request, whole = hysteresis
    *_, curve = trace(system, replace(request, upwards=upwards, assembly=CurveOptions(from_one_end=alone)))
    assert curve.complete
    assert not curve.after_gap.any()
    frequency = curve.frequency if upwards else curve.frequency[::-1]
    folds, wanted = (f[turning_points(f)] for f in (frequency, whole.frequency))
    assert len(folds) == 2
    np.testing.assert_allclose(folds, wanted, rtol=1e-3)
    assert curve.peak("mass") == pytest.approx(whole.peak("mass"), rel=1e-3)
    assert len(curve) < 1.1 * len(whole)


def test_what_a_segment_traced_on_another_branch_is_left_out(hysteresis, monkeypatch):
    """Below its first fold the segment from the lower end jumps to the other sheet and goes back along it, for ever."""
    system, request, whole = hysteresis
    request = replace(request, assembly=CurveOptions(from_one_end=20))
    below, low = whole.frequency[turning_points(whole.frequency)][::-1]
    lost = 0.5 * (below + low)

    def on_another_branch(system, excitation, window, options, upwards, resume=()):
        for point in continue_branch(system, excitation, window, options, upwards, resume):
            yield point
            if upwards and point.frequency > lost:
                break
        else:
            return
        while True:
            yield from continue_branch(system, excitation, (window[0], lost), options, False, ())

    monkeypatch.setattr(segments, "continue_branch", on_another_branch)
    *_, curve = trace(system, request)
    assert curve.complete
    assert not curve.after_gap.any()
    assert curve.peak("mass") == pytest.approx(whole.peak("mass"), rel=1e-3)
    assert len(turning_points(curve.frequency)) == 2


def test_what_connects_two_segments_is_not_followed_for_ever(hysteresis):
    """Both sheets and their jumps are known before the unstable part between the folds is."""
    system, request, whole = hysteresis
    request = replace(request, assembly=CurveOptions(from_one_end=2, connecting=4, most_starts=0))
    *_, curve = trace(system, request)
    assert not curve.complete
    assert "not followed between" in curve.stopped
    assert curve.after_gap.sum() == 1
    assert len(curve) < len(whole)
    folds = [sweep(curve.frequency, upwards).jumps for upwards in (True, False)]
    wanted = [sweep(whole.frequency, upwards).jumps for upwards in (True, False)]
    np.testing.assert_allclose(folds, wanted, rtol=0.02)


@pytest.fixture(scope="module")
def two_oscillators():
    """Alike, coupled by cubic springs; the second one's resonance overhangs the upper end of the window, where there
    are three solutions."""
    one, other = np.eye(2)
    directions = np.array([one, one + other, one - other])
    linear = from_matrices(np.eye(2), 0.01 * np.eye(2), np.diag([1.0, 1.02]), directions, {"one": one, "other": other})
    group = ElementGroup(CubicSpring(), CubicParameters(np.array([0.3, 0.5, 0.2])), np.arange(3)[:, None])
    system = NonlinearSystem(linear, (group,), Harmonics((1, 3)), 64)
    window = (0.9 / 2 / np.pi, 1.5 / 2 / np.pi)
    return system, CurveRequest("1", Excitation(linear.row("one"), 0.05), window, ("one", "other"))


@pytest.mark.parametrize("alone", [2, 200])
def test_what_comes_in_where_the_branch_leaves_is_found_from_either_end(two_oscillators, alone):
    """From below the branch leaves on the overhanging resonance, with a peak of its own in the window: it was complete,
    without the branch that a sweep from above sees."""
    system, request = two_oscillators
    request = replace(request, assembly=CurveOptions(from_one_end=alone))
    up, down = (whole_curve(system, replace(request, upwards=upwards)) for upwards in (True, False))
    for curve in (up, down):
        assert not curve.complete
        assert "widen" in curve.stopped
    np.testing.assert_allclose(up.frequency, down.frequency[::-1], rtol=1e-9)
    np.testing.assert_allclose(up.amplitudes(), down.amplitudes()[::-1], rtol=1e-6)
    flank = request.excitation.force / (1.5**2 - 1)  # far above resonance, almost linear
    assert abs(up.amplitude("one")[-1]) == pytest.approx(flank, rel=0.01), "the low branch that a sweep begins on"


def test_a_branch_that_ends_where_the_other_end_begins_is_traced_once(hysteresis, monkeypatch):
    system, request, whole = hysteresis
    begun = []

    def counted(system, excitation, window, options, upwards, resume=()):
        begun.append(upwards)
        yield from continue_branch(system, excitation, window, options, upwards, resume)

    monkeypatch.setattr(segments, "continue_branch", counted)
    assert len(whole_curve(system, request)) == len(whole)
    assert begun == [True]
