"""Verdicts on motions of which it is known whether they attract."""

from dataclasses import replace

import numpy as np
import pytest
from support.peers import one_degree_of_freedom, solved

from updamp.hbm.contact.iwan import IwanMicroslip, IwanParameters
from updamp.hbm.contact.springs import CubicParameters, CubicSpring
from updamp.hbm.continuation.curve import CurveRequest, trace
from updamp.hbm.continuation.sweeps import turning_points
from updamp.hbm.problem.elements import ElementGroup
from updamp.hbm.problem.system import Excitation
from updamp.hbm.stability.branch_stability import between_turning_points
from updamp.hbm.stability.stability import stability
from updamp.hbm.time_marching.equilibrium import Equilibrium, MarchError
from updamp.hbm.time_marching.marched_peak import MarchOptions, Verdict, marched_peak

OF_POINTS = (
    "frequency", "displacement", "response", "work_in", "friction_loss", "material_loss", "iterations", "error",
    "active", "after_gap",
)  # fmt: skip


def at(curve, place):
    """One point of a curve, which is its peak then."""
    return replace(curve, **{name: getattr(curve, name)[place : place + 1] for name in OF_POINTS})


def duffing(orders=tuple(range(8))):
    d = solved("a_duffing_1dof")["definition"]
    group = ElementGroup(CubicSpring(), CubicParameters(np.array([d["g"]])), np.array([[0]]))
    system = one_degree_of_freedom(d["c"], group, orders, 128)
    excitation = Excitation(system.free.row("mass"), d["P"])
    window = (0.5 / 2 / np.pi, 2.0 / 2 / np.pi)
    *_, curve = trace(system, CurveRequest("1", excitation, window, ("mass",)))
    assert curve.complete
    return system, excitation, curve


@pytest.fixture(scope="module")
def hardening():
    return duffing()


def test_the_middle_branch_leaves_with_the_growth_of_its_exponent(hardening):
    system, excitation, curve = hardening
    against = np.flatnonzero(between_turning_points(curve.frequency))
    place = int(against[len(against) // 2])
    exact = stability(system, curve.displacement[place], 2 * np.pi * curve.frequency[place]).decisive.real
    assert exact > 0
    found = marched_peak(system, excitation, at(curve, place), "mass", MarchOptions(periods=40))
    assert found.verdict == Verdict.LEAVES
    assert found.growth == pytest.approx(exact, rel=0.05)
    assert f"leaves, growing by {found.growth:.3g} 1/s" in found.sentence


def test_both_outer_branches_stay(hardening):
    system, excitation, curve = hardening
    first, last = turning_points(curve.frequency)[[0, -1]]
    for place in (first - 6, min(last + 6, len(curve) - 1)):
        exact = stability(system, curve.displacement[place], 2 * np.pi * curve.frequency[place]).decisive.real
        assert exact < 0
        found = marched_peak(system, excitation, at(curve, place), "mass")
        assert found.verdict == Verdict.STAYS
        assert found.sentence.startswith("stays: ")
        assert found.reach < 0.05
        assert not found.growth > 0


def test_a_motion_that_too_few_harmonics_made_moves():
    """One harmonic alone, of a spring forty times as stiff: test_stability has it as one that eleven make unstable."""
    d = solved("a_duffing_1dof")["definition"]
    group = ElementGroup(CubicSpring(), CubicParameters(np.array([40 * d["g"]])), np.array([[0]]))
    system = one_degree_of_freedom(d["c"], group, (0, 1), 128)
    excitation = Excitation(system.free.row("mass"), 2.0)
    *_, curve = trace(system, CurveRequest("1", excitation, (0.6 / 2 / np.pi, 0.8 / 2 / np.pi), ("mass",)))
    found = marched_peak(system, excitation, at(curve, len(curve) // 2), "mass")
    assert found.verdict in (Verdict.MOVES, Verdict.LEAVES)
    assert found.reach > 0.1


def test_a_law_that_is_not_written_for_a_march_is_said_not_to_be_checked(hardening):
    system, excitation, curve = hardening
    joint = IwanParameters(np.ones(1), np.full(1, 0.5), np.zeros(1))
    unknown = replace(system, groups=(ElementGroup(IwanMicroslip(), joint, np.array([[0]])),))
    found = marched_peak(unknown, excitation, curve, "mass")
    assert found.verdict == Verdict.NOT_CHECKED
    assert found.sentence == "not checked: the law IwanMicroslip is not written for marching in time"
    assert found.periods == 0


def test_a_march_that_fails_is_not_silent(hardening, monkeypatch):
    system, excitation, curve = hardening

    def fails(*_):
        raise MarchError("no equilibrium today")

    monkeypatch.setattr(Equilibrium, "solve", fails)
    found = marched_peak(system, excitation, curve, "mass")
    assert found.verdict == Verdict.NOT_CHECKED
    assert found.sentence == "not checked: after 0 periods: no equilibrium today"


def test_a_march_that_ends_early_is_judged_by_what_there_is_and_says_so(hardening, monkeypatch):
    system, excitation, curve = hardening
    solve, steps = Equilibrium.solve, []

    def fails_after_eight_periods(*args):
        steps.append(None)
        if len(steps) > 8 * 64:
            raise MarchError("no equilibrium today")
        return solve(*args)

    monkeypatch.setattr(Equilibrium, "solve", fails_after_eight_periods)
    found = marched_peak(system, excitation, at(curve, turning_points(curve.frequency)[0] - 6), "mass")
    assert found.verdict == Verdict.STAYS
    assert found.periods == 8
    assert found.sentence.endswith("(no further: after 8 periods: no equilibrium today)")


def test_a_curve_without_points_is_not_checked(hardening):
    system, excitation, curve = hardening
    nothing = replace(curve, **{name: getattr(curve, name)[:0] for name in OF_POINTS})
    assert marched_peak(system, excitation, nothing, "mass").sentence == "not checked: the curve has no point"


def test_where_nothing_slips_nothing_is_marched(hardening):
    system, excitation, curve = hardening
    found = marched_peak(system, excitation, replace(curve, active=0 * curve.active), "mass")
    assert found.verdict == Verdict.STAYS
    assert found.periods == 0


@pytest.mark.parametrize("wrong", [{"steps": 8}, {"periods": 3}, {"change": 1.5}, {"linear": 0.0}])
def test_options_out_of_range_are_refused_by_name(wrong):
    with pytest.raises(ValueError, match=f"{next(iter(wrong))} = "):
        MarchOptions(**wrong)
