"""A wrong length of the faces, found again in runs of a rig that was built with it; and not in those of one that was
not."""

from collections.abc import Callable
from dataclasses import replace
from functools import cache
from pathlib import Path

import numpy as np
import pytest
from support.plain_rig import TINY
from support.small_model import synthetic_plan

from updamp.comparison.fit.fit import Fit, FitOptions, fit
from updamp.comparison.prediction.parameters import Parametrisation
from updamp.comparison.prediction.run_condition import RunCondition
from updamp.effects.catalogue import CATALOGUE
from updamp.effects.dimension_blend import varied_dimension
from updamp.effects.rig_model import RigModel
from updamp.fem.finite_element_model import finite_element_model
from updamp.fem.static_contact.static_contact import static_contact
from updamp.geometry.build_mesh import build_mesh
from updamp.model.build import as_built
from updamp.model.calibration import FRICTION, LOSS_FACTOR, PRELOAD, YOUNGS_MODULUS
from updamp.model.rig_files import load_rig
from updamp.rig.dimensions import DIMENSIONS

RIG = Path(__file__).parents[2] / "rigs" / "virtual_rig.toml"
CHANGES = {
    "mesh.tiny": {**TINY, "contact_elements": 8},
    "reduction.modes": 8,
    "contact.law": "jenkins_box_sampled",
    "harmonic_balance.harmonics": [1],
    "harmonic_balance.time_samples": 64,
}
CALIBRATED = (YOUNGS_MODULUS, LOSS_FACTOR, FRICTION, PRELOAD)
LONGER, STEP, NOISE = 0.03, 0.02, 0.003
SENSORS = (("blade_right.tip.x", 1), ("blade_left.tip.x", 1))


@pytest.fixture(scope="module")
def built() -> Callable[[float], RigModel]:
    """With the faces longer by a share."""

    @cache
    def made(change: float) -> RigModel:
        rig = DIMENSIONS["face_length"].changed(load_rig(RIG, CHANGES), change)
        reduced = finite_element_model(build_mesh(rig, "tiny"), rig).reduced
        return as_built(reduced, static_contact(reduced, rig), rig)

    return made


@pytest.fixture(scope="module")
def fitted(built: Callable[[float], RigModel]) -> Callable[[float], Fit]:
    varied = varied_dimension(built(0.0), built(STEP), STEP)
    model = replace(built(0.0), dimensions={"face_length": varied})
    ip, oop = model.system.stuck.frequencies[:2]

    def condition(name: str, middle: float, force: float) -> RunCondition:
        window = (0.975 * middle, 1.02 * middle)
        return RunCondition(f"{name} {force:g} N", name, force, True, window, SENSORS, noise=(2e-6, *4 * (NOISE,)))

    conditions = (condition("IP", ip, 4.0), condition("OOP", oop, 12.0))

    @cache
    def found(change: float) -> Fit:
        scatter = np.array([n.scatter for n in CALIBRATED]) / 10
        truth = Parametrisation(built(change), CALIBRATED)
        plan, _ = synthetic_plan(truth, np.zeros(len(CALIBRATED)), conditions, scatter, 4, NOISE, repeats=1)
        p = Parametrisation(model, CALIBRATED, (CATALOGUE["face_length"],))
        return fit(p, plan, np.zeros(len(p)), options=FitOptions(rounds=4))

    return found


def change_in(found: Fit) -> float:
    return found.parametrisation.values(found.u)["face_length"]["change"]


def test_the_length_that_the_rig_was_built_with_is_found(fitted):
    found = fitted(LONGER)
    assert found.parametrisation.mirrored
    assert found.compared.chi2 / found.compared.values < 1.3
    assert change_in(found) == pytest.approx(LONGER, rel=0.15)


def test_of_a_rig_that_is_as_stated_nothing_is_said(fitted):
    found = fitted(0.0)
    (place,) = range(len(CALIBRATED), len(found.u))
    assert abs(found.u[place]) < 3 * found.deviations[place]
    assert abs(change_in(found)) < LONGER / 4
    assert found.compared.chi2 / found.compared.values < 1.3
