"""The model open to change is the rig's, and what is attached to it is what linear algebra says."""

import pickle
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
import scipy.linalg
from support.plain_rig import plain_reduced_model

from updamp.effects.rig_model import PointElement, RigModel
from updamp.fem.lumped_damper import DAMPER_MODELS
from updamp.fem.static_contact.static_contact import static_contact
from updamp.geometry.build_mesh import build_mesh
from updamp.hbm.contact.jenkins import Jenkins, JenkinsParameters
from updamp.hbm.contact.modified.film import ViscousFilm
from updamp.hbm.harmonics import Harmonics
from updamp.hbm.newton.equation import linear_solution
from updamp.hbm.newton.newton import solve
from updamp.hbm.problem.linear_model import add_springs, from_matrices
from updamp.hbm.problem.structural_changes import Attachment, attach
from updamp.hbm.problem.system import Excitation, NonlinearSystem
from updamp.model.build import contact_group, from_reduced, rig_model, wire_attachments
from updamp.model.rig_files import load_rig

RIG_FILE = Path(__file__).parents[2] / "rigs" / "pesaresi2017.toml"


@pytest.fixture(scope="module")
def stages():
    law = {"contact.law": "jenkins_box_sampled", "harmonic_balance.harmonics": [1, 2, 3]}
    rig = load_rig(RIG_FILE, law | {"contact.friction_coefficient": 0.15})
    reduced = plain_reduced_model(rig, build_mesh(rig, "small").contacts)
    return reduced, static_contact(reduced, rig), rig


@pytest.fixture(scope="module")
def model(stages) -> RigModel:
    return rig_model(*stages)


def side_by_side(stages) -> tuple[NonlinearSystem, Excitation]:
    """The coupled problem put together by hand: components, wires, contacts."""
    reduced, rest, rig = stages
    reduced, rest = DAMPER_MODELS[rig.damper_model].apply(reduced, rest)
    linear = attach(from_reduced(reduced, rig.loss_factors), wire_attachments(rig))
    balance, contacts = rig.harmonic_balance, contact_group(reduced.contacts.area, rest, rig)
    system = NonlinearSystem(linear, (contacts,), Harmonics(balance.harmonics), balance.time_samples)
    return system, Excitation(linear.row(f"blade_{rig.excitation.blade}.excitation.x"), 25.0)


@pytest.mark.parametrize("damper", ["elastic", "lumped"])
def test_frequencies_are_those_of_the_rig(stages, damper):
    reduced, rest, rig = stages
    rig = rig.model_copy(update={"damper_model": damper})
    model = rig_model(reduced, rest, rig)
    system, excitation = side_by_side((reduced, rest, rig))
    np.testing.assert_allclose(model.system.stuck.frequencies, system.stuck.frequencies, rtol=1e-12)
    assert model.excited_by(2.0).row == excitation.row
    assert len(model.owner) == len(model.components.omega_squared)
    for name in ("blade_left", "damper"):  # owners stand where the components' modes do
        component = getattr(reduced, name)
        own = model.components.omega_squared[np.array(model.owner) == name]
        if damper == "elastic" or name != "damper":
            np.testing.assert_allclose(np.sqrt(own), component.omega)


def test_solution_at_a_slipping_point_is_that_of_the_rig(stages, model):
    system, load = side_by_side(stages)
    w = 2 * np.pi * system.stuck.frequencies[0] * 0.97
    one = solve(system, load, linear_solution(system, w, load), w)
    other = solve(model.system, model.excited_by(25.0), linear_solution(model.system, w, load), w)
    assert one.converged
    assert one.jacobian.n_active > 10
    np.testing.assert_allclose(other.x, one.x, atol=1e-9 * np.abs(one.x).max())


def test_another_pull_changes_preload_tension_and_roll_stiffness_alone(stages, model):
    reduced, _, rig = stages
    heavier = rig.model_copy(update={"load": rig.load.model_copy(update={"pull": 1.3 * rig.load.pull})})
    expected, found = rig_model(reduced, static_contact(reduced, heavier), heavier), model.with_pull(1.3)
    np.testing.assert_allclose(found.contacts.parameters.n0, expected.contacts.parameters.n0, rtol=1e-12)
    np.testing.assert_array_equal(found.contacts.parameters.kt, expected.contacts.parameters.kt)
    assert [a.name for a in found.attachments] == [a.name for a in expected.attachments]
    stiffness = [[a.stiffness for a in one.attachments] for one in (model, found, expected)]
    np.testing.assert_allclose(stiffness[1], stiffness[2], rtol=1e-12)
    assert sum(a != b for a, b in zip(stiffness[0], stiffness[1], strict=True)) == 5  # not the axial ones


def test_wires_are_springs_at_both_ends_and_against_roll(stages):
    reduced, _, rig = stages
    free = from_reduced(reduced, rig.loss_factors)
    directions, stiffness = np.zeros((free.n_rows, 7)), np.empty(7)
    for i, (end, axis) in enumerate((e, a) for e in ("back", "front") for a in "xyz"):
        directions[free.row(f"damper.wire_{end}.{axis}"), i] = 1
        stiffness[i] = rig.wire.axial_stiffness / 2 if axis == "y" else rig.load.pull / 2 / rig.wire.length
    for side, sign in (("right", 1), ("left", -1)):
        directions[free.row(f"damper.corner_{side}.y"), 6] = sign / (2 * rig.face_bottom[0])
    stiffness[6] = rig.load.pull * rig.wire.attachment_height
    expected, attached = add_springs(free, directions, stiffness), attach(free, wire_attachments(rig))
    np.testing.assert_allclose(attached.omega_squared, expected.omega_squared, rtol=1e-12, atol=1e-3)
    np.testing.assert_allclose(attached.receptance(2000.0), expected.receptance(2000.0), rtol=1e-9, atol=1e-16)


@pytest.fixture
def chain() -> tuple[np.ndarray, np.ndarray, np.ndarray, dict[str, np.ndarray]]:
    rng, n = np.random.default_rng(6), 8
    C = 0.01 * np.eye(n)
    return np.diag(rng.uniform(0.5, 1.5, n)), C, 2 * np.eye(n) - np.eye(n, k=1) - np.eye(n, k=-1), {
        "tip.x": np.eye(n)[-1], "middle.x": np.eye(n)[3],
    }  # fmt: skip


def test_springs_dashpots_and_masses_are_those_of_the_matrices(chain):
    M, C, K, points = chain
    relative = np.eye(8)[:2]
    model = from_matrices(M, C, K, relative, points)
    both = Attachment("both", {"tip.x": 1.0, "middle.x": -1.0}, stiffness=0.3, dashpot=0.2)
    attached = attach(model, [both, Attachment("mass", {"tip.x": 1.0}, mass=0.7)])
    v, t = points["tip.x"] - points["middle.x"], points["tip.x"]
    M2, C2, K2 = M + 0.7 * np.outer(t, t), C + 0.2 * np.outer(v, v), K + 0.3 * np.outer(v, v)
    np.testing.assert_allclose(attached.omega_squared, scipy.linalg.eigvalsh(K2, M2), rtol=1e-10)
    rows = np.vstack([relative, *points.values()])
    expected = rows @ np.linalg.solve(K2 - 0.9**2 * M2 + 0.9j * C2, rows.T)
    np.testing.assert_allclose(attached.receptance(0.9), expected, rtol=1e-9)


def test_a_point_that_is_not_there_is_named(model):
    with pytest.raises(KeyError, match=r"no point 'nose\.x'"):
        attach(model.components, [Attachment("a", {"nose.x": 1.0}, stiffness=1.0)])


def test_an_element_at_a_point_that_sticks_is_a_spring(model):
    """Two elements at one point, besides the contacts: both act."""
    law, parameters = Jenkins(), JenkinsParameters(np.full(1, 2e4), np.full(1, 1e9))
    element = PointElement("a", ("blade_left.tip.x",), law, parameters)
    with_elements = replace(model, elements=(element, replace(element, name="b")))
    spring = Attachment("spring", {"blade_left.tip.x": 1.0}, stiffness=4e4)
    sprung = replace(model, attachments=(*model.attachments, spring)).system.stuck
    assert with_elements.system.free.n_relative == model.system.free.n_relative + 2
    np.testing.assert_allclose(with_elements.system.stuck.omega_squared, sprung.omega_squared, rtol=1e-9)
    assert abs(sprung.frequencies[0] / model.system.stuck.frequencies[0] - 1) > 1e-3
    row = model.excited_by(1.0).row + 2
    assert with_elements.excited_by(1.0).row == row
    response = [s.receptance(2600.0)[s.row("blade_right.tip.x"), s.row(model.excitation)] for s in
                (with_elements.system.stuck, sprung)]  # fmt: skip
    assert response[0] == pytest.approx(response[1], rel=1e-9)


def test_entries_that_are_new_join_the_parameters_and_travel_between_processes(model):
    n = len(model.contacts.rows)
    changed = model.with_contacts(ViscousFilm.modify(model.contacts.law), viscosity=np.ones(n), mu=np.zeros(n))
    assert changed.contacts.parameters._fields[-1] == "viscosity"
    assert isinstance(changed.contacts.parameters, changed.contacts.law.parameters)
    np.testing.assert_array_equal(changed.contacts.parameters.mu, 0)
    back = pickle.loads(pickle.dumps(changed))
    assert type(back.contacts.parameters) is type(changed.contacts.parameters)
    np.testing.assert_array_equal(back.contacts.parameters.viscosity, 1)


def test_a_model_without_contacts_says_so(model):
    with pytest.raises(ValueError, match="no contacts"):
        replace(model, contacts=None).with_contacts(mu=1.0)


def test_places_are_those_of_the_mesh(stages, model):
    """Marked points of the right blade, from the mesh itself."""
    mesh = build_mesh(stages[2], "small")
    for name in ("tip", "excitation", "platform"):
        np.testing.assert_allclose(
            np.array(model.places[f"blade_right.{name}"])[:2],
            mesh.blade.vertices[mesh.blade.points[name]][:2],
            atol=1e-12,
        )
        x, *rest = model.places[f"blade_right.{name}"]
        assert model.places[f"blade_left.{name}"] == (-x, *rest)
