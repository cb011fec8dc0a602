"""The element and the system against problems solved by tmdsimpy, pyHarm and NLvib, to 1e-8."""

import numpy as np
import pytest
from support.peers import blades_and_damper_system, friction, one_degree_of_freedom, solved

from updamp.hbm.contact.coulomb_circle import CoulombCircle
from updamp.hbm.contact.jenkins import Jenkins, JenkinsParameters
from updamp.hbm.contact.jenkins_box_sampled import SampledJenkinsBox
from updamp.hbm.contact.law import SEPARATED
from updamp.hbm.contact.springs import CubicParameters, CubicSpring
from updamp.hbm.continuation.continuation import first_point
from updamp.hbm.harmonics import Harmonics
from updamp.hbm.newton.newton import NewtonOptions
from updamp.hbm.newton.observe import ContactState, contact_states, response
from updamp.hbm.problem.elements import ElementGroup, force_only, over_period
from updamp.hbm.problem.system import Excitation

LAWS = {"box": SampledJenkinsBox, "circle": CoulombCircle}
TIGHT = NewtonOptions(tolerance=1e-12)
FORTY = [c for c in solved("c_blades_damper_20")["own_solver_results_cycles3"] if c["F"] == 40]
ROW = np.array([[0]])


@pytest.mark.parametrize(
    "case", solved("c0_element_3d_jenkins")["cases"], ids=lambda c: f"{c['law']}-{c['normal_amplitude']}"
)
def test_one_element_under_prescribed_motion(case):
    """c0: stick, slip and separation of one element; three cycles, 256 samples."""
    d = solved("c0_element_3d_jenkins")["definition"]
    group = ElementGroup(
        LAWS[case["law"]](3), friction(1, d["mu"], d["kt"], d["kn"], np.array([d["N0"]])), np.arange(3)[None]
    )
    force = force_only(group, np.array(case["U"]).T[None], 1.0, Harmonics((0, 1, 2, 3)), d["Nt"])[0].T
    total = force.copy()
    total[0, 2] += d["N0"]
    np.testing.assert_allclose(total, case["F_t1_t2_Ntotal"], rtol=0, atol=1e-14)


def _amplitude(system, w, force, point):
    excitation = Excitation(
        system.free.row("excitation") if "excitation" in system.free.points else system.free.row("mass"), force
    )
    solution = first_point(system, excitation, w, TIGHT)
    y = response(solution.equation, excitation, np.array([system.free.row(point)]))[0]
    return system.harmonics.amplitude(y, 1), solution, y


@pytest.mark.parametrize(
    "case",
    solved("c_blades_damper_20")["own_solver_results_cycles3"],
    ids=lambda c: f"{c['law']}-{c['F']:g}N-{c['Nt']}",
)
def test_two_blades_and_a_damper_with_20_contacts(case):
    """c: all listed points, both laws, three cycles; stick, slip and separation."""
    system = blades_and_damper_system(LAWS[case["law"]](3), n_time=case["Nt"])
    for row in case["rows"]:
        amplitude, solution, _ = _amplitude(system, 2 * np.pi * row["f_Hz"], case["F"], "tip")
        assert solution.converged
        assert abs(amplitude) == pytest.approx(row["tip_h1"], rel=1e-8), f"{row['f_Hz']} Hz"


@pytest.mark.parametrize("force", [10, 40])
def test_two_blades_and_a_damper_against_tmdsimpy(force):
    """The peer's own values: two cycles of the box law, 128 samples."""
    system = blades_and_damper_system(SampledJenkinsBox(2))
    for row in solved("c_blades_damper_20")[f"tmdsimpy_box_2cycles_F{force}_Nt128"]:
        amplitude, _, _ = _amplitude(system, 2 * np.pi * row["f_Hz"], float(force), "tip")
        assert abs(amplitude) == pytest.approx(row["tip_h1"], rel=1e-8), f"{row['f_Hz']} Hz"


def test_box_law_settles_in_two_cycles_and_the_circle_does_not():
    two, three = (
        _amplitude(blades_and_damper_system(SampledJenkinsBox(c)), 2 * np.pi * 232, 40.0, "tip")[0] for c in (2, 3)
    )
    assert abs(two - three) < 1e-12 * abs(three)
    two, three = (
        _amplitude(blades_and_damper_system(CoulombCircle(c)), 2 * np.pi * 232, 40.0, "tip")[0] for c in (2, 3)
    )
    assert 1e-5 < abs(two - three) / abs(three) < 3e-4


@pytest.mark.parametrize("case", FORTY, ids=lambda c: f"{c['law']}-{c['Nt']}")
def test_contact_states(case):
    """The share of separated samples of the solved problem; where it has slip there is some."""
    law = LAWS[case["law"]](3)
    system = blades_and_damper_system(law, n_time=case["Nt"])
    for row in case["rows"]:
        _, solution, _ = _amplitude(system, 2 * np.pi * row["f_Hz"], case["F"], "tip")
        states = contact_states(system, solution.x, solution.w, case["Nt"])
        assert (ContactState.SEPARATING in states) == (row["sep"] > 0)
        if row["slip"] + row["sep"] > 0:
            assert (states != ContactState.STUCK).any()
        group = system.groups[0]
        _, state = over_period(group, law.state, solution.x[group.rows], solution.w, system.harmonics, case["Nt"])
        assert np.mean(state == SEPARATED) == pytest.approx(row["sep"], abs=1e-12)


@pytest.mark.parametrize("key", ["H3_Nt256", "H7_Nt1024"])
def test_jenkins_oscillator(key):
    """b: one degree of freedom with a constant slip force; values of three codes."""
    d = solved("b_jenkins_1dof")["definition"]
    harmonics, n_time = {"H3_Nt256": ((0, 1, 2, 3), 256), "H7_Nt1024": (tuple(range(8)), 1024)}[key]
    group = ElementGroup(Jenkins(), JenkinsParameters(np.array([d["kt"]]), np.array([d["muN"]])), ROW)
    system = one_degree_of_freedom(d["c"], group, harmonics, n_time)
    for point in solved("b_jenkins_1dof")[key]["points"]:
        _, solution, y = _amplitude(system, point["omega"], d["P"], "mass")
        assert solution.converged
        np.testing.assert_allclose(y, point["coeffs"], rtol=0, atol=1e-9)


def test_duffing_oscillator():
    """a: one degree of freedom with a cubic spring."""
    d = solved("a_duffing_1dof")["definition"]
    group = ElementGroup(CubicSpring(), CubicParameters(np.array([d["g"]])), ROW)
    system = one_degree_of_freedom(d["c"], group, tuple(range(8)), d["Nt_tmdsimpy"])
    for point in solved("a_duffing_1dof")["fixed_frequency_points"]:
        _, solution, y = _amplitude(system, point["omega"], d["P"], "mass")
        assert solution.converged
        np.testing.assert_allclose(y, point["coeffs_c0_c1_s1_c2_s2"], rtol=0, atol=1e-9)
