"""Harmonic balance of a rig with short faces (small mesh, 36 contacts, residual flexibility) against marching in time.

Most cases have a loss factor of 1 %, ten times the rig's, with viscous damping in both: the motions attract then, and
harmonics above the seventh matter less. At the rig's own 0.1 % one case is made too.
"""

from dataclasses import replace
from functools import cache
from itertools import combinations
from pathlib import Path

import pytest

from updamp.benchmarks.time_integration.rig_against_time import MarchedCase, Problem
from updamp.benchmarks.time_integration.shooting import Plane, shoot
from updamp.fem.finite_element_model import finite_element_model
from updamp.fem.reduced_model import ReducedModel
from updamp.geometry.build_mesh import build_mesh
from updamp.hbm.continuation.branch import BranchPoint
from updamp.hbm.newton.observe import ContactState
from updamp.hbm.time_marching.march import March
from updamp.model.rig_files import load_rig
from updamp.rig.rig import Rig

RIG_FILE = Path(__file__).parents[1] / "data" / "short_faces.toml"
STUCK, SLIP, OPEN = ContactState.STUCK, ContactState.STICK_SLIP, ContactState.SEPARATING

# Case, friction coefficient, how many contacts do what at the peak. With the rig's own friction contacts open before
# they slip.
CASES = {
    "stick": (MarchedCase("IP", 10.0, (425.0, 428.0), 0.01), 0.6, {STUCK: 36}),
    "slip": (MarchedCase("OOP", 30.0, (443.5, 447.5), 0.01), 0.1, {STUCK: 18, SLIP: 18}),
    "slip and separation": (MarchedCase("IP", 17.0, (412.0, 434.0), 0.01), 0.1, {STUCK: 11, SLIP: 11, OPEN: 14}),
    "edges separate": (MarchedCase("OOP", 60.0, (440.0, 450.0), 0.01), 0.6, {STUCK: 28, OPEN: 8}),
}


# Where many contacts stick and others open, the sliders of those that stick may rest at a range of places: motions
# marched from the harmonic balance with 0-3 and with 0-7, and from its points before and after, on one plane and to
# round-off periodic, are not the same.
UNDETERMINED = {"slip and separation"}
RESOLVED = 0.005  # half-widths
STEPS = 256  # a period
MODES = 12  # of each component; the others are in the residual flexibility, which both sides have


@cache
def reduced() -> ReducedModel:
    rig = rig_with(0.6)
    return finite_element_model(build_mesh(rig, "small"), rig).reduced


def rig_with(friction: float) -> Rig:
    return load_rig(RIG_FILE, {"contact.friction_coefficient": friction, "reduction.modes": MODES})


@cache
def followed(name: str) -> tuple[Problem, tuple[BranchPoint, ...]]:
    """A case and its branch of the harmonic balance."""
    case, friction, _ = CASES[name]
    problem = Problem.of(reduced(), rig_with(friction), case)
    return problem, tuple(problem.branch())


@pytest.mark.parametrize(
    "name", ["stick", "slip", "edges separate", pytest.param("slip and separation", marks=pytest.mark.long)]
)
def test_peak_is_that_of_marching_in_time(name):
    """Harmonics 0-7 within 1 % of the amplitude; 0-3 within the change to them, which estimates their error. It is no
    bound: it falls short of it by up to 2 % here.

    0-7 are within 0.005 half-widths too, or no further away than marched motions are from each other.
    """
    problem, branch = followed(name)
    states = CASES[name][2]
    peak = max(branch, key=lambda point: abs(problem.amplitude(point)))
    assert dict(enumerate(problem.states(peak))) == {state: states.get(state, 0) for state in ContactState}
    finer = problem.finer(peak)
    assert finer is not None
    around = branch.index(peak)
    starts = [finer, peak, *(branch[around + i] for i in (-1, 1) if name in UNDETERMINED)]
    marched, *others = (problem.march(peak, start, STEPS) for start in starts)
    for motion in (marched, *others):
        assert motion.misfit < 1e-8
        assert abs(motion.multipliers[0]) < 1  # it is where marching alone would settle
    coarse, fine = problem.difference(peak, marched), problem.difference(finer, marched)
    undetermined = max(problem.apart(one, other) for one, other in combinations((marched, *others), 2))
    assert (undetermined > RESOLVED) is (name in UNDETERMINED)
    assert abs(fine.percent) < 1.0
    assert fine.widths < max(RESOLVED, undetermined)
    assert coarse.widths <= 1.05 * problem.change(peak, finer) + 1e-6


def test_a_march_without_residual_flexibility_is_told_apart():
    """At the frequency of the stuck peak, where with it both agree to round-off."""
    problem, branch = followed("stick")
    point = max(branch, key=lambda point: abs(problem.amplitude(point)))
    free = problem.system.free
    rigid = replace(problem.system, free=replace(free, residual=0 * free.residual))
    march = March.of(rigid, problem.request.excitation, problem.row, point.w, STEPS)
    start = march.start(point.solution.equation.receptance.system, point.x)
    marched = shoot(march, start, Plane(problem.amplitude(point), point.w))
    assert abs(abs(marched.amplitude) / abs(problem.amplitude(point)) - 1) > 0.2
