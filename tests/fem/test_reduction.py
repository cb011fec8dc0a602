"""The reduced receptance against solves with the full dynamic stiffness, blade and damper."""

from dataclasses import dataclass

import numpy as np
import pytest
from scipy.sparse import csc_array
from scipy.sparse.linalg import splu

from updamp.fem.component import Component, factorised
from updamp.fem.coupling import patch
from updamp.fem.half_models import half_models
from updamp.fem.modes import Modes
from updamp.fem.reduced_model import ReducedComponent
from updamp.fem.reduction import (
    ReductionOptions,
    component_modes,
    independent_loads,
    mirrored_component,
    reduce_component,
)
from updamp.fem.rig_components import assemble_rig
from updamp.fem.solvers.pardiso import pardiso

TOLERANCE = 1e-3  # what the reduction promises
THIRD_HARMONIC = 3 * 430.0


@dataclass(frozen=True)
class Case:
    component: Component
    modes: Modes
    with_residual: ReducedComponent
    without: ReducedComponent


@pytest.fixture(scope="module")
def cases(tiny_mesh, reference_rig) -> dict[str, Case]:
    found = {}
    for own in assemble_rig(tiny_mesh, reference_rig, patch):
        with factorised(own, pardiso) as part:
            modes = component_modes(part, ReductionOptions())
            reduced = [reduce_component(part, modes, ReductionOptions(residual=on)) for on in (True, False)]
        found[own.name] = Case(own, modes, *reduced)
    return found


def reduced_receptance(reduced: ReducedComponent, frequency: float) -> np.ndarray:
    w = 2 * np.pi * frequency
    return (reduced.phi / (reduced.omega**2 - w**2)) @ reduced.phi.T + reduced.residual


def direct_receptance(own: Component, frequency: float) -> np.ndarray:
    """B^T (K - w^2 M)^-1 B"""
    dynamic = csc_array(own.matrices.stiffness - (2 * np.pi * frequency) ** 2 * own.matrices.mass)
    operator = own.interface.operator
    return operator.T @ splu(dynamic).solve(operator.toarray())


def errors(case: Case, reduced: ReducedComponent, frequency: float) -> tuple[float, float]:
    """Of the contact degrees of freedom: error of the matrix in norm, and the largest of its entries above a tenth of
    the largest, each relative to itself.

    Rigid-body motion, exact on both sides, is taken off first: below its elastic modes a floating damper's receptance
    is nearly all rigid, and beside that part an error of its flexibility could not be seen.
    """
    n, rigid = reduced.n_contact_dofs, reduced.phi[:, reduced.omega == 0]
    moving = -rigid @ rigid.T / (2 * np.pi * frequency) ** 2
    exact = (direct_receptance(case.component, frequency) - moving)[:n, :n]
    difference = np.abs((reduced_receptance(reduced, frequency) - moving)[:n, :n] - exact)
    large = np.abs(exact) > 0.1 * np.abs(exact).max()
    return np.linalg.norm(difference) / np.linalg.norm(exact), float((difference[large] / np.abs(exact[large])).max())


@pytest.mark.parametrize("name", ["blade", "damper"])
@pytest.mark.parametrize("place", ["near_resonance", "operating", "third_harmonic"])
def test_receptance_at_the_contacts(cases, name: str, place: str) -> None:
    """At rest, where a direct solve of the floating damper would be all round-off, see the tests below."""
    case = cases[name]
    first = case.modes.frequencies[case.modes.n_rigid]
    frequency = {
        "near_resonance": first * 1.01,
        "operating": 430.0,
        "third_harmonic": THIRD_HARMONIC,
    }[place]
    assert max(errors(case, case.with_residual, frequency)) < TOLERANCE


@pytest.mark.parametrize("name", ["blade", "damper"])
def test_check_fails_without_residual(cases, name: str) -> None:
    case = cases[name]
    in_norm, of_entries = errors(case, case.without, THIRD_HARMONIC)
    assert in_norm > TOLERANCE
    assert of_entries > 10 * TOLERANCE


def test_blade_at_rest_is_exact(cases) -> None:
    """At all interface degrees of freedom, points too."""
    case = cases["blade"]
    exact = direct_receptance(case.component, 0.0)
    found = reduced_receptance(case.with_residual, 0.0)
    np.testing.assert_allclose(found, exact, atol=1e-9 * np.abs(exact).max())


def test_damper_at_rest_is_exact(cases) -> None:
    """Against a dense pseudo-inverse: equilibrated loads, motion mass-orthogonal to the rigid-body modes."""
    case = cases["damper"]
    own, modes = case.component, case.modes
    K, M, B = own.matrices.stiffness.toarray(), own.matrices.mass.toarray(), own.interface.operator.toarray()
    rigid = modes.phi[:, :6]
    # Bordered system: K x + M Phi_r lambda = B, Phi_r^T M x = 0.
    bordered = np.block([[K, M @ rigid], [rigid.T @ M, np.zeros((6, 6))]])
    scale = np.abs(K).max()
    bordered[: len(K), len(K) :] *= scale
    bordered[len(K) :, : len(K)] *= scale
    motion = np.linalg.solve(bordered, np.vstack([B, np.zeros((6, B.shape[1]))]))[: len(K)]
    exact = B.T @ motion
    elastic = case.with_residual.phi[:, 6:]
    found = (elastic / modes.omega[6:] ** 2) @ elastic.T + case.with_residual.residual
    np.testing.assert_allclose(found, exact, atol=1e-8 * np.abs(exact).max())


@pytest.mark.parametrize("name", ["blade", "damper"])
def test_residual_is_a_flexibility(cases, name: str) -> None:
    """Symmetric, and no load gains energy from it."""
    residual = cases[name].with_residual.residual
    np.testing.assert_array_equal(residual, residual.T)
    values = np.linalg.eigvalsh(residual)
    assert values.min() > -1e-9 * values.max()


def test_left_blade_is_the_mirror_image(cases) -> None:
    right = cases["blade"].with_residual
    left = mirrored_component(right, "blade_left")
    n = right.n_contact_dofs
    flips = np.array([-1.0, -1.0, -1.0, 1.0])  # excitation.x, tip.x, platform.x, platform.y
    np.testing.assert_array_equal(left.phi[:n], right.phi[:n])
    np.testing.assert_array_equal(left.phi[n:], flips[:, None] * right.phi[n:])
    np.testing.assert_array_equal(left.residual[n:, :n], flips[:, None] * right.residual[n:, :n])
    np.testing.assert_array_equal(left.residual[n:, n:], flips[:, None] * right.residual[n:, n:] * flips)
    np.testing.assert_array_equal(mirrored_component(left, "blade_right").residual, right.residual)


def test_options_are_checked() -> None:
    with pytest.raises(ValueError, match=r"reduction.modes = 0 must be at least 1"):
        ReductionOptions(modes=0)


def test_loads_that_differ_by_sign_or_are_sums_of_others_are_solved_once() -> None:
    draw = np.random.default_rng(8).standard_normal((30, 4))
    loads = np.zeros((200, 7))
    loads[50:80] = np.column_stack([draw, -draw[:, 0], draw[:, 1], draw[:, 2] + 2 * draw[:, 3]])
    independent, combined = independent_loads(csc_array(loads))
    assert independent.shape == (200, 4)
    np.testing.assert_allclose(independent @ combined, loads, atol=1e-13)


def test_in_half_of_a_blade_half_of_the_loads_are_independent(tiny_mesh, reference_rig) -> None:
    blade = assemble_rig(tiny_mesh, reference_rig, patch)[0]
    operator = blade.interface.operator
    halves = half_models(blade.mesh.nodes[blade.matrices.free_nodes], blade.matrices)
    counts = [independent_loads(half.within(operator))[0].shape[1] for half in halves]
    assert sum(counts) == operator.shape[1]
    assert independent_loads(operator)[0].shape[1] == operator.shape[1]
