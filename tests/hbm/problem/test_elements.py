"""Forces of a group of elements, whatever the number of harmonics."""

from dataclasses import replace

import jax.numpy as jnp
import numpy as np
import pytest
from support.peers import friction, one_degree_of_freedom

from updamp.hbm.contact.between_points import BetweenPoints
from updamp.hbm.contact.coulomb_circle import CoulombCircle
from updamp.hbm.contact.iwan import IwanMicroslip, IwanParameters
from updamp.hbm.contact.jenkins import Jenkins, JenkinsParameters
from updamp.hbm.contact.jenkins_box import JenkinsBox
from updamp.hbm.contact.jenkins_box_sampled import SampledJenkinsBox
from updamp.hbm.contact.law import ContactLaw
from updamp.hbm.contact.modified.film import ViscousFilm
from updamp.hbm.contact.modified.modified_law import with_entries
from updamp.hbm.contact.power_law_damper import PowerLawDamper, PowerLawParameters
from updamp.hbm.contact.springs import CubicParameters, CubicSpring, UnilateralParameters, UnilateralSpring
from updamp.hbm.contact.stops import Clearance, Stop
from updamp.hbm.contact.threshold_damper import ThresholdDamper, ThresholdDamperParameters
from updamp.hbm.continuation.curve import CurveRequest, whole_curve
from updamp.hbm.harmonics import Harmonics
from updamp.hbm.problem.elements import ElementGroup, element_forces, force_only
from updamp.hbm.problem.linear_model import from_matrices
from updamp.hbm.problem.receptance import Receptance
from updamp.hbm.problem.system import Excitation, NonlinearSystem

ONE = Harmonics((1,))


@pytest.mark.parametrize(
    ("law", "highest"),
    [(CoulombCircle(), 27), (CoulombCircle(), 28), (JenkinsBox(2), 42)],
    ids=["circle 0-27", "circle 0-28", "box 0-42"],
)
def test_slipping_elements_have_forces_and_tangents_however_many_the_harmonics(law: ContactLaw, highest: int) -> None:
    """Two elements that slip: forces as without tangents, and tangents as the difference of forces."""
    harmonics, n_time = Harmonics(tuple(range(highest + 1))), 4 * highest
    group = ElementGroup(law, friction(2, 0.4, 3e4, 4e4, np.array([4.0, 6.0])), np.arange(6).reshape(2, 3))
    x = np.zeros((2, 3, harmonics.n_coefficients))
    x[:, :2, harmonics.slices[1].start] = 4e-4
    x[:, 0, harmonics.slices[2].start] = 1e-4
    assert len(group.may_slip_or_separate(x, harmonics, n_time)) == 2
    forces = element_forces(group, x, 100.0, harmonics, n_time)
    np.testing.assert_allclose(forces.force, force_only(group, x, 100.0, harmonics, n_time), rtol=1e-10, atol=1e-10)
    step = np.zeros_like(x)
    step[:, 1, harmonics.slices[1].start] = 1e-9
    ahead, back = (force_only(group, x + sign * step, 100.0, harmonics, n_time) for sign in (1, -1))
    slope = forces.tangent[:, :, :, 1, harmonics.slices[1].start]
    np.testing.assert_allclose((ahead - back) / 2e-9, slope, atol=1e-4 * 3e4)


@pytest.mark.parametrize(
    ("entries", "said"),
    [
        ({"kn": np.full(1, -1.0)}, r"kn = \[-1.\] must "),
        ({"kt": np.zeros(1)}, r"kt = \[0.\] must be positive"),
        ({"mu": np.full(1, -0.4)}, r"mu = \[-0.4\] must not be negative"),
        ({"n0": np.full(1, np.nan)}, "n0 = .*not a number"),
        ({"gap": np.zeros(2)}, r"gap has shape \(2,\); one entry for each of 1 elements"),
        ({"mu": 0.4}, r"mu has shape \(\)"),
    ],
)
@pytest.mark.parametrize("law", [JenkinsBox(), SampledJenkinsBox(), CoulombCircle()])
def test_parameters_that_cannot_be_are_refused(law: ContactLaw, entries: dict[str, object], said: str) -> None:
    parameters = friction(1, 0.4, 1.0, 1.0, np.ones(1))._replace(**entries)
    with pytest.raises(ValueError, match=said):
        ElementGroup(law, parameters, np.arange(3)[None])


@pytest.mark.parametrize(
    ("law", "parameters", "said"),
    [
        (PowerLawDamper(1.0), PowerLawParameters(np.ones(1), np.full(1, 0.3)), r"exponent = \[0.3\] must be 1 or more"),
        (IwanMicroslip(), IwanParameters(*np.array([[1.0], [-1.5], [0.0]])), r"exponent = \[-1.5\] must be above -1"),
        (PowerLawDamper(1.0), PowerLawParameters(-np.ones(1), np.ones(1)), r"force = \[-1.\] must be 0 or more"),
        (IwanMicroslip(), IwanParameters(*np.array([[1.0], [0.5], [-1.0]])), r"nearness = \[-1.\] must be 0 or more"),
        (IwanMicroslip(), IwanParameters(*np.array([[-1.0], [0.5], [0.0]])), r"lost = \[-1.\] must be 0 or more"),
        (Clearance(), UnilateralParameters(np.ones(1), -np.ones(1)), r"gap = \[-1.\] must be 0 or more"),
        (ThresholdDamper(), ThresholdDamperParameters(np.ones(1), np.zeros(1)), r"threshold = \[0.\] must be above 0"),
        (Jenkins(cycles=0), JenkinsParameters(np.ones(1), np.ones(1)), "Jenkins: cycles = 0; a whole number of 1"),
        (
            CubicSpring(),
            JenkinsParameters(np.ones(1), np.ones(1)),
            "its parameters are CubicParameters; coefficient is",
        ),
        (CubicSpring, CubicParameters(np.ones(1)), "CubicSpring is a class"),
    ],
)
def test_what_a_law_cannot_be_given_is_refused(law: ContactLaw, parameters: tuple[np.ndarray, ...], said: str) -> None:
    with pytest.raises(ValueError, match=said):
        ElementGroup(law, parameters, np.array([[0]]))


@pytest.mark.parametrize(
    ("law", "coefficient", "error", "said"),
    [
        (
            CubicSpring(),
            np.ones((2, 1)),
            ValueError,
            r"coefficient has shape \(2, 1\); \(2,\) is needed, one number an",
        ),
        (CubicSpring(), [[1.0], [2.0]], ValueError, r"coefficient has shape \(2, 1\); \(2,\) is needed"),
        (CubicSpring(), np.array([1j, 1.0]), ValueError, r"coefficient = \[.*\] is complex; a real number"),
        (CubicSpring(), np.array([np.inf, 1.0]), ValueError, r"coefficient = \[inf  1.\] must be finite: give a large"),
        (CubicSpring(), np.array(["1", "2"]), TypeError, r"coefficient = \['1' '2'\]: no numbers"),
        (CubicSpring(), ["a", 1.0], TypeError, r"coefficient = \['a', 1.0\]: real numbers are needed"),
        (CubicSpring(), [1j, 1.0], TypeError, r"coefficient = \[1j, 1.0\]: real numbers are needed"),
        ("cubic", np.ones(2), TypeError, "law = 'cubic': a contact law is needed, such as CubicSpring"),
    ],
)
def test_parameters_of_a_wrong_shape_or_kind_are_named(
    law: ContactLaw, coefficient: np.ndarray, error: type[Exception], said: str
) -> None:
    """They were accepted, and a solution failed in NumPy; a column among numba's laws was read beyond its end."""
    with pytest.raises(error, match=said):
        ElementGroup(law, CubicParameters(coefficient), np.array([[0], [1]]))  # type: ignore[arg-type]


@pytest.mark.parametrize("law", [JenkinsBox(), SampledJenkinsBox(), CoulombCircle(), ViscousFilm(JenkinsBox())])
def test_a_pair_at_rest_is_a_pair(law: ContactLaw) -> None:
    parameters = with_entries(friction(1, 0.4, 1.0, 1.0, np.ones(1)), viscosity=np.zeros(1))
    for t0 in (np.zeros(1), np.full((1, 1), 0.3), np.zeros((1, 3))):
        with pytest.raises(ValueError, match=r"t0 has shape .*; \(1, 2\) is needed, two numbers an element"):
            ElementGroup(law, parameters._replace(t0=t0), np.arange(3)[None])
    with pytest.raises(ValueError, match=r"mu has shape \(1, 1\); \(1,\) is needed"):
        ElementGroup(law, parameters._replace(mu=np.ones((1, 1))), np.arange(3)[None])
    with pytest.raises(ValueError, match=r"n0 = \[inf\] must be finite"):
        ElementGroup(law, parameters._replace(n0=np.full(1, np.inf)), np.arange(3)[None])
    ElementGroup(law, parameters._replace(mu=np.full(1, np.inf)), np.arange(3)[None])


def test_what_is_never_reached_may_be_infinite_and_other_laws_have_parameters_of_any_shape() -> None:
    row, never = np.array([[0]]), np.array([np.inf])
    ElementGroup(Jenkins(), JenkinsParameters(np.ones(1), never), row)
    ElementGroup(Jenkins(), JenkinsParameters(jnp.ones(1), [1.0]), row)  # type: ignore[arg-type]
    ElementGroup(Stop(), UnilateralParameters(np.ones(1), never), row)
    with pytest.raises(ValueError, match=r"gap = \[-inf\] must be finite"):
        ElementGroup(Stop(), UnilateralParameters(np.ones(1), -never), row)
    ElementGroup(OwnSpring(), CubicParameters(np.ones((1, 3))), row)


class OwnSpring(CubicSpring):
    """Of a user, with three coefficients"""

    def force(self, displacement, velocity, parameters):  # noqa: ARG002
        return (parameters.coefficient * displacement ** jnp.arange(1, 4)).sum(axis=1, keepdims=True)

    def reference_stiffness(self, parameters):
        return parameters.coefficient[:1]


def test_a_power_law_needs_a_velocity_at_which_its_force_is_stated() -> None:
    with pytest.raises(ValueError, match="reference = 0 m/s must be positive"):
        PowerLawDamper(0.0)


@pytest.mark.parametrize(
    ("row", "force", "said"),
    [(-1, 1.0, "row = -1: a row of the linear model"), (0.5, 1.0, "row = 0.5"), (0, 1j, "force = 1j: an amplitude is")],
)
def test_an_excitation_that_cannot_be_is_refused(row: int, force: float, said: str) -> None:
    """Row -1 was the last one."""
    with pytest.raises(ValueError, match=said):
        Excitation(row, force)


def test_lists_and_whole_floats_will_do_for_parameters_rows_and_samples() -> None:
    group = ElementGroup(CubicSpring(), CubicParameters([1.0]), [[0.0]])  # type: ignore[arg-type]
    system = one_degree_of_freedom(0.1, group, (0, 1), 64)
    same = ElementGroup(CubicSpring(), CubicParameters(np.ones(1)), np.array([[0]]))
    assert replace(system, time_samples=64.0).time_samples == 64  # type: ignore[arg-type]
    x = np.ones((1, 1, 3))
    found, wanted = (force_only(each, x, 1.0, system.harmonics, 64) for each in (group, same))
    np.testing.assert_array_equal(found, wanted)
    with pytest.raises(ValueError, match=r"time_samples = 64.5: a whole number"):
        replace(system, time_samples=64.5)  # type: ignore[arg-type]


@pytest.mark.parametrize(
    ("rows", "said"),
    [
        ([[3]], "an element acts on row 3; the model's relative displacements are rows 0 to 0"),
        ([[-1]], "an element acts on row -1;"),
        ([[0], [0]], "2 elements act on row 0;"),
        ([[0.5]], r"rows = \[\[0.5\]\]: whole numbers"),
    ],
)
def test_rows_that_are_not_there_or_taken_are_named(rows: list[list[int]], said: str) -> None:
    with pytest.raises(ValueError, match=said):
        one_degree_of_freedom(0.1, _cubic(rows), (0, 1), 64)


def test_a_row_without_an_element_is_named() -> None:
    linear = from_matrices(np.eye(2), np.eye(2), np.eye(2), np.eye(2))
    with pytest.raises(ValueError, match=r"no element acts on row 1; .* leave the row out"):
        NonlinearSystem(linear, (_cubic([[0]]),), Harmonics((1, 3)), 64)


def _cubic(rows: list[list[int]]) -> ElementGroup:
    return ElementGroup(CubicSpring(), CubicParameters(np.ones(len(rows))), rows)  # type: ignore[arg-type]


def test_a_row_or_window_that_is_not_there_is_named_by_a_curve() -> None:
    system = one_degree_of_freedom(0.1, _cubic([[0]]), (1, 3), 64)
    request = CurveRequest("1", Excitation(99, 1.0), (0.1, 0.3), ("mass",))
    for each in (system, replace(system, as_a_whole=True)):
        with pytest.raises(ValueError, match="row = 99: the model has rows 0 to 1; 1 is point 'mass'"):
            whole_curve(each, request)
    with pytest.raises(ValueError, match=r"window = \(0.1, 0.2, 0.3\): two frequencies"):
        replace(request, window=(0.1, 0.2, 0.3))  # type: ignore[arg-type]


def test_a_free_motion_has_no_mean_that_could_be_held() -> None:
    group = ElementGroup(CubicSpring(), CubicParameters(np.ones(1)), np.array([[0]]))
    linear = from_matrices(np.eye(2), 0 * np.eye(2), np.array([[1.0, -1.0], [-1.0, 1.0]]), np.array([[1.0, -1.0]]))
    with pytest.raises(ValueError, match=r"harmonic 0: a motion of the structure .* has no stiffness"):
        _ = NonlinearSystem(linear, (group,), Harmonics((0, 1)), 64).stuck
    without = NonlinearSystem(linear, (group,), Harmonics((1, 3)), 64)
    assert len(without.stuck.omega_squared) == 2
    assert set(Receptance(without, 1.5).modal) == {1, 3}, "a static one was divided by zero"


def test_a_negative_stiffness_is_told_as_such() -> None:
    group = ElementGroup(CubicSpring(), CubicParameters(np.ones(1)), np.array([[0]]))
    linear = from_matrices(np.eye(1), np.eye(1), -np.eye(1), np.eye(1))
    with pytest.raises(ValueError, match=r"harmonic 0: .* has a negative stiffness, omega\^2 = -1 rad"):
        _ = NonlinearSystem(linear, (group,), Harmonics((0, 1)), 64).stuck


def test_an_element_that_sees_no_motion_is_refused() -> None:
    """It was accepted, and did nothing. One that moves in some of its directions is not."""
    with pytest.raises(ValueError, match=r"relative: row 0 of it is all zeros, where a CubicSpring acts"):
        NonlinearSystem(from_matrices(np.eye(1), np.eye(1), np.eye(1), np.zeros((1, 1))), (_cubic([[0]]),), ONE, 64)
    box = ElementGroup(JenkinsBox(), friction(1, 0.4, 1.0, 1.0, np.ones(1)), np.arange(3)[None])
    NonlinearSystem(from_matrices(np.eye(1), np.eye(1), np.eye(1), np.eye(3, 1)), (box,), ONE, 64)
    with pytest.raises(ValueError, match=r"rows \[0, 1, 2\] of it are all zeros, where a JenkinsBox acts"):
        NonlinearSystem(from_matrices(np.eye(1), np.eye(1), np.eye(1), np.zeros((3, 1))), (box,), ONE, 64)


@pytest.mark.parametrize("law", [UnilateralSpring(), Stop(), BetweenPoints(Stop())])
def test_what_pushes_one_way_alone_needs_harmonic_0(law: ContactLaw) -> None:
    """Without it the peak of an oscillator with a stop was 4 % off in frequency, and nothing was said."""
    free = from_matrices(np.eye(2), 0.02 * np.eye(2), np.eye(2), np.eye(law.directions, 2))
    rows = np.arange(law.directions)[None]

    def system(harmonics: tuple[int, ...], stiffness: float = 1.0, gap: float = 0.1, **given: bool) -> NonlinearSystem:
        group = ElementGroup(law, UnilateralParameters(np.array([stiffness]), np.array([gap])), rows)
        return NonlinearSystem(free, (group,), Harmonics(harmonics), 64, **given)

    with pytest.warns(UserWarning, match=rf"harmonics = \(1, 3\): the {type(law).__name__} on row 0 .* mean_held=True"):
        system((1, 3))
    assert not system((0, 1, 3)).mean_held
    assert replace(system((1, 3), mean_held=True), harmonics=ONE).mean_held
    system((1, 3), stiffness=0.0)
    system((1, 3), gap=-0.1)  # pressed at rest, as preloaded contacts are


@pytest.mark.parametrize("law", [Clearance(), BetweenPoints(Clearance())])
def test_what_pushes_both_ways_needs_no_harmonic_0(law: ContactLaw) -> None:
    free = from_matrices(np.eye(2), 0.02 * np.eye(2), np.eye(2), np.eye(law.directions, 2))
    group = ElementGroup(law, UnilateralParameters(np.ones(1), np.full(1, 0.1)), np.arange(law.directions)[None])
    NonlinearSystem(free, (group,), ONE, 64)


def test_a_motion_without_mass_is_refused() -> None:
    with pytest.raises(ValueError, match="M is not positive definite"):
        from_matrices(np.diag([1.0, 0.0]), np.eye(2), np.eye(2), np.eye(2))


@pytest.mark.parametrize("rows", [np.arange(3), np.arange(3)[:, None]])
def test_rows_of_another_shape_are_refused(rows: np.ndarray) -> None:
    with pytest.raises(ValueError, match=r"\(n_elements, 3\) is needed"):
        ElementGroup(JenkinsBox(), friction(1, 0.4, 1.0, 1.0, np.ones(1)), rows)


@pytest.mark.parametrize("law", [JenkinsBox(), SampledJenkinsBox()])
def test_a_box_needs_normal_stiffness(law: ContactLaw) -> None:
    """Without it had never slipped, at any force."""
    with pytest.raises(ValueError, match=r"kn = \[0.\] must be positive; it may be small"):
        ElementGroup(law, friction(1, 0.4, 1.0, 0.0, np.ones(1)), np.arange(3)[None])


def test_a_circle_under_a_constant_load_is_a_jenkins_element() -> None:
    """In one direction; without normal stiffness at all, where the box may have 1e-12 of kt (below)."""
    harmonics, x = Harmonics((0, 1, 2, 3)), 2 * np.random.default_rng(0).normal(size=(1, 3, 7))
    x[:, 1] = 0
    circle = ElementGroup(CoulombCircle(), friction(1, 0.4, 1.0, 0.0, np.ones(1)), np.arange(3)[None])
    one = ElementGroup(Jenkins(), JenkinsParameters(np.ones(1), np.full(1, 0.4)), np.zeros((1, 1), dtype=np.int64))
    wanted = force_only(one, x[:, :1], 1.0, harmonics, 128)
    np.testing.assert_allclose(force_only(circle, x, 1.0, harmonics, 128)[:, :1], wanted, atol=1e-12)


def test_a_load_that_hardly_varies_is_a_constant_one() -> None:
    """What `kn` may be in place of 0: with 1e-12 of kt the box is Jenkins' element."""
    harmonics, x = Harmonics((0, 1, 2, 3)), 2 * np.random.default_rng(0).normal(size=(1, 3, 7))
    box = ElementGroup(SampledJenkinsBox(), friction(1, 0.4, 1.0, 1e-12, np.ones(1)), np.arange(3)[None])
    one = ElementGroup(Jenkins(), JenkinsParameters(np.ones(1), np.full(1, 0.4)), np.zeros((1, 1), dtype=np.int64))
    wanted = force_only(one, x[:, :1], 1.0, harmonics, 128)
    np.testing.assert_allclose(force_only(box, x, 1.0, harmonics, 128)[:, :1], wanted, atol=1e-11)


def test_a_system_needs_elements_and_samples_enough() -> None:
    group = ElementGroup(CubicSpring(), CubicParameters(np.zeros(1)), np.array([[0]]))
    free = one_degree_of_freedom(0.1, group, (0, 1), 8).free
    with pytest.raises(ValueError, match="no elements"):
        NonlinearSystem(free, (), Harmonics((0, 1)), 8)
    with pytest.raises(ValueError, match="time_samples = 6: harmonic 3 needs more than 6"):
        NonlinearSystem(free, (group,), Harmonics((1, 3)), 6)
