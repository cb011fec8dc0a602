"""The stuck rig: Woodbury and Lanczos against one large sparse matrix, the reduced model against both."""

from dataclasses import dataclass

import numpy as np
import pytest
from scipy import sparse
from scipy.sparse.linalg import eigsh

from updamp.fem.coupled_modes import coupled_frequencies_reduced
from updamp.fem.coupling import patch
from updamp.fem.finite_element_model import (
    CoupledCheck,
    component_model,
    coupled_check,
    finite_element_model,
    joined,
    rig_springs,
)
from updamp.fem.reduced_model import ReducedModel
from updamp.fem.reduction import ReductionOptions
from updamp.fem.rig_components import RigComponents, assemble_rig
from updamp.fem.springs import ContactStiffness, damper_point, on_damper, stuck_contact
from updamp.rig.wires import wire_springs

STIFFNESS = ContactStiffness(6e13, 6e13)
TOLERANCE = 1e-3  # what the reduction promises


@dataclass(frozen=True)
class Checked:
    reduced: ReducedModel
    coupled: CoupledCheck


@pytest.fixture(scope="module")
def result(tiny_mesh, reference_rig):
    reduced = finite_element_model(tiny_mesh, reference_rig).reduced
    return Checked(reduced, check_of(tiny_mesh, reference_rig, reduced, STIFFNESS))


def check_of(mesh, rig, reduced, stiffness):
    with RigComponents(mesh, rig) as parts:
        return coupled_check(parts, reduced, stiffness)


@pytest.fixture(scope="module")
def without_residual(tiny_mesh, reference_rig):
    return finite_element_model(tiny_mesh, reference_rig, ReductionOptions(residual=False)).reduced


def assembled_frequencies(mesh, rig, springs, n: int) -> np.ndarray:
    """(n,) [Hz] of blades, damper and springs as one sparse matrix, factorised as such."""
    blade, damper = assemble_rig(mesh, rig, patch)
    parts = [blade, blade, damper]
    operator = sparse.block_diag([part.interface.operator for part in parts], format="csc")
    seen = operator @ sparse.csc_array(springs.directions)
    stiffness = sparse.block_diag([part.matrices.stiffness for part in parts], format="csc")
    mass = sparse.block_diag([part.matrices.mass for part in parts], format="csc")
    total = sparse.csc_array(stiffness + (seen * springs.stiffness) @ seen.T)
    start = np.random.default_rng(6).standard_normal(total.shape[0])
    values = eigsh(total, n, mass, sigma=0, v0=start, return_eigenvectors=False)
    return np.sqrt(np.sort(values)) / (2 * np.pi)


def test_full_check_equals_one_large_matrix(tiny_mesh, reference_rig, result) -> None:
    springs = rig_springs(result.reduced, reference_rig, STIFFNESS)
    exact = assembled_frequencies(tiny_mesh, reference_rig, springs, 4)
    np.testing.assert_allclose(result.coupled.full, exact, rtol=1e-8)


def test_reduced_model_meets_the_full_one(result) -> None:
    assert result.coupled.largest_difference < TOLERANCE / 10
    np.testing.assert_array_less(result.coupled.full, result.coupled.reduced)  # Rayleigh: from above


def test_check_fails_without_residual(reference_rig, result, without_residual) -> None:
    springs = rig_springs(without_residual, reference_rig, STIFFNESS)
    error = coupled_frequencies_reduced(without_residual, springs) / result.coupled.full - 1
    assert error[:2].min() > TOLERANCE
    assert error[:2].max() > 10 * TOLERANCE


def test_check_alone_for_another_contact_stiffness(tiny_mesh, reference_rig, result) -> None:
    softer = ContactStiffness(2e12, 5e12)
    check = check_of(tiny_mesh, reference_rig, result.reduced, softer)
    exact = assembled_frequencies(tiny_mesh, reference_rig, rig_springs(result.reduced, reference_rig, softer), 4)
    np.testing.assert_allclose(check.full, exact, rtol=1e-8)
    assert check.largest_difference < TOLERANCE / 10
    assert check.full[0] < result.coupled.full[0]


def test_blades_move_against_and_with_each_other(tiny_mesh, result) -> None:
    """OOP: tips apart, the damper translates along x. IP: tips together in x mirrored, the damper does not go along."""
    check = result.coupled
    assert {check.out_of_phase, check.in_phase} == {0, 1}
    tip = tiny_mesh.blade.points["tip"]
    for name, sign in (("OOP", -1), ("IP", 1)):
        shape = check.shapes[name]
        left, right = shape["blade_left"][tip, 0], shape["blade_right"][tip, 0]
        assert left == pytest.approx(sign * right, rel=1e-4)
        assert np.abs(shape["blade_right"][tip]).argmax() == 0


def test_stages_are_timed_and_told_and_factorisations_shared(tiny_mesh, reference_rig) -> None:
    told: list[str] = []
    with RigComponents(tiny_mesh, reference_rig, told.append) as parts:
        blade, seconds = parts.clock.timed(lambda: component_model(parts, "blade"))
        assert set(seconds) == {"assembly", "modes", "reduction"}
        assert min(seconds.values()) > 0
        damper = component_model(parts, "damper")
        reduced = joined(blade, damper, tiny_mesh.contacts).reduced
        _, seconds = parts.clock.timed(lambda: coupled_check(parts, reduced, STIFFNESS))
        assert set(seconds) == {"coupled_check"}
    assert told[0] == "stiffness and mass of the blade"
    assert "residual flexibility of the damper" in told
    assert blade.shapes.shape == (6, len(tiny_mesh.blade.vertices), 3)
    assert np.abs(blade.shapes[:, np.unique(tiny_mesh.blade.faces["root"])]).max() == 0
    assert reduced.max_relative_residual < 1e-6


def test_wires_hold_all_rigid_motion(tiny_mesh, reference_rig) -> None:
    contacts = tiny_mesh.contacts
    springs = on_damper(contacts, wire_springs(reference_rig))
    wire, pull = reference_rig.wire, reference_rig.load.pull
    upwards = sum(damper_point(contacts, f"wire_{end}.y") for end in ("back", "front"))
    upwards = upwards + damper_point(contacts, "corner_left.y") + damper_point(contacts, "corner_right.y")
    elongation = springs.directions.T @ upwards
    assert elongation @ (springs.stiffness * elongation) == pytest.approx(wire.axial_stiffness)
    half_width = reference_rig.face_bottom[0]
    roll = half_width * (damper_point(contacts, "corner_right.y") - damper_point(contacts, "corner_left.y"))
    elongation = springs.directions.T @ roll
    assert elongation @ (springs.stiffness * elongation) == pytest.approx(pull * wire.attachment_height)
    level = wire_springs(reference_rig.model_copy(update={"wire": wire.model_copy(update={"attachment_height": 0.0})}))
    assert on_damper(contacts, level).stiffness.shape == (6,)


def test_stuck_contact_feels_relative_motion_only(tiny_mesh) -> None:
    """Blades and damper moving alike along each local direction stretch no spring; the damper alone stretches all."""
    contacts = tiny_mesh.contacts
    springs = stuck_contact(contacts, ContactStiffness(1e12, 3e12))
    n = 3 * len(contacts)
    alike = np.zeros(len(springs.directions))
    half = n // 2
    alike[:half] = alike[half + 4 : n + 4] = 1
    alone = np.zeros_like(alike)
    alone[n + 8 : 2 * n + 8] = 1
    np.testing.assert_array_equal(springs.directions.T @ (alike + alone), 0)
    np.testing.assert_array_equal(springs.directions.T @ alone, 1)
    per_contact = springs.stiffness.reshape(-1, 3) / contacts.area[:, None]
    np.testing.assert_allclose(per_contact, np.tile([1e12, 1e12, 3e12], (len(contacts), 1)))


def test_contact_stiffness_is_checked() -> None:
    with pytest.raises(ValueError, match=r"contact.normal_stiffness = 0 N/m\^3 must be positive"):
        ContactStiffness(1e12, 0)
