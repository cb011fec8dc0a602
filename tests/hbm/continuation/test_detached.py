"""A closed loop beside a curve: traced from a solution on it, kept with the curve, known again."""

from dataclasses import replace

import numpy as np
import pytest
from support.isolated_resonance import FORCE, isolated_resonance, resonances

from updamp.hbm.continuation.branch import point_at
from updamp.hbm.continuation.curve import whole_curve
from updamp.hbm.continuation.curve_records import CurveOptions
from updamp.hbm.continuation.detached import apart, detached_through, middle, missing
from updamp.hbm.continuation.pieces import Pieces
from updamp.hbm.continuation.segments import from_end, segment_from
from updamp.hbm.newton.newton import solve
from updamp.hbm.resonance.quadrature import quadrature_resonances
from updamp.hbm.stability.branch_stability import State
from updamp.hbm.stability.detached_branches import detached_branches


@pytest.fixture(scope="module")
def traced():
    system, request = isolated_resonance()
    return system, request, whole_curve(system, request)


def at_resonance(amplitude):
    """x of 0, cos, sin: a quarter of a period behind the force"""
    return np.array([[0.0, 0.0, amplitude]]), 1.0


@pytest.fixture(scope="module")
def loop(traced):
    (found,) = detached_through(*traced, [at_resonance(resonances()[2])])
    return found


def test_the_curve_through_the_window_has_the_lowest_resonance_alone(traced):
    _, _, curve = traced
    assert curve.complete
    assert curve.detached == ()
    (only,) = quadrature_resonances(curve, "mass")
    assert only.receptance * FORCE == pytest.approx(resonances()[0], rel=1e-3)
    assert curve.peak("mass")[1] * FORCE == pytest.approx(resonances()[0], rel=2e-3), "the largest is at another phase"


def test_the_loop_closes_and_has_both_other_resonances(loop):
    assert loop.complete
    assert loop.stopped == ""
    np.testing.assert_array_equal(loop.displacement[0], loop.displacement[-1])
    sizes = sorted(r.receptance * FORCE for r in quadrature_resonances(loop, "mass"))
    assert loop.peak("mass")[1] * FORCE == pytest.approx(resonances()[2], rel=1e-4)
    assert sizes[-1] == pytest.approx(resonances()[2], rel=1e-3)
    assert np.abs(loop.amplitude("mass")).min() <= resonances()[1] * (1 + 1e-3)
    steps = np.abs(np.diff(loop.amplitude("mass")))
    # where two segments meet, what one has traced of the other's last step is left out: up to a step of each
    assert steps[-1] <= 2 * steps[:-1].max(), "no gap where it closes"


def test_what_is_known_is_not_traced_again(traced, loop):
    system, request, curve = traced
    scale = request.options.scale_w(request.window)
    low, middle_one, high = (at_resonance(a) for a in resonances())
    assert missing(curve, [low, middle_one, high], scale) == [middle_one, high]
    with_loop = replace(curve, detached=(loop,))
    assert missing(with_loop, [low, middle_one, high, middle(loop)], scale) == []
    assert detached_through(system, request, curve, [low]) == ()
    assert len(detached_through(system, request, curve, [high, middle_one])) == 1


def test_a_loop_that_takes_more_points_than_allowed_is_kept_in_part(traced):
    system, request, curve = traced
    few = replace(request, assembly=CurveOptions(detached=3))
    (found,) = detached_through(system, few, curve, [at_resonance(resonances()[2])])
    assert not found.complete
    assert "not followed round" in found.stopped
    assert len(found) <= 7


def test_what_lies_beyond_the_window_is_not_told(traced, loop):
    system, request, curve = traced
    beyond = (float(loop.frequency.max()) + 0.01, float(loop.frequency.max()) + 0.02)
    assert detached_through(system, replace(request, window=beyond), curve, [at_resonance(resonances()[2])]) == ()


def test_a_loop_met_while_a_curve_is_traced_is_no_part_of_it(traced):
    """In whatever order: the branch is one, with no gap, and the loop beside it."""
    system, request, curve = traced
    x, w = at_resonance(resonances()[2])
    solution = solve(system, request.excitation, x, w)
    start = point_at(solution, request.excitation, request.options.scale_w(request.window), (0 * x, 1.0), 0.0)
    pieces = Pieces(*(from_end(system, request, upwards, 0.0) for upwards in (True, False)))
    pair = [segment_from(system, request, start, upwards, 0.0) for upwards in (True, False)]
    pieces.add(start, *pair)
    while any(segment.active for segment in pieces.segments):
        for segment in pieces.segments:
            if segment.active:
                pieces.advance(segment)
        if pieces.connected and not any(segment.active for segment in pair):
            break
    assert pieces.connected
    on_the_way = [part.segment for part in pieces.parts()]
    assert not set(pair) & set(on_the_way)
    ((chain, closed),) = pieces.detached()
    assert closed
    assert {part.segment for part in chain} == set(pair)
    found = apart(pieces.first.records, chain, closed)
    assert found.peak("mass")[1] * FORCE == pytest.approx(resonances()[2], rel=1e-4)
    assert len(curve) <= sum(len(segment.records) for segment in on_the_way) + 25


def test_the_top_of_the_loop_is_stable_and_its_bottom_is_not(traced):
    system, request, curve = traced
    found = detached_branches(system, request, curve, "mass", [at_resonance(resonances()[1])])
    assert len(found.branches) == 1
    assert found.state.tolist() == [State.STABLE]
    assert found.reasons == ("",)
