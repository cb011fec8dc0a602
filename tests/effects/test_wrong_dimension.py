"""Another value of a dimension, against the rig built anew with it: by finite elements on a coarse mesh."""

import pickle
from collections.abc import Callable
from dataclasses import replace
from functools import cache
from pathlib import Path

import numpy as np
import pytest
from support.plain_rig import TINY

from updamp.effects.catalogue import CATALOGUE
from updamp.effects.dimension_blend import on_finer_mesh, varied_dimension
from updamp.effects.rig_model import RigModel
from updamp.fem.finite_element_model import finite_element_model
from updamp.fem.static_contact.static_contact import static_contact
from updamp.geometry.build_mesh import build_mesh
from updamp.model.build import as_built
from updamp.model.calibration import LOSS_FACTOR, PRELOAD, TANGENTIAL, YOUNGS_MODULUS
from updamp.model.rig_files import load_rig
from updamp.rig.dimensions import DIMENSIONS

RIG = Path(__file__).parents[2] / "rigs" / "virtual_rig.toml"
FINER = {**TINY, "width": 6, "stem_above_platform": 6}
CHANGES = {"mesh.tiny": TINY, "mesh.finer": FINER, "reduction.modes": 12, "harmonic_balance.harmonics": [1]}
STEP = 0.02
Built = Callable[..., RigModel]
ROWS = ("blade_right.tip.x", "blade_left.tip.x", "damper.corner_right.y")


@pytest.fixture(scope="module")
def built() -> Built:
    rig = load_rig(RIG, CHANGES)

    @cache
    def made(name: str = "", change: float = 0.0, preset: str = "tiny") -> RigModel:
        there = DIMENSIONS[name].changed(rig, change) if name else rig
        reduced = finite_element_model(build_mesh(there, preset), there).reduced
        return as_built(reduced, static_contact(reduced, there), there)

    return made


@pytest.fixture(scope="module")
def model(built: Built) -> RigModel:
    return replace(built(), dimensions={n: varied_dimension(built(), built(n, STEP), STEP) for n in DIMENSIONS})


def with_dimension(built: Built, name: str, step: float) -> RigModel:
    return replace(built(), dimensions={name: varied_dimension(built(), built(name, step), step)})


def changed(model: RigModel, name: str, change: float) -> RigModel:
    return CATALOGUE[name].apply(model, {"change": change})


def receptance(model: RigModel) -> np.ndarray:
    """Of the model with all contacts stuck: (frequencies, rows, rows) [m/N]"""
    stuck = model.system.stuck
    rows = [stuck.row(point) for point in ROWS]
    return np.array([stuck.receptance(2 * np.pi * f)[np.ix_(rows, rows)] for f in (0.0, 300.0, 700.0, 2500.0)])


def error(found: RigModel, wanted: RigModel) -> float:
    return float(np.linalg.norm(receptance(found) - receptance(wanted)) / np.linalg.norm(receptance(wanted)))


@pytest.mark.parametrize("name", DIMENSIONS)
def test_it_is_the_model_itself_at_null_and_the_rebuilt_one_after_a_step(name, built, model):
    assert changed(model, name, 0.0) is model
    found, wanted = changed(model, name, STEP), built(name, STEP)
    np.testing.assert_allclose(found.system.stuck.frequencies, wanted.system.stuck.frequencies, rtol=1e-9)
    assert error(found, wanted) < 1e-9
    assert error(found, model) > 1e-4
    for entry in ("mu", "kt", "kn", "n0", "gap"):
        values = (getattr(each.contacts.parameters, entry) for each in (found, wanted))
        np.testing.assert_allclose(*values, rtol=1e-12)


def test_a_damper_of_its_own_material_keeps_it():
    """With another loss factor too: at both ends the model is the rebuilt one, between them each body has its own."""
    material = {"youngs_modulus": "3 GPa", "poissons_ratio": 0.3, "density": "1400 kg/m^3", "loss_factor": 0.05}
    rig = load_rig(RIG, {**CHANGES, "damper.material": material})
    models = []
    for there in (rig, DIMENSIONS["face_length"].changed(rig, STEP)):
        reduced = finite_element_model(build_mesh(there, "tiny"), there).reduced
        models.append(as_built(reduced, static_contact(reduced, there), there))
    plain, wanted = models
    able = replace(plain, dimensions={"face_length": varied_dimension(plain, wanted, STEP)})
    assert error(changed(able, "face_length", STEP), wanted) < 1e-9
    between = changed(able, "face_length", STEP / 3)
    loss = np.array([rig.loss_factors[name] for name in between.owner])
    squared = between.components.omega_squared
    np.testing.assert_allclose(between.components.hysteretic, np.diag(loss * squared), atol=1e-9 * squared.max())


@pytest.mark.parametrize("name", DIMENSIONS)
def test_between_it_errs_by_the_square_of_the_step(name, built, model):
    """Half a step away from both ends: a quarter of the error for half the step. The steps are short: two modes that
    repel each other turn faster than by their square before."""
    assert error(changed(model, name, STEP / 2), built(name, STEP / 2)) < 0.05 * error(built(name, STEP / 2), model)
    long, short = (
        error(changed(with_dimension(built, name, step), name, step / 2), built(name, step / 2))
        for step in (STEP / 4, STEP / 8)
    )
    assert np.log2(long / short) == pytest.approx(2.0, abs=0.2)


@pytest.mark.parametrize("name", DIMENSIONS)
def test_it_is_smooth_where_it_is_absent_and_holds_far_away(name, built, model):
    there = receptance(model)
    ahead, behind = ((receptance(changed(model, name, h)) - there) / h for h in (1e-4 * STEP, -1e-4 * STEP))
    assert np.linalg.norm(ahead - behind) < 1e-3 * np.linalg.norm(ahead)
    bounds = CATALOGUE[name].parameters[0]
    for change in (bounds.lower, bounds.upper):
        far = changed(model, name, change)
        assert far.components.omega_squared.min() > -1.0
        assert np.linalg.eigvalsh(far.components.residual).min() > 0
    assert error(changed(model, name, -0.05), built(name, -0.05)) < 0.2 * error(model, built(name, -0.05))


@pytest.mark.parametrize("name", DIMENSIONS)
def test_the_mirror_image_across_the_width_stays(name, model):
    assert model.system.half is not None
    for change in (STEP, STEP / 3, -STEP, 0.09):
        assert changed(model, name, change).system.half is not None


@pytest.mark.parametrize("name", DIMENSIONS)
def test_what_is_calibrated_is_carried_over(name, built, model):
    def calibrated(one: RigModel) -> RigModel:
        for nuisance, factor in ((YOUNGS_MODULUS, 1.03), (LOSS_FACTOR, 2.0), (TANGENTIAL, 0.4), (PRELOAD, 1.1)):
            one = nuisance.apply(one, factor)
        return one

    found, wanted = changed(calibrated(model), name, STEP), calibrated(built(name, STEP))
    assert error(found, wanted) < 1e-9
    np.testing.assert_allclose(found.contacts.parameters.n0, wanted.contacts.parameters.n0, rtol=1e-12)


def test_other_changes_of_the_structure_may_come_before_or_after(model):
    """The same but for what two changes together make of each other."""
    clamps, softer = CATALOGUE["clamp_flexibility"], {"compliance": 4e-6}
    before = changed(clamps.apply(model, softer), "platform_height", 0.01)
    after = clamps.apply(changed(model, "platform_height", 0.01), softer)
    alone = min(error(one, model) for one in (clamps.apply(model, softer), changed(model, "platform_height", 0.01)))
    assert error(before, after) < 0.1 * alone
    one, other = (
        changed(changed(model, first, 0.01), second, 0.01)
        for first, second in (("face_length", "blade_thickness"), ("blade_thickness", "face_length"))
    )
    assert error(one, other) < 1e-3 * error(one, model)


@pytest.mark.parametrize("name", ["face_length", "blade_thickness"])
def test_a_finer_mesh_takes_the_change_over(name, built, model):
    finer = built(preset="finer")
    carried = replace(finer, dimensions={name: on_finer_mesh(model.dimensions[name], finer)})
    rebuilt = built(name, STEP, "finer")
    assert error(changed(carried, name, STEP), rebuilt) < 0.03 * error(finer, rebuilt)
    assert changed(carried, name, STEP / 2).system.half is not None


def test_it_goes_to_other_processes(model):
    again = pickle.loads(pickle.dumps(model))
    for name in DIMENSIONS:
        assert error(changed(again, name, 0.013), changed(model, name, 0.013)) == 0.0


def test_a_model_that_was_built_for_one_value_says_what_to_do(built):
    with pytest.raises(ValueError, match=r"--dimensions face_length.*damper\.face_length times 1\.03"):
        changed(built(), "face_length", 0.03)
    assert changed(built(), "face_length", 0.0) is built()
