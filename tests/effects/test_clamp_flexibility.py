"""Clamps that rotate: against a beam's closed solution, and the participation against finite elements."""

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
import scipy.linalg
from scipy.optimize import brentq

from updamp.effects.clamp_flexibility import EFFECT, participation, rigid_rotation
from updamp.effects.rig_model import RigModel
from updamp.effects.structure import modes_of
from updamp.fem.component import factorised
from updamp.fem.coupling import coupling_named
from updamp.fem.finite_element_model import finite_element_model
from updamp.fem.modes import normal_modes
from updamp.fem.rig_components import assemble_rig
from updamp.fem.solvers import solver_named
from updamp.fem.static_contact.static_contact import static_contact
from updamp.geometry.build_mesh import build_mesh
from updamp.geometry.contact_elements import LEFT, RIGHT, ContactElements
from updamp.hbm.contact.friction import FrictionParameters
from updamp.hbm.contact.jenkins_box_sampled import SampledJenkinsBox
from updamp.hbm.harmonics import Harmonics
from updamp.hbm.problem.elements import ElementGroup
from updamp.hbm.problem.linear_model import LinearModel
from updamp.model.build import rig_model
from updamp.model.rig_files import load_rig
from updamp.rig.mesh_divisions import MeshDivisions

RIG_FILE = Path(__file__).parents[1] / "data" / "short_faces.toml"
EI, MASS, LENGTH, ELEMENTS, KEPT = 126.0, 1.14, 0.15, 60, 6  # N m^2, kg/m, m
POINTS = {"excitation": 0.0125, "platform": 0.0475, "tip": 0.13}
FACE = 0.0425  # m, height of the contact


def beam_matrices() -> tuple[np.ndarray, np.ndarray]:
    """Euler-Bernoulli, (deflection, slope) a node, not yet clamped."""
    h, n = LENGTH / ELEMENTS, 2 * (ELEMENTS + 1)
    k = EI / h**3 * np.array([[12, 6 * h, -12, 6 * h], [6 * h, 4 * h**2, -6 * h, 2 * h**2],
                              [-12, -6 * h, 12, -6 * h], [6 * h, 2 * h**2, -6 * h, 4 * h**2]])  # fmt: skip
    m = MASS * h / 420 * np.array([[156, 22 * h, 54, -13 * h], [22 * h, 4 * h**2, 13 * h, -3 * h**2],
                                   [54, 13 * h, 156, -22 * h], [-13 * h, -3 * h**2, -22 * h, 4 * h**2]])  # fmt: skip
    K, M = np.zeros((n, n)), np.zeros((n, n))
    for e in range(ELEMENTS):
        K[2 * e : 2 * e + 4, 2 * e : 2 * e + 4] += k
        M[2 * e : 2 * e + 4, 2 * e : 2 * e + 4] += m
    return K, M


def at_height(y: float) -> int:
    return 2 * round(y / LENGTH * ELEMENTS)


@pytest.fixture(scope="module")
def two_beams() -> RigModel:
    """Both blades as beams that bend in x, seen at three points and one contact each; no damper."""
    K, M = (matrix[2:, 2:] for matrix in beam_matrices())
    rows = np.array([at_height(y) - 2 for y in (FACE, *POINTS.values())])
    values, shapes = scipy.linalg.eigh(K, M)
    omega_squared, phi = values[:KEPT], shapes[rows, :KEPT]
    residual = np.linalg.inv(K)[np.ix_(rows, rows)] - (phi / omega_squared) @ phi.T
    names = tuple(f"blade_{side}.{p}.x" for side in ("left", "right") for p in POINTS)
    full_phi, full_residual = np.zeros((6 + len(names), 2 * KEPT)), np.zeros((6 + len(names),) * 2)
    for b in range(2):
        # n of the contacts along x; relative is damper minus platform
        where = np.array([3 * b + 2, *(6 + 3 * b + np.arange(3))])
        sign = np.array([-1.0, 1, 1, 1])
        full_phi[where, b * KEPT : (b + 1) * KEPT] = sign[:, None] * phi
        full_residual[np.ix_(where, where)] = np.outer(sign, sign) * residual
    m = 2 * KEPT
    nothing = np.zeros((m, m))
    components = LinearModel(np.tile(omega_squared, 2), full_phi, full_residual, nothing, nothing, 6, names)
    x = np.tile([1.0, 0, 0], (2, 1))
    y, z, centroid = np.tile([0, 1.0, 0], (2, 1)), np.tile([0, 0, 1.0], (2, 1)), np.array([[0.0, FACE, 0]] * 2)
    patches = ContactElements(np.array([LEFT, RIGHT]), centroid, np.ones(2), y, z, x, np.stack([centroid] * 3, axis=1))
    owner = ("blade_left",) * KEPT + ("blade_right",) * KEPT
    heights = {f"blade_{s}.{p}": (0.0, y, 0.0) for s in ("left", "right") for p, y in {"root": 0.0, **POINTS}.items()}
    turned = np.ravel([-np.linspace(0, LENGTH, ELEMENTS + 1), -np.ones(ELEMENTS + 1)], order="F")[2:]
    of_blade = shapes[:, :KEPT].T @ M @ turned
    momenta = {"blade_left": np.append(of_blade, 0 * of_blade), "blade_right": np.append(0 * of_blade, of_blade)}
    return RigModel(
        components, owner, (), _any_contacts(), patches, names[0], Harmonics((1,)), 16, places=heights,
        momentum_about_clamp=momenta,
    )  # fmt: skip


def _any_contacts() -> ElementGroup:
    one = np.ones(2)
    parameters = FrictionParameters(one, one, one, one, np.zeros((2, 2)), 0 * one)
    return ElementGroup(SampledJenkinsBox(2), parameters, np.arange(6).reshape(2, 3))


def analytic_frequency(stiffness: float, mode: int) -> float:
    """[rad/s] of a cantilever on a rotational spring: 1 + cos x cosh x = x EI / (k L) (sin x cosh x - cos x sinh x)."""

    def characteristic(x: float) -> float:
        bending = np.sin(x) * np.cosh(x) - np.cos(x) * np.sinh(x)
        return float(1 + np.cos(x) * np.cosh(x) - x * EI / (stiffness * LENGTH) * bending)

    clamped = (1.8751, 4.6941, 7.8548)[mode]
    x = brentq(characteristic, clamped - 0.3, clamped + 1e-3)
    return float(x**2 * np.sqrt(EI / MASS) / LENGTH**2)


@pytest.mark.parametrize("softness", [1e-3, 2e-2])
def test_frequencies_are_those_of_a_cantilever_on_a_rotational_spring(two_beams, softness):
    """softness: compliance times EI / L; the larger one lowers the first frequency by 4 %. What is left comes from the
    inertia of the modes that are left out."""
    compliance = softness * LENGTH / EI
    softened = EFFECT.apply(two_beams, {"compliance": compliance}).components
    for mode, tolerance in ((0, 1e-4), (1, 1e-3), (2, 0.01)):
        change = np.sqrt(softened.omega_squared[[mode, KEPT + mode]] / two_beams.components.omega_squared[mode]) - 1
        wanted = analytic_frequency(1 / compliance, mode) / analytic_frequency(1e15, mode) - 1
        assert wanted == pytest.approx(-2 * softness, rel=0.2)
        np.testing.assert_allclose(change, wanted, rtol=tolerance)


def test_static_flexibility_is_that_of_the_beam_with_the_spring(two_beams):
    """At all points and the contacts, exactly."""
    compliance = 1e-2 * LENGTH / EI
    after = EFFECT.apply(two_beams, {"compliance": compliance}).components.receptance(0.0).real
    K, _ = beam_matrices()
    sprung = K[1:, 1:].copy()
    sprung[0, 0] += 1 / compliance
    rows = np.array([at_height(y) - 1 for y in (FACE, *POINTS.values())])
    sign = np.array([-1.0, 1, 1, 1])
    exact = sign * np.linalg.inv(sprung)[np.ix_(rows, rows)] * sign[:, None]
    for b in range(2):
        seen = np.array([3 * b + 2, *(6 + 3 * b + np.arange(3))])
        np.testing.assert_allclose(after[np.ix_(seen, seen)], exact, rtol=1e-7)


def test_without_places_it_says_what_it_needs(two_beams):
    with pytest.raises(ValueError, match=r"needs the places of blade_left\.excitation, blade_left\.platform"):
        EFFECT.apply(replace(two_beams, places={}), {"compliance": 1e-6})


@pytest.fixture(scope="module")
def built() -> tuple[RigModel, np.ndarray, np.ndarray]:
    """A rig on a coarse mesh; of its right blade's modes what the finite elements say of a rotation, and that rotation
    at the contacts and points."""
    rig = load_rig(RIG_FILE)
    divisions = rig.mesh["small"].model_dump() | {
        "width": 4, "face": 2, "platform_outer": 1, "platform_height": 2, "stem_above_platform": 8, "stem_top": 2,
        "damper_across": 3, "contact_elements": 8,
    }  # fmt: skip
    rig = rig.model_copy(update={"mesh": {"tiny": MeshDivisions(**divisions)}})
    mesh = build_mesh(rig, "tiny")
    blade, _ = assemble_rig(mesh, rig, coupling_named(rig.contact.coupling))
    with factorised(blade, solver_named(rig.reduction.solver)) as part:
        modes = normal_modes(part, rig.reduction.modes)
    x, y = blade.mesh.nodes[blade.matrices.free_nodes, :2].T
    rotation = np.stack([-y, x - rig.blade.axis_offset, 0 * x], axis=1).ravel()
    reduced = finite_element_model(mesh, rig).reduced
    model = rig_model(reduced, static_contact(reduced, rig), rig)
    rows = np.concatenate([reduced.contact_rows()[1], [model.components.row(f"blade_right.{p}") for p in
                                                       reduced.blade_right.points]])  # fmt: skip
    sign = np.concatenate([-np.ones(len(rows) - 4), np.ones(4)])
    seen = rigid_rotation(model, "blade_right")
    np.testing.assert_allclose(seen[rows], sign * (blade.interface.operator.T @ rotation), atol=1e-9)
    return model, modes.phi.T @ (blade.matrices.mass @ rotation), seen


def test_participation_is_that_of_the_finite_elements(built):
    """Up to the sign of each mode, which one eigensolve and the next need not have in common."""
    model, wanted, _ = built
    found = participation(model, "blade_right")
    np.testing.assert_allclose(np.abs(found), np.abs(wanted), atol=1e-6 * np.abs(wanted).max())


def test_sign_of_every_mode_is_that_of_its_shape(built):
    """The rotation less its share of the kept modes loads nothing that they move: it is small where they are many."""
    model, *_ = built
    for blade in ("blade_left", "blade_right"):
        R, modes = rigid_rotation(model, blade), modes_of(model, blade)
        gamma = participation(model, blade)
        phi = model.components.phi[:, modes]
        left = [np.linalg.norm(R - phi[:, :n] @ gamma[:n]) for n in (1, len(gamma))]
        assert left[1] < left[0]
        strongest = np.argsort(-np.abs(gamma))[:4]
        for mode in strongest:
            turned = gamma.copy()
            turned[mode] *= -1
            assert np.linalg.norm(R - phi @ turned) > left[1]


def test_clamps_that_turn_one_after_the_other_are_those_that_turn_together(built):
    """The modes of a blade are new ones once its clamp has given way."""
    model, *_ = built
    once = EFFECT.apply(model, {"compliance": 2e-6})
    twice = EFFECT.apply(EFFECT.apply(model, {"compliance": 1e-6}), {"compliance": 1e-6})
    a, b = (m.components.omega_squared[modes_of(m, "blade_right")] for m in (once, twice))
    np.testing.assert_allclose(b[:6], a[:6], rtol=1e-10)


def test_a_model_without_finite_elements_says_what_it_lacks(two_beams):
    with pytest.raises(ValueError, match="needs the finite elements of blade_left"):
        EFFECT.apply(replace(two_beams, momentum_about_clamp={}), {"compliance": 1e-6})
