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
from updamp.hbm.problem.receptance import Receptance
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
        (
            Stop(),
            UnilateralParameters(np.full(2, 0.3), np.full(2, 1e5)),
            False,
        ),  # a tenth of a millimetre in nanometres
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


def ring(parts: int, other: float = 0.0, coupling: float = 0.1) -> NonlinearSystem:
    """Equal masses in a ring, one stop at each, the third one driven; other: by how much more the second weighs"""
    rows = np.eye(parts)
    K = rows + coupling * (2 * rows - np.roll(rows, 1, axis=0) - np.roll(rows, -1, axis=0))
    M = np.diag(1 + other * rows[1])
    linear = from_matrices(M, 0.004 * K, K, rows, {"drive": rows[2], "beside": rows[1]})
    group = ElementGroup(Stop(), UnilateralParameters(np.full(parts, 0.5), np.ones(parts)), np.arange(parts)[:, None])
    return NonlinearSystem(linear, (group,), Harmonics((0, 1, 2, 3)), 256)


@pytest.mark.parametrize("parts", [3, 4, 5, 6, 9])
def test_of_a_ring_each_pair_of_modes_is_turned_so_that_one_is_driven(parts: int) -> None:
    half, mirror = half_of(ring(parts))
    np.testing.assert_array_equal(mirror.image, (4 - np.arange(parts)) % parts)
    assert (mirror.sign == 1).all()
    assert len(half.free.omega_squared) == parts // 2 + 1
    assert half_of(ring(parts, other=1e-4)) is None


@pytest.mark.parametrize("parts", [3, 4, 6, 9])
@pytest.mark.parametrize("where", ["not at the driven one", "between neighbours", "two at each"])
def test_so_it_is_wherever_elements_are(parts: int, where: str) -> None:
    """The mode in which all move alike moves no element between neighbours, and without an element at the force the
    driven modes' motions at the elements cancel: of both round-off was asked. And two may move alike."""
    rows = np.eye(parts)
    elements = {
        "not at the driven one": np.delete(rows, 2, axis=0),
        "between neighbours": rows - np.roll(rows, 1, axis=1),
        "two at each": np.repeat(rows, 2, axis=0),
    }[where]
    K = rows + 0.1 * (2 * rows - np.roll(rows, 1, axis=0) - np.roll(rows, -1, axis=0))
    linear = from_matrices(rows, 0.004 * K, K, elements, {"drive": rows[2]})
    places = np.arange(len(elements))[:, None]
    stiffness = (
        np.where(np.arange(len(elements)) % 2, 0.3, 0.1) if where == "two at each" else np.full(len(elements), 0.3)
    )
    system = NonlinearSystem(
        linear, (ElementGroup(CubicSpring(), CubicParameters(stiffness), places),), Harmonics((1, 3)), 64
    )
    half, mirror = half_of(system)
    np.testing.assert_array_equal(stiffness[mirror.image], stiffness)
    assert len(half.free.omega_squared) == parts // 2 + 1
    assert np.abs(elements[mirror.image] * mirror.sign[:, None]).sum() == np.abs(elements).sum()


@pytest.mark.parametrize("parts", [4, 5])
def test_a_ring_has_the_same_curve_from_both_ends(parts: int) -> None:
    """Solved as a whole it stops where motions begin that break the symmetry, at one end or at both."""
    system = ring(parts)
    request = CurveRequest("ring", Excitation(system.free.row("drive"), 0.05), (0.15, 0.24), ("drive", "beside"))
    up, down = (whole_curve(system, replace(request, upwards=upwards)) for upwards in (True, False))
    assert up.complete
    assert down.complete
    assert up.peak("drive") == pytest.approx(down.peak("drive"), rel=1e-5)
    w = 2 * np.pi * up.frequency[len(up) // 2]
    motion = up.displacement[len(up) // 2]
    expected = Receptance(system, w).motion(request.excitation, system.departure_value(motion, w))
    np.testing.assert_allclose(motion, expected, atol=1e-7 * np.abs(motion).max())
