"""Branch switching at kinks: folds without a rounded top, orientation, and what lies on the branch already."""

from dataclasses import replace

import numpy as np
import pytest
from support.peers import (
    blades_and_damper,
    blades_and_damper_system,
    friction,
    one_degree_of_freedom,
    solved,
)

from updamp.hbm.contact.jenkins_box import JenkinsBox
from updamp.hbm.contact.springs import CubicParameters, CubicSpring, UnilateralParameters, UnilateralSpring
from updamp.hbm.continuation.continuation import BranchStoppedError, ContinuationOptions, continue_branch, first_point
from updamp.hbm.continuation.recovery.lowering_step import LoweringStep
from updamp.hbm.continuation.recovery.switch_branch import SwitchBranch, lies_on_last_points
from updamp.hbm.continuation.retracing import TracedBranch
from updamp.hbm.harmonics import Harmonics
from updamp.hbm.newton.active_forces import DirectForces, KrylovForces, ModalForces
from updamp.hbm.newton.equation import evaluate
from updamp.hbm.newton.jacobian import factorise
from updamp.hbm.newton.newton import NewtonOptions, solve
from updamp.hbm.problem.elements import ElementGroup
from updamp.hbm.problem.system import Excitation, NonlinearSystem

ROW = np.array([[0]])
GAP = 1.0
EXACT = (SwitchBranch(),)
WINDOW = (1.2 / 2 / np.pi, 1.6 / 2 / np.pi)


@pytest.fixture(scope="module", params=[10.0, 100.0, 1e4])
def against_a_stop(request):
    """One degree of freedom of 1 rad/s above its resonance, and a stiff stop seen at eight instants: met coming down
    in frequency, it sends the branch back up."""
    stiffness = request.param
    stop = ElementGroup(UnilateralSpring(), UnilateralParameters(np.array([stiffness]), np.array([GAP])), ROW)
    system = one_degree_of_freedom(0.01, stop, (1,), 8, mean_held=True)
    force = GAP * abs(1 - 1.35**2)  # touches at 1.35 rad/s
    return system, Excitation(system.free.row("mass"), force)


def followed(system, excitation, points=60, **steps):
    found = []
    options = ContinuationOptions(**{"max_points": points, "recoveries": EXACT, **steps})
    try:
        for point in continue_branch(system, excitation, WINDOW, options, upwards=False):
            found.append(point)
    except BranchStoppedError as stop:
        return found, stop
    return found, None


def test_branch_is_continued_through_a_fold_without_a_rounded_top(against_a_stop):
    found, stop = followed(*against_a_stop)
    assert stop is None
    w, size = np.array([(p.w, np.linalg.norm(p.x)) for p in found]).T
    turn = int(np.argmin(w))
    assert w[turn] == pytest.approx(1.35, abs=0.01)
    assert 0 < turn < len(w) - 1
    assert (np.diff(w[turn + 1 :]) > 0).all(), "beyond the kink the branch goes up again"
    assert (size[turn + 1 :] > 0.99 * GAP).all(), "along the stop"
    assert len({p.orientation for p in found}) == 1


@pytest.mark.parametrize("smallest_step", [0.005, 0.01, 0.013, 0.02, 0.04])
def test_branch_switching_does_not_depend_on_how_small_the_smallest_step_is(against_a_stop, smallest_step):
    """The kink lies anywhere within the smallest step ahead of the last point."""
    found, stop = followed(*against_a_stop, smallest_step=smallest_step)
    assert stop is None
    assert found[-1].w > 1.4, "beyond the kink the branch goes up again"


def test_without_the_far_sides_tangent_it_stops_there(against_a_stop):
    found, stop = followed(*against_a_stop, recoveries=(LoweringStep(),))
    assert stop is not None
    assert found[-1].w == pytest.approx(1.35, abs=0.01)


def test_points_on_the_last_part_are_told_from_those_beyond_the_kink(against_a_stop):
    """Points between those found on the way down, solved anew, and those beyond the kink, close to it."""
    system, excitation = against_a_stop
    found, _ = followed(system, excitation)
    turn = int(np.argmin([p.w for p in found]))
    down, up = found[:turn], found[turn : turn + 4]
    a, b = down[-2:]
    between = solve(system, excitation, (a.x + b.x) / 2, (a.w + b.w) / 2)
    assert between.converged
    assert lies_on_last_points(down, between)
    assert not any(lies_on_last_points(down, point.solution) for point in up)


def duffing():
    d = solved("a_duffing_1dof")["definition"]
    group = ElementGroup(CubicSpring(), CubicParameters(np.array([d["g"]])), ROW)
    system = one_degree_of_freedom(d["c"], group, tuple(range(4)), 64)
    return system, Excitation(system.free.row("mass"), d["P"])


def test_orientation_stays_through_folds():
    points = list(continue_branch(*duffing(), (0.5 / 2 / np.pi, 2.0 / 2 / np.pi)))
    backwards = [p for p in points if p.tangent_w < 0]
    assert 5 < len(backwards) < len(points) - 5
    assert {p.orientation for p in points} == {1.0}


def test_a_branch_traced_back_is_recognised_by_its_orientation():
    """The same place, reached in either direction, is on what was traced; back with the orientation of the first time,
    it is not."""
    points = list(continue_branch(*duffing(), (0.5 / 2 / np.pi, 2.0 / 2 / np.pi)))
    traced, again = TracedBranch.through(points[:20]), points[15]
    back = replace(again, tangent_x=-again.tangent_x, tangent_w=-again.tangent_w)
    assert traced.contains(back)
    assert traced.contains(again)
    other_side = replace(again, tangent_x=-again.tangent_x)  # of a sharp fold
    assert not traced.contains(other_side)


@pytest.mark.parametrize("solver", [DirectForces, KrylovForces, ModalForces])
def test_sign_of_the_determinant(solver):
    """Against that of J column by column, at points of either sign: J itself and J reflected in one direction."""
    system = blades_and_damper_system(JenkinsBox(2))
    excitation = Excitation(system.free.row("excitation"), 40.0)
    solution = first_point(system, excitation, 2 * np.pi * 232.0)
    rng = np.random.default_rng(0)
    signs = set()
    for _ in range(6):
        x = solution.x + rng.normal(size=solution.x.shape) * np.abs(solution.x).max()
        equation = evaluate(system, excitation, x, solution.w)
        tangents = tuple(rng.normal() * t for t in equation.departure.tangents)
        departure = replace(equation.departure, tangents=tangents)
        jacobian = factorise(equation.receptance, departure)
        rows = jacobian.rows
        forces = solver(equation.receptance, departure, rows)
        inverse = np.column_stack(
            [jacobian.solve(e.reshape(x.shape)).ravel() for e in np.eye(x.size)]  # J^-1 has the sign of J
        )
        assert forces.determinant_sign == np.linalg.slogdet(inverse)[0]
        signs.add(forces.determinant_sign)
    assert signs == {1.0, -1.0}, "both signs are met"


def test_undamped_steps_cross_a_kink_at_which_damped_ones_stay(against_a_stop):
    """From this side the full step rises before it falls."""
    system, excitation = against_a_stop
    found, _ = followed(system, excitation)
    beyond = max(found, key=lambda p: np.linalg.norm(p.x))
    start, w = 0.9 * beyond.x / np.linalg.norm(beyond.x), beyond.w
    full = solve(system, excitation, start, w, NewtonOptions(damped=False))
    assert full.converged
    assert max(full.errors) >= full.errors[0]


@pytest.mark.parametrize("round_off", [pytest.param(-1e-12, marks=pytest.mark.long), 1e-12])
def test_kinks_closer_than_a_ten_thousandth_are_passed_one_by_one(round_off):
    """20 stiff contacts. With a smallest step of 1e-4 the branch jumped at 241.6 Hz and stopped at 249.9 Hz, with one
    change of round-off and not with another."""
    linear, given = blades_and_damper()
    n = len(given.n0)
    stiff = friction(n, 0.5056, 134.8 * float(given.kt[0]) * (1 + round_off), 2.225 * float(given.kn[0]), given.n0)
    group = ElementGroup(JenkinsBox(2), stiff, np.arange(3 * n).reshape(n, 3))
    system = NonlinearSystem(linear, (group,), Harmonics((0, 1, 2, 3)), 64)
    excitation = Excitation(system.free.row("excitation"), 107.6)
    points = list(continue_branch(system, excitation, (200.0, 252.0)))
    assert points[-1].frequency > 252.0
    assert not any(point.after_gap for point in points)
