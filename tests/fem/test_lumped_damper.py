"""The lumped damper beside the elastic one, on the finite elements of the reference rig, small mesh."""

from dataclasses import replace
from itertools import pairwise
from pathlib import Path

import numpy as np
import pytest

from updamp.effects.rig_model import RigModel
from updamp.fem.finite_element_model import finite_element_model
from updamp.fem.lumped_damper import damper_mass, face_elements, lumped_damper, rest_of_faces
from updamp.fem.reduced_model import ReducedModel
from updamp.fem.static_contact.static_contact import static_contact
from updamp.geometry.contact_elements import LEFT, RIGHT
from updamp.hbm.continuation.curve import CurveRequest, trace
from updamp.hbm.newton.equation import linear_solution
from updamp.hbm.problem.system import NonlinearSystem
from updamp.model.build import rig_model
from updamp.model.rig_files import load_rig
from updamp.rig.errors import RigError
from updamp.rig.rig import Rig

RIG_FILE = Path(__file__).parents[1] / "data" / "short_faces.toml"
TIPS = ("blade_left.tip.x", "blade_right.tip.x")
OUT_OF_PHASE, IN_PHASE = -1, 1


def rig_with(model: str, stiffness: str = "60000 N/mm^3", **more) -> Rig:
    per_area = {"contact.tangential_stiffness": stiffness, "contact.normal_stiffness": stiffness}
    return load_rig(RIG_FILE, {"damper_model": model, **per_area, **more})


@pytest.fixture(scope="module")
def reduced(small_mesh) -> ReducedModel:
    return finite_element_model(small_mesh, load_rig(RIG_FILE)).reduced


def built(reduced: ReducedModel, rig: Rig) -> RigModel:
    return rig_model(reduced, static_contact(reduced, rig), rig)


def coupled(reduced: ReducedModel, rig: Rig) -> NonlinearSystem:
    return built(reduced, rig).system


def stuck_mode(system: NonlinearSystem, phase: int) -> int:
    """Number of the first bending mode whose tips move in that phase."""
    stuck = system.stuck
    left, right = (stuck.phi[stuck.row(tip), :2] for tip in TIPS)
    return int(np.flatnonzero(np.sign(left * right) == phase)[0])


def stuck_frequency(reduced: ReducedModel, phase: int, *choices: str) -> float:
    system = coupled(reduced, rig_with(*choices))
    return float(system.stuck.frequencies[stuck_mode(system, phase)])


def test_mass_is_that_of_the_section(reduced):
    rig = load_rig(RIG_FILE)
    damper = rig.damper
    (low, bottom), (high, top) = rig.face_bottom, rig.face_top
    half = [(low, bottom - damper.base_height), (low, bottom), (high, top)]
    half.append((damper.apex_flat / 2, top + damper.apex_height))
    outline = half + [(-x, y) for x, y in reversed(half)]
    area = sum(x0 * y1 - x1 * y0 for (x0, y0), (x1, y1) in pairwise([*outline, outline[0]])) / 2
    expected = rig.material.density * area * rig.blade.width
    assert damper_mass(reduced) == pytest.approx(expected, rel=1e-6)


def test_the_damper_has_three_translations_of_that_mass(reduced):
    model, _ = lumped_damper(reduced, static_contact(reduced, load_rig(RIG_FILE)))
    damper, mass = model.damper, damper_mass(reduced)
    w = 100.0
    receptance = damper.phi @ np.diag(1 / (damper.omega**2 - w**2)) @ damper.phi.T + damper.residual
    along_y = [
        len(damper.residual) - len(damper.points) + damper.points.index(f"wire_{e}.y") for e in ("back", "front")
    ]
    np.testing.assert_allclose(receptance[np.ix_(along_y, along_y)], -1 / (mass * w**2), rtol=1e-12)
    assert len(damper.omega) == 3


def test_face_elements_keep_area_and_centroid(reduced):
    faces = face_elements(reduced.contacts)
    rig = load_rig(RIG_FILE)
    np.testing.assert_allclose(faces.area, rig.face_area, rtol=1e-9)
    edges = np.cross(faces.triangle[:, 1] - faces.triangle[:, 0], faces.triangle[:, 2] - faces.triangle[:, 0])
    np.testing.assert_allclose(np.linalg.norm(edges, axis=1) / 2, faces.area, rtol=1e-12)
    np.testing.assert_allclose(faces.triangle.mean(axis=1), faces.point, atol=1e-15)
    middle = np.mean([rig.face_top, rig.face_bottom], axis=0)
    np.testing.assert_allclose(faces.point[LEFT], [-middle[0], middle[1], 0], atol=1e-9)
    np.testing.assert_allclose(faces.point[RIGHT], [middle[0], middle[1], 0], atol=1e-9)


def test_blades_move_by_the_average_of_their_face(reduced):
    """A uniform traction is the same load whether it is put on the patches or on the face."""
    model, _ = lumped_damper(reduced, static_contact(reduced, load_rig(RIG_FILE)))
    blade, whole = reduced.blade_right, model.blade_right
    area = reduced.contacts.area[reduced.contacts.face == RIGHT]
    traction = np.zeros(len(blade.residual))
    traction[2 : blade.n_contact_dofs : 3] = area / area.sum()
    tip = len(blade.residual) - len(blade.points) + blade.points.index("tip.x")
    static = blade.phi @ np.diag(blade.omega**-2.0) @ blade.phi.T + blade.residual
    of_face = whole.phi @ np.diag(whole.omega**-2.0) @ whole.phi.T + whole.residual
    assert of_face[3 + whole.points.index("tip.x"), 2] == pytest.approx(static[tip] @ traction, rel=1e-12)
    assert of_face[2, 2] == pytest.approx(traction @ static @ traction, rel=1e-12)


@pytest.mark.parametrize("pressure", ["uniform", "two_area"])
def test_rest_carries_the_pull(reduced, pressure):
    shares = {"central_share": 0.8, "central_fraction": 0.5} if pressure == "two_area" else {}
    rig = load_rig(RIG_FILE, {"contact.pressure": {"model": pressure, **shares}})
    rest = rest_of_faces(static_contact(reduced, rig), reduced.contacts)
    faces = face_elements(reduced.contacts)
    local = np.column_stack([rest.tangential_force, rest.normal_force])
    resultant = np.einsum("nd,ndx->x", local, faces.axes)
    np.testing.assert_allclose(resultant, [0.0, rig.load.pull, 0.0], atol=1e-8 * rig.load.pull)
    assert rest.normal_force.sum() == pytest.approx(rest.normal_total, rel=1e-12)


def test_out_of_phase_is_near_that_of_the_elastic_damper_and_in_phase_is_not(reduced):
    """Out of phase the damper translates: a mass does it nearly as well. In phase it rolls, which a mass cannot."""
    lumped, elastic = (
        {phase: stuck_frequency(reduced, phase, model) for phase in (OUT_OF_PHASE, IN_PHASE)}
        for model in ("lumped", "elastic")
    )
    assert lumped[OUT_OF_PHASE] == pytest.approx(elastic[OUT_OF_PHASE], rel=0.025)
    assert lumped[IN_PHASE] > 1.1 * elastic[IN_PHASE]


def test_with_rigid_contact_the_mass_sits_on_both_faces(reduced):
    """The limit: frequencies at which some pair of contact forces leaves no relative displacement."""
    system = coupled(reduced, rig_with("lumped", "1e10 N/mm^3"))
    free, n = replace(system.free, hysteretic=0 * system.free.hysteretic), system.free.n_relative

    def smallest(frequency: float) -> float:
        values = np.linalg.eigvalsh(free.receptance(2 * np.pi * frequency, slice(n), slice(n)).real)
        return float(np.abs(values).min())

    for phase in (OUT_OF_PHASE, IN_PHASE):
        frequency = system.stuck.frequencies[stuck_mode(system, phase)]
        assert smallest(frequency) < 1e-5 * min(smallest(0.98 * frequency), smallest(1.02 * frequency))
        soft = stuck_frequency(reduced, phase, "lumped")
        assert soft < frequency


def test_low_force_is_linear_and_stays_so_longer_than_with_the_elastic_damper(reduced):
    """Pesaresi et al. (2017), Fig. 16b: in phase, the lumped damper stays linear."""
    onset = {}
    for model in ("lumped", "elastic"):
        rig = built(reduced, rig_with(model))
        system = rig.system
        w = 2 * np.pi * system.stuck.frequencies[stuck_mode(system, IN_PHASE)]
        x = linear_solution(system, w, rig.excited_by(1.0)).reshape(-1, 3, system.harmonics.n_coefficients)
        tangential, normal = np.moveaxis(np.abs(system.harmonics.amplitude(x, 1)), 1, 0)[[0, 2]]
        p = system.groups[0].parameters
        opens, slips = p.n0 / (p.kn * normal), p.mu * p.n0 / (p.kt * tangential)
        onset[model] = float(min(np.min(opens), np.min(slips)))
    assert onset["lumped"] > 5 * onset["elastic"]


def test_curve_at_low_force_is_the_linear_receptance(reduced):
    model = built(reduced, rig_with("lumped"))
    system = model.system
    *_, curve = trace(system, CurveRequest("OOP", model.excited_by(0.96), (435.0, 440.0), TIPS))
    assert curve.complete
    assert curve.active.max() == 0
    rows = np.array([system.stuck.row(tip) for tip in TIPS])
    shaker = np.array([system.stuck.row("blade_right.excitation.x")])
    linear = [system.stuck.receptance(2 * np.pi * f, rows, shaker)[:, 0] for f in curve.frequency]
    found = np.column_stack([curve.receptance(tip) for tip in TIPS])
    np.testing.assert_allclose(found, linear, rtol=1e-9)


def test_unknown_model_is_refused():
    with pytest.raises(RigError, match='damper_model = "rigid": should be "elastic" or "lumped"'):
        load_rig(RIG_FILE, {"damper_model": "rigid"})


def test_a_curved_face_is_refused(reduced):
    bent = reduced.contacts.normal.copy()
    bent[0] += 0.01
    contacts = type(reduced.contacts)(**{**reduced.contacts.__dict__, "normal": bent})
    with pytest.raises(ValueError, match="left contact face is not plane"):
        face_elements(contacts)
