"""A damper of another material than the blades: its matrices, modes, mass and damping, and nothing else."""

from pathlib import Path

import numpy as np
import pytest

from updamp.fem.coupling import coupling_named
from updamp.fem.finite_element_model import finite_element_model
from updamp.fem.lumped_damper import damper_mass as mass_of_modes
from updamp.fem.reduced_model import ReducedModel
from updamp.fem.rig_components import assemble_rig
from updamp.fem.static_contact.static_contact import static_contact
from updamp.geometry.outlines import area, damper_outline
from updamp.geometry.rig_mesh import RigMesh
from updamp.hbm.continuation.curve import CurveRequest, whole_curve
from updamp.model.build import from_reduced, rig_model
from updamp.model.rig_files import load_rig
from updamp.rig.damper_mass import damper_mass
from updamp.rig.rig import Rig

RIG_FILE = Path(__file__).parents[1] / "data" / "short_faces.toml"
STEEL = {"youngs_modulus": "197 GPa", "poissons_ratio": 0.3, "density": "7800 kg/m^3", "loss_factor": 0.00095}
POLYMER = {"youngs_modulus": "3 GPa", "poissons_ratio": 0.3, "density": "1400 kg/m^3", "loss_factor": 0.05}


def rig_with(**material: object) -> Rig:
    """The reference rig; its damper of steel but for what is stated."""
    return load_rig(RIG_FILE, {"damper.material": STEEL | material})


def reduced_with(mesh: RigMesh, **material: object) -> ReducedModel:
    return finite_element_model(mesh, rig_with(**material)).reduced


@pytest.fixture(scope="module")
def plain(tiny_mesh: RigMesh) -> ReducedModel:
    return finite_element_model(tiny_mesh, load_rig(RIG_FILE)).reduced


def test_the_blades_material_stated_for_the_damper_is_the_same_rig_to_the_last_digit(tiny_mesh, plain):
    rig, own = load_rig(RIG_FILE), rig_with()
    assert own.damper.material == rig.material
    coupling = coupling_named(rig.contact.coupling)
    for one, other in zip(*(assemble_rig(tiny_mesh, each, coupling) for each in (rig, own)), strict=True):
        for of in ("stiffness", "mass"):
            a, b = (getattr(each.matrices, of) for each in (one, other))
            assert abs(a - b).max() == 0
    again = finite_element_model(tiny_mesh, own).reduced
    models = [rig_model(reduced, static_contact(reduced, each), each) for reduced, each in ((plain, rig), (again, own))]
    for of in ("omega_squared", "phi", "residual", "hysteretic"):
        np.testing.assert_array_equal(*(getattr(model.components, of) for model in models))


def test_twice_the_density_is_twice_the_mass_and_leaves_the_blades_alone(tiny_mesh, plain):
    heavy, rig = reduced_with(tiny_mesh, density="15600 kg/m^3"), rig_with(density="15600 kg/m^3")
    analytic = 7800 * area(damper_outline(rig)) * rig.blade.width
    assert mass_of_modes(plain) == pytest.approx(analytic, rel=1e-6)
    assert mass_of_modes(heavy) == pytest.approx(2 * analytic, rel=1e-6)
    assert damper_mass(rig) == pytest.approx(2 * analytic, rel=1e-12)
    for blade in ("blade_left", "blade_right"):
        for of in ("omega", "phi", "residual"):
            np.testing.assert_array_equal(getattr(getattr(heavy, blade), of), getattr(getattr(plain, blade), of))
    elastic = plain.damper.omega > 0
    np.testing.assert_allclose(heavy.damper.omega[elastic], plain.damper.omega[elastic] / np.sqrt(2), rtol=1e-6)


def test_frequencies_of_the_free_damper_go_with_the_root_of_modulus_over_density(tiny_mesh, plain):
    other = reduced_with(tiny_mesh, youngs_modulus="70 GPa", density="2700 kg/m^3")
    factor, elastic = np.sqrt(70 / 197 * 7800 / 2700), plain.damper.omega > 0
    assert elastic.sum() == len(elastic) - 6
    np.testing.assert_allclose(other.damper.omega[elastic], factor * plain.damper.omega[elastic], rtol=1e-6)


def test_the_loss_factor_is_of_the_dampers_modes_alone(plain):
    rig, own = load_rig(RIG_FILE), rig_with(loss_factor=0.02)
    static = static_contact(plain, rig)
    one, other = (rig_model(plain, static, each) for each in (rig, own))
    of_damper = np.array(one.owner) == "damper"
    before, after = (np.diag(model.components.hysteretic) for model in (one, other))
    np.testing.assert_array_equal(before[~of_damper], after[~of_damper])
    squared = one.components.omega_squared[of_damper]
    assert np.count_nonzero(squared) == of_damper.sum() - 6
    np.testing.assert_array_equal(after[of_damper], 0.02 * squared)
    off_diagonal = other.components.hysteretic - np.diag(after)
    assert not off_diagonal.any()
    np.testing.assert_array_equal(from_reduced(plain, own.loss_factors).hysteretic, other.components.hysteretic)


def test_calibration_multiplies_both_materials(plain):
    own = rig_with(loss_factor=0.02)
    factors = {"youngs_modulus": 1.02, "loss_factor": 1.5}
    calibrated = load_rig(RIG_FILE, {"damper.material": STEEL | {"loss_factor": 0.02}, "calibration": factors})
    static = static_contact(plain, own)
    before, after = (rig_model(plain, static, each).components for each in (own, calibrated))
    np.testing.assert_allclose(after.omega_squared, 1.02 * before.omega_squared, rtol=1e-14)
    np.testing.assert_allclose(after.hysteretic, 1.02 * 1.5 * before.hysteretic, rtol=1e-14)


def test_the_energy_balance_holds_with_a_soft_damper_that_damps(tiny_mesh):
    """A damper of a polymer is strained too, and takes up energy; one of little damping does not."""
    reduced, models = reduced_with(tiny_mesh, **POLYMER), {}
    balance = {"contact.friction_coefficient": 0.2, "harmonic_balance.harmonics": [0, 1]}
    for loss in (0.00095, 0.05):
        rig = load_rig(RIG_FILE, {"damper.material": POLYMER | {"loss_factor": loss}, **balance})
        models[loss] = rig_model(reduced, static_contact(reduced, rig), rig)
    little, much = (model.system.stuck for model in models.values())
    share = [float(stuck.hysteretic[0, 0] / stuck.omega_squared[0]) for stuck in (little, much)]
    assert share[0] < 0.00095, "the contacts' springs are strained too, and lose nothing"
    assert share[1] > 2 * share[0]
    window = (0.96 * much.frequencies[0], 1.01 * much.frequencies[0])
    load = models[0.05].excited_by(60.0)
    curve = whole_curve(models[0.05].system, CurveRequest("first", load, window, ("blade_right.tip.x",)))
    assert curve.complete, curve.stopped
    assert (curve.friction_loss / curve.work_in).max() > 0.4
    lost = curve.friction_loss + curve.material_loss
    np.testing.assert_allclose(lost, curve.work_in, atol=1e-4 * curve.work_in.max())
