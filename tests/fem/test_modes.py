"""Free modes: rigid-body motion exact, elastic modes orthogonal to it and equal to a dense solver's."""

import numpy as np
import pytest
from scipy.linalg import eigh

from updamp.fem import modes as modes_module
from updamp.fem.assembly import assemble
from updamp.fem.component import component, factorised
from updamp.fem.coupling import patch
from updamp.fem.interface import damper_interface
from updamp.fem.modes import InaccurateModesError, normal_modes
from updamp.fem.quadratic_mesh import quadratic_mesh
from updamp.fem.solvers.pardiso import pardiso


@pytest.fixture(scope="module")
def damper(tiny_mesh, reference_rig):
    mesh = quadratic_mesh(tiny_mesh.damper)
    matrices = assemble(mesh, reference_rig.material)
    return component(mesh, matrices, damper_interface(mesh, matrices, tiny_mesh.contacts, patch), free=True)


@pytest.fixture(scope="module")
def modes(damper):
    with factorised(damper, pardiso) as part:
        return normal_modes(part, 24)


def test_rigid_body_modes_are_exact(damper, modes) -> None:
    assert modes.n_rigid == 6
    np.testing.assert_array_equal(modes.omega[:6], 0)
    forces = np.linalg.norm(damper.matrices.stiffness @ modes.phi, axis=0)
    assert forces[:6].max() < 1e-8 * forces[6]
    rotation = modes.phi[:, 5].reshape(-1, 3)  # about z, through the centre of mass
    assert np.abs(rotation[:, 2]).max() < 1e-9 * np.abs(rotation).max()


def test_modes_are_mass_orthonormal(damper, modes) -> None:
    gram = modes.phi.T @ (damper.matrices.mass @ modes.phi)
    np.testing.assert_allclose(gram, np.eye(24), atol=1e-11)
    np.testing.assert_allclose(gram[:6, 6:], 0, atol=1e-13)


def test_elastic_modes_are_those_of_a_dense_solver(damper, modes) -> None:
    values = eigh(
        damper.matrices.stiffness.toarray(), damper.matrices.mass.toarray(), eigvals_only=True, subset_by_index=[6, 23]
    )
    np.testing.assert_allclose(modes.omega[6:], np.sqrt(values), rtol=1e-9)
    assert modes.max_relative_residual < 1e-6


def test_repeats_to_round_off(damper, modes) -> None:
    with factorised(damper, pardiso) as part:
        np.testing.assert_allclose(normal_modes(part, 24).omega, modes.omega, rtol=1e-9)


def test_inaccurate_modes_are_refused(damper, monkeypatch) -> None:
    monkeypatch.setattr(modes_module, "RESIDUAL_LIMIT", 1e-16)
    with factorised(damper, pardiso) as part, pytest.raises(InaccurateModesError, match="relative residual"):
        normal_modes(part, 10)


@pytest.mark.parametrize("n_modes", [6, 0])
def test_impossible_number_of_modes_is_refused(damper, n_modes: int) -> None:
    with factorised(damper, pardiso) as part, pytest.raises(ValueError, match=r"reduction.modes = .*choose between 7"):
        normal_modes(part, n_modes)
