"""The mirror image of a problem is found from what its excitation moves, and taken only where it is one."""

from dataclasses import replace

import numpy as np
import pytest
from support.three_masses import IMAGE, SIGN, WINDOW, three_masses

from updamp.hbm.contact.springs import CubicParameters, CubicSpring, UnilateralParameters
from updamp.hbm.contact.stops import Stop
from updamp.hbm.continuation.curve import CurveRequest, whole_curve
from updamp.hbm.harmonics import Harmonics
from updamp.hbm.problem.elements import ElementGroup
from updamp.hbm.problem.linear_model import from_matrices
from updamp.hbm.problem.system import Excitation, NonlinearSystem


def unstated(**given) -> NonlinearSystem:
    """Without a word of the symmetry."""
    return three_masses(mirror=None, **given)


def half_of(system: NonlinearSystem, point: str = "drive"):
    return system.half_driven_at(system.free.row(point))


def test_contacts_and_their_images_are_found() -> None:
    half, mirror = half_of(unstated())
    np.testing.assert_array_equal(mirror.image, IMAGE)
    np.testing.assert_array_equal(mirror.sign, SIGN)
    assert len(half.free.omega_squared) == 5
    assert half.groups[0].copies.tolist() == [2.0, 1.0]


@pytest.mark.parametrize("last_digit", [0, 1, 2])
def test_a_curve_does_not_depend_on_round_off_where_motions_begin_that_break_the_symmetry(last_digit: int) -> None:
    """Solved as a whole, it was followed to the end in two of three such draws."""

    def traced(system: NonlinearSystem):
        return whole_curve(system, CurveRequest("1", Excitation(system.free.row("drive"), 0.3), WINDOW, ("drive",)))

    curve, expected = traced(unstated(last_digit=last_digit)), traced(unstated())
    assert curve.complete
    assert curve.peak("drive") == pytest.approx(expected.peak("drive"), rel=1e-4)
    assert curve.displacement.shape[1:] == (9, 7)


def test_what_is_not_symmetric_is_solved_whole() -> None:
    """Another contact on one side, another stiffness, a force at the side, and a user who asks for it."""
    assert half_of(unstated(kn=(2.0, 2.1, 1.0))) is None
    assert half_of(unstated(off=0.1)) is None
    assert half_of(unstated(), "side") is None
    assert half_of(replace(unstated(), as_a_whole=True)) is None


@pytest.mark.parametrize(
    ("law", "parameters", "found"),
    [
        (CubicSpring(), CubicParameters(np.full(2, 0.3)), True),
        (Stop(), UnilateralParameters(np.full(2, 0.3), np.full(2, 1e-4)), False),
    ],
)
def test_a_law_must_be_odd_where_its_displacement_changes_sign(law, parameters, found: bool) -> None:
    """Two masses driven against each other: the image of the one's motion is the other's, turned round."""
    stiffness = np.array([[2.0, -0.5], [-0.5, 2.0]])
    against = np.array([1.0, -1.0])
    linear = from_matrices(
        np.eye(2), 0.01 * np.eye(2), stiffness, np.eye(2), {"drive": against, "together": 0 * against + 1}
    )
    springs = ElementGroup(law, parameters, np.array([[0], [1]]))
    system = NonlinearSystem(linear, (springs,), Harmonics((0, 1, 2, 3)), 64)
    assert (half_of(system) is not None) is found
    assert half_of(system, "together") is not None  # nothing changes its sign there
