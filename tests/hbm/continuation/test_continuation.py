"""Branches: through folds, energy balance, resume, sweeps."""

from dataclasses import dataclass, replace
from itertools import islice

import numpy as np
import pytest
from support.peers import FOLDER, blades_and_damper_system, one_degree_of_freedom, solved

from updamp.hbm.contact.jenkins_box import JenkinsBox
from updamp.hbm.contact.springs import CubicParameters, CubicSpring
from updamp.hbm.continuation import corrector, segments
from updamp.hbm.continuation.completeness import CompletenessLimits
from updamp.hbm.continuation.continuation import BranchStoppedError, ContinuationOptions, continue_branch
from updamp.hbm.continuation.corrector import Corrector
from updamp.hbm.continuation.curve import CurveRequest, trace
from updamp.hbm.continuation.retracing import TracedBranch, turn_between
from updamp.hbm.continuation.step_lengths import StepLengths
from updamp.hbm.continuation.sweeps import sweep, swept, turning_points
from updamp.hbm.newton.newton import NewtonOptions, Status
from updamp.hbm.problem.elements import ElementGroup
from updamp.hbm.problem.linear_model import from_matrices
from updamp.hbm.problem.system import Excitation

ROW = np.array([[0]])


@pytest.fixture(scope="module")
def duffing():
    d = solved("a_duffing_1dof")["definition"]
    group = ElementGroup(CubicSpring(), CubicParameters(np.array([d["g"]])), ROW)
    system = one_degree_of_freedom(d["c"], group, tuple(range(8)), 128)
    request = CurveRequest(
        "1", Excitation(system.free.row("mass"), d["P"]), (0.5 / 2 / np.pi, 2.0 / 2 / np.pi), ("mass",)
    )
    *_, curve = trace(system, request)
    return system, request, curve


def test_duffing_peak_beyond_the_fold(duffing):
    """The largest amplitude lies on an overhanging branch; three codes agree on where."""
    _, _, curve = duffing
    assert curve.complete
    assert len(turning_points(curve.frequency)) == 2
    w, amplitude = solved("a_duffing_1dof")["peak"]["tmdsimpy_parabola"]
    f, receptance = curve.peak("mass")
    assert receptance * curve.force == pytest.approx(amplitude, rel=1e-3)
    assert 2 * np.pi * f == pytest.approx(w, rel=1e-3)


def test_a_curve_without_points_says_why_it_has_no_peak(duffing):
    _, _, curve = duffing
    none = replace(curve, frequency=curve.frequency[:0], response=curve.response[:0], stopped="no first point at 2 Hz")
    with pytest.raises(ValueError, match="no points, so no peak; no first point at 2 Hz"):
        none.peak("mass")


def test_sweeps_jump_where_the_branch_turns(duffing):
    _, _, curve = duffing
    fold_high, fold_low = curve.frequency[turning_points(curve.frequency)]
    up, down = sweep(curve.frequency, upwards=True), sweep(curve.frequency, upwards=False)
    assert up.jumps == pytest.approx([fold_high])
    assert down.jumps == pytest.approx([fold_low])
    assert (np.diff(curve.frequency[up.visited]) > 0).all()
    assert (np.diff(curve.frequency[down.visited]) < 0).all()
    size = np.abs(curve.amplitude("mass"))
    assert size[up.visited].max() == size.max()
    assert size[down.visited].max() < 0.8 * size.max()


def test_a_jump_that_changes_the_response_hardly_at_all_does_not_show(duffing):
    """Whatever the steps: the change is taken at the frequency of the jump."""
    _, _, curve = duffing
    for upwards in (True, False):
        np.testing.assert_array_equal(swept(curve, upwards).jumps, sweep(curve.frequency, upwards).jumps)
        assert not len(swept(curve, upwards, CompletenessLimits(change=2.0)).jumps)
    frequency = np.array([1.0, 2.0, 3.0, 2.5, 4.0, 5.0])  # turns back at 3, and passes it again a third of the way to 4
    for size, shown in ((1.08, 0), (1.12, 1)):
        values = np.array([1.0, 1.0, 1.0, size, size, 5.0])
        assert len(swept(_FewPoints(frequency, values), True).jumps) == shown
        assert len(swept(_FewPoints(frequency[::-1], values[::-1]), True).jumps) == shown


@dataclass(frozen=True)
class _FewPoints:
    frequency: np.ndarray
    size: np.ndarray

    def amplitudes(self) -> np.ndarray:
        return self.size[:, None].astype(complex)


def test_a_solution_far_off_the_predicted_place_is_refused(duffing):
    """A long step may end on another branch; one as short as a kink may turn anywhere."""
    system, request, _ = duffing
    first = [*islice(continue_branch(system, request.excitation, request.window), 6)]
    for off, step, taken in ((0.2, 0.1, True), (1e-9, 0.1, False), (1e-9, 1e-3, True)):
        options = ContinuationOptions(off_predicted=off)
        corrector = Corrector(system, request.excitation, options, options.scale_w(request.window))
        point, solution = corrector.step(TracedBranch.through(first), step)
        assert (point is not None) == taken
        assert solution.converged == taken


@pytest.mark.parametrize("share", [0.0, 0.3, 1.0])
def test_a_kink_between_two_points_is_told_from_another_branch(duffing, share):
    """Wherever it lies both tangents account for the move; what lies between two branches they do not."""
    system, request, _ = duffing
    last, other = [*islice(continue_branch(system, request.excitation, request.window), 10)][-2:]
    metric, step, beside = last.metric, 0.01, 0.002
    unit = metric.length(other.tangent)
    x1, w1 = other.tangent_x / unit, other.tangent_w / unit
    x = last.x + step * (share * last.tangent_x + (1 - share) * x1)
    w = last.w + step * (share * last.tangent_w + (1 - share) * w1)
    angle, off = turn_between(last, replace(other, x=x, w=w))
    assert np.cos(angle) == pytest.approx(metric.product(last.tangent, (x1, w1)))
    assert off < 1e-9 * step
    across = np.zeros_like(x)
    across[0, -1] = 1.0
    for tangent in (last.tangent, (x1, w1)):
        across = across - metric.product(tangent, (across, 0.0)) * tangent[0]
    across *= beside / metric.length((across, 0.0))
    _, off = turn_between(last, replace(other, x=x + across, w=w))
    assert off == pytest.approx(beside, rel=0.05)


def test_the_sharper_a_kink_the_shorter_the_step_across_it():
    lengths = StepLengths(resolution=0.005)
    assert lengths.one_turn(angle=0.1, off=0.0, moved=0.19)
    assert not lengths.one_turn(angle=0.2, off=0.0, moved=0.19)
    assert lengths.one_turn(angle=0.2, off=0.0, moved=0.09)
    assert not lengths.one_turn(angle=0.2, off=0.006, moved=0.09), "another branch"


def test_a_branch_without_folds_is_seen_whole():
    both = [sweep(np.linspace(1.0, 2.0, 9), upwards) for upwards in (True, False)]
    np.testing.assert_array_equal(both[0].visited, np.arange(9))
    np.testing.assert_array_equal(both[1].visited, np.arange(9)[::-1])
    assert not len(both[0].jumps)
    with pytest.raises(ValueError, match="two points"):
        sweep(np.ones(1), True)


@pytest.fixture(scope="module")
def friction_curve():
    system = blades_and_damper_system(JenkinsBox(2))
    request = CurveRequest("1", Excitation(system.free.row("excitation"), 40.0), (228.0, 262.0), ("tip", "excitation"))
    *_, curve = trace(system, request)
    return system, request, curve


def test_energy_balance_at_every_point(friction_curve):
    """Work of the excitation = friction loss (area of the loops, integrated in time) + material loss."""
    _, _, curve = friction_curve
    assert curve.complete
    np.testing.assert_allclose(curve.friction_loss + curve.material_loss, curve.work_in, rtol=2e-3)
    assert curve.friction_loss.max() > 0.3 * curve.work_in.max()


def test_the_top_is_a_solved_point_wherever_the_peak_is_told(friction_curve):
    """Not the top of a spline between points that lie there by chance: 0.2 % higher at this coordinate of the damper,
    whose peak is 22 Hz above that of the blade's tip."""
    system, request, _ = friction_curve
    matrices = np.load(FOLDER / "c_model_20.npz")
    points = {"excitation": matrices["F"], "coordinate": np.eye(len(matrices["M"]))[46]}
    linear = from_matrices(matrices["M"], matrices["C"], matrices["K"], matrices["Q"], points)
    *_, curve = trace(replace(system, free=linear), replace(request, points=tuple(points), told=tuple(points)))
    for point in points:
        assert curve.peak(point)[1] == pytest.approx(np.abs(curve.receptance(point)).max(), rel=1e-7)
    assert curve.peak("coordinate")[0] > curve.peak("excitation")[0] + 20


def test_every_point_is_converged(friction_curve):
    _, request, curve = friction_curve
    assert (curve.error < request.options.newton.tolerance).all()
    assert curve.unconverged == 0


def test_both_directions_find_the_same_peak(friction_curve):
    system, request, curve = friction_curve
    *_, backwards = trace(system, replace(request, upwards=False))
    assert backwards.complete
    # the points lie elsewhere on the branch, and the peak is read between them: 0.2 of its height apart at most
    assert backwards.peak("tip") == pytest.approx(curve.peak("tip"), rel=1e-3)


def test_a_branch_that_cannot_go_on_says_where_and_keeps_what_it_has():
    system = blades_and_damper_system(JenkinsBox(2))
    hopeless = ContinuationOptions(
        first_step=0.2,
        smallest_step=0.19,
        largest_step=0.2,
        recoveries=(),
        newton=NewtonOptions(tolerance=1e-13, iterations=1),
    )
    request = CurveRequest(
        "1", Excitation(system.free.row("excitation"), 40.0), (226.0, 240.0), ("tip",), options=hopeless
    )
    *_, curve = trace(system, request)
    assert not curve.complete
    assert curve.unconverged == 1
    assert len(curve) >= 1
    assert "Hz" in curve.stopped
    assert Status.TOO_MANY_ITERATIONS.advice in curve.stopped


def test_where_steps_are_solved_but_end_off_the_branch_it_says_so(duffing, monkeypatch):
    """It asked for more time samples, with a residual of 1e-15."""
    system, request, _ = duffing
    monkeypatch.setattr(corrector, "on_same_branch", lambda *_: False)
    options = ContinuationOptions(recoveries=())
    with pytest.raises(BranchStoppedError, match=r"solved, but off the branch, residual .*: another branch") as stop:
        list(continue_branch(system, request.excitation, request.window, options))
    assert stop.value.status is Status.OFF_BRANCH
    assert stop.value.error < 1e-9
    assert "time samples" not in str(stop.value)


def test_points_are_handed_out_one_by_one():
    system = blades_and_damper_system(JenkinsBox(2))
    branch = continue_branch(system, Excitation(system.free.row("excitation"), 10.0), (220.0, 240.0))
    first, second = next(branch), next(branch)
    assert first.frequency == pytest.approx(220.0)
    assert second.frequency > first.frequency


def test_a_branch_that_stops_is_met_from_the_other_end(duffing, monkeypatch):
    """The segment from below is cut short beyond the folds' first half; the other one must complete the same curve."""
    system, request, whole = duffing
    cut = len(whole) // 2

    def interrupted(system, excitation, window, options, upwards, resume=()):
        branch = continue_branch(system, excitation, window, options, upwards, resume)
        for i, point in enumerate(branch):
            if upwards and i == cut:
                raise BranchStoppedError(point.frequency, 1.0, Status.STALLED)
            yield point

    monkeypatch.setattr(segments, "continue_branch", interrupted)
    *_, joined = trace(system, request)
    assert joined.complete
    assert not joined.stopped
    assert not joined.after_gap.any()
    assert len(turning_points(joined.frequency)) == 2
    assert joined.peak("mass") == pytest.approx(whole.peak("mass"), rel=1e-3)
    assert joined.frequency[0] == pytest.approx(whole.frequency[0])
    assert joined.frequency[-1] == pytest.approx(request.window[1], rel=0.02)
