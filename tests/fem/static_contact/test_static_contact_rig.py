"""Static contact on the finite elements of the reference rig, small mesh."""

import numpy as np
import pytest

from updamp.fem.assembly import assemble, clamp
from updamp.fem.component import component, factorised
from updamp.fem.coupling import patch
from updamp.fem.interface import blade_interface, damper_interface
from updamp.fem.quadratic_mesh import quadratic_mesh
from updamp.fem.reduced_model import ReducedComponent, ReducedModel
from updamp.fem.reduction import ReductionOptions, component_modes, mirrored_component, reduce_component
from updamp.fem.solvers import solver_named
from updamp.fem.static_contact.finite_element_pressure import finite_element
from updamp.fem.static_contact.rest_state import FaceCoordinates
from updamp.fem.static_contact.static_contact import static_contact
from updamp.geometry.build_mesh import build_mesh
from updamp.geometry.contact_elements import LEFT
from updamp.model.rig_files import load_rig
from updamp.rig.rig import Rig

RIG_FILE = "tests/data/early_opening.toml"
LONG = {"blade.width": "60 mm", "platform.underside_angle": "45 deg"}  # a slender damper, which bends


def rig_with(**pressure) -> Rig:
    return load_rig(RIG_FILE, LONG | {"contact.pressure": pressure})


@pytest.fixture(scope="module")
def reduced() -> ReducedModel:
    rig = load_rig(RIG_FILE, LONG)
    mesh = build_mesh(rig, "small")
    options = ReductionOptions(modes=12)

    def receptance(part, interface_of, free: bool) -> ReducedComponent:
        quadratic = quadratic_mesh(part)
        matrices = assemble(quadratic, rig.material)
        if not free:
            matrices = clamp(matrices, np.unique(quadratic.faces["root"]))
        own = component(quadratic, matrices, interface_of(quadratic, matrices, mesh.contacts, patch), free=free)
        with factorised(own, solver_named("pardiso")) as solved:
            return reduce_component(solved, component_modes(solved, options), options)

    blade = receptance(mesh.blade, blade_interface, free=False)
    damper = receptance(mesh.damper, damper_interface, free=True)
    return ReducedModel(mirrored_component(blade, "blade_left"), blade, damper, mesh.contacts, 0.0)


def resultant(contacts, rest) -> np.ndarray:
    """Force and moment about the origin of the platforms on the damper. (6,) [N], [N m]"""
    local = np.column_stack([rest.tangential_force, rest.normal_force])
    force = -np.einsum("nd,ndx->nx", local, contacts.axes)
    return np.concatenate([force.sum(axis=0), np.cross(contacts.point, force).sum(axis=0)])


@pytest.mark.parametrize("pull_on", ["ends", "mass"])
@pytest.mark.parametrize("friction", [True, False])
@pytest.mark.parametrize("profile", [{}, {"crown_radius": "0.5 m", "tilt": "0.01 deg", "edge_rounding": "0.3 mm"}])
def test_damper_rests_in_equilibrium(reduced: ReducedModel, pull_on: str, friction: bool, profile) -> None:
    rig = rig_with(model="fe", friction=friction, profile=profile, pull_on=pull_on)
    rest = finite_element(reduced, rig)
    contacts, pull, mu = reduced.contacts, rig.load.pull, rig.contact.friction_coefficient
    assert rest.equilibrium_error < 1e-8
    error = np.abs(resultant(contacts, rest) + np.array([0, pull, 0, 0, 0, 0]))
    assert error[:3].max() < 1e-8 * pull
    assert error[3:].max() < 1e-8 * pull * rig.blade.width
    assert rest.normal_force.min() >= 0
    assert rest.gap.min() >= 0
    assert not np.any(rest.normal_force * rest.gap)
    limit = mu * rest.normal_force[:, None] if friction else 0
    assert np.all(np.abs(rest.tangential_force) <= limit * (1 + np.float64(1e-9)))
    left = contacts.face == LEFT
    assert rest.normal_force[left] == pytest.approx(rest.normal_force[~left], abs=1e-9 * pull)
    assert rest.tangential_force[left] == pytest.approx(rest.tangential_force[~left], abs=1e-9 * pull)


def test_friction_is_fully_used_so_that_the_total_is_that_of_equation_5(reduced: ReducedModel) -> None:
    """Blades give way sideways, so that the damper slides up everywhere; the paper assumes just this."""
    uniform = static_contact(reduced, rig_with(model="uniform"))
    solved = static_contact(reduced, rig_with(model="fe"))
    assert solved.normal_total == pytest.approx(uniform.normal_total, rel=1e-9)
    assert uniform.equilibrium_error < 1e-12


def test_pull_on_the_mass_presses_the_lower_edge(reduced: ReducedModel) -> None:
    """The platforms turn away from the damper's upper edge: the paper's spikes at the lower edge."""
    rest = static_contact(reduced, rig_with(model="fe", pull_on="mass"))
    lower = FaceCoordinates.of(reduced.contacts).slope.mean(axis=1) < 0
    assert rest.normal_force[lower].sum() > 0.9 * rest.normal_total
    assert rest.normal_force.max() / rest.normal_force[lower].mean() < 2


def test_pull_on_the_ends_bends_the_damper_so_that_it_bears_at_its_ends(reduced: ReducedModel) -> None:
    rest = static_contact(reduced, rig_with(model="fe"))
    ends = np.abs(reduced.contacts.point[:, 2]) > 20e-3
    assert rest.normal_force[ends].sum() > 0.99 * rest.normal_total
    assert rest.gap.max() > 1e-6
