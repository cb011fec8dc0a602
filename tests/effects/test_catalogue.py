"""Every effect of the catalogue: nothing at null, differentiable there, felt at its typical size, and all together."""

from functools import cache

import numpy as np
import pint
import pytest

from updamp.effects import face_angle, face_length
from updamp.effects.catalogue import CATALOGUE, _by_name
from updamp.effects.rig_model import RigModel
from updamp.hbm.newton import observe
from updamp.hbm.newton.equation import evaluate, linear_solution
from updamp.hbm.newton.newton import Solution, solve

UNITS = pint.get_application_registry()  # one for all: to make one takes half a second

FORCE = 25.0  # N
BELOW = 0.97  # of the first stuck frequency: with this force some contacts stick and some slip there
NAMES = (
    "pressure_crown", "pressure_slope", "asymmetric_preload", "pressure_dependent_stiffness",
    "static_dynamic_coupling", "wire_stiffness", "shaker_attachment", "clamp_flexibility", "blade_mistuning",
    "material_damping", "contact_viscosity", "velocity_dependent_friction", "sub_patch_microslip",
    "friction_gradient", "edge_gap", "blade_cubic_stiffness", "power_law_damping", "tip_friction",
    "platform_friction", "friction_by_face", "threshold_damping", "blade_stop", "face_length", "platform_height",
    "blade_thickness", "face_angle", "breathing_crack", "friction_running_in", "blade_square_stiffness",
)  # fmt: skip
# What does nothing by itself: it says how another parameter's effect grows.
WITHOUT_SIZE = {(e.name, p.name) for e in CATALOGUE.values() for p in e.parameters if p.shape}
SMOOTH = [name for name in NAMES if not CATALOGUE[name].finite_step]


def test_a_name_that_is_there_already_is_refused():
    assert tuple(_by_name(face_length, face_angle)) == ("face_length", "face_angle")
    with pytest.raises(ValueError, match='an effect "face_angle" already'):
        _by_name(face_length, face_angle, face_angle)


def solved(model: RigModel, start: np.ndarray, w: float) -> Solution:
    """From the start, with rows for elements at points and coefficients for new harmonics added."""
    system = model.system
    x = np.zeros((system.free.n_relative, system.harmonics.n_coefficients))
    x[: len(start), -start.shape[1] :] = start
    solution = solve(system, model.excited_by(FORCE), x, w)
    assert solution.converged
    return solution


def tip(model: RigModel, solution: Solution) -> complex:
    row = np.array([model.system.free.row("blade_right.tip.x")])
    response = observe.response(solution.equation, model.excited_by(FORCE), row)[0]
    return complex(model.system.harmonics.amplitude(response, 1))


@pytest.fixture(scope="module")
def at(model):
    """Response of the tip, value by value of an effect, at a frequency where contacts of both faces slip."""
    w = 2 * np.pi * model.system.stuck.frequencies[0] * BELOW
    start = solve(model.system, model.excited_by(FORCE), linear_solution(model.system, w, model.excited_by(FORCE)), w)
    assert start.converged
    states = observe.contact_states(model.system, start.x, w)
    slips = states == observe.ContactState.STICK_SLIP
    assert slips[:18].any()
    assert slips[18:].any()

    @cache
    def response(name: str = "", share: float = 0.0, parameter: str = "") -> complex:
        """share: of the way from null to the typical size; of one parameter, or of all"""
        if not name:
            return tip(model, start)
        effect = CATALOGUE[name]
        values = {
            p.name: p.null + (share if parameter in ("", p.name) else 0.0) * (p.typical - p.null)
            for p in effect.parameters
        }
        changed = effect.apply(model, values).in_run(0.5)  # the last of an assembly
        return tip(changed, solved(changed, start.x, w))

    return response


def test_names_are_those_that_results_are_checked_by():
    assert sorted(CATALOGUE) == sorted(NAMES)
    assert all(effect.name == name for name, effect in CATALOGUE.items())


@pytest.mark.parametrize("name", NAMES)
def test_parameters_have_bounds_units_and_sources(name):
    for p in CATALOGUE[name].parameters:
        assert p.lower <= p.null <= p.upper
        assert p.lower <= p.typical <= p.upper != p.null
        assert p.source
        # SI, since values are handed on as they are
        unit = UNITS.parse_units(p.unit)
        assert (1 * unit).to_base_units().magnitude == pytest.approx(1)


@pytest.mark.parametrize("name", NAMES)
def test_at_null_it_is_the_model_without(model, name):
    """Stuck structure, and forces and residual in an arbitrary motion; elements at points carry nothing."""
    null = CATALOGUE[name].apply(model, CATALOGUE[name].at_null())
    n, w = model.system.free.n_relative, 2700.0
    x = np.zeros((null.system.free.n_relative, 6))
    x[:n] = np.random.default_rng(7).normal(size=(n, 6)) * 1e-7
    assert null.harmonics == model.harmonics
    same = null.system.stuck.frequencies / model.system.stuck.frequencies - 1
    assert np.abs(same).max() < 1e-12
    one = evaluate(model.system, model.excited_by(FORCE), x[:n], w)
    other = evaluate(null.system, null.excited_by(FORCE), x, w)
    np.testing.assert_allclose(other.residual[:n], one.residual, atol=1e-9 * np.abs(one.residual).max())
    assert not other.departure.value[n:].any()


@pytest.mark.parametrize("name", [name for name in SMOOTH if name not in ("wire_stiffness", "platform_friction")])
def test_response_has_a_derivative_at_null(at, name):
    """Of each parameter, per typical size; one-sided where the bounds say so. A longer step gives the same, but for the
    round-off of the structure's modes, 1e-8 of the response."""
    for p in CATALOGUE[name].parameters:
        if (name, p.name) in WITHOUT_SIZE:
            assert at(name, 1e-2, p.name) == pytest.approx(at(), rel=1e-9)
            continue
        short, long = ((at(name, h, p.name) - at()) / h / abs(at()) for h in (5e-4, 2e-3))
        assert abs(short) > 1e-4
        assert abs(long - short) < 0.06 * abs(short) + 2e-5
        if p.two_sided:
            back = (at() - at(name, -5e-4, p.name)) / 5e-4 / abs(at())
            assert abs(back - short) < 0.06 * abs(short) + 2e-5


def test_wires_have_a_derivative_at_null(model):
    """They do nothing in the mode above: where the damper goes up and down, on soft contacts."""
    soft = model.with_contacts(kt=model.contacts.parameters.kt / 1e4, kn=model.contacts.parameters.kn / 1e4)

    def receptance(factor: float) -> complex:
        stuck = CATALOGUE["wire_stiffness"].apply(soft, {"factor": factor}).system.stuck
        return complex(
            stuck.receptance(1500.0)[stuck.row("damper.corner_right.y"), stuck.row("blade_right.platform.y")]
        )

    ahead, behind, further = ((receptance(1 + h) - receptance(1.0)) / h for h in (1e-3, -1e-3, 1e-2))
    assert abs(ahead) > 1e-2 * abs(receptance(1.0))
    assert abs(ahead - behind) < 0.05 * abs(ahead)
    assert abs(ahead - further) < 0.05 * abs(ahead)


def test_friction_between_the_platforms_has_a_derivative_at_null_where_they_move_apart(model):
    """In the second mode; in the first one, above, both platforms go the same way."""
    w = 2 * np.pi * model.system.stuck.frequencies[1] * 0.998

    def response(share: float) -> complex:
        changed = CATALOGUE["platform_friction"].apply(model, {"force": 0.1 * share})
        excitation = changed.excited_by(FORCE)
        solution = solve(changed.system, excitation, linear_solution(changed.system, w, excitation), w)
        assert solution.converged
        return tip(changed, solution)

    short, long, whole = ((response(h) / response(0.0) - 1) / h for h in (5e-4, 2e-3, 1.0))
    assert abs(short) > 1e-3
    assert abs(long - short) < 0.01 * abs(short)
    assert abs(whole - short) < 0.1 * abs(short)


@pytest.mark.parametrize("name", ["pressure_slope", "sub_patch_microslip"])
def test_finite_steps_are_asked_for_where_the_derivative_at_null_vanishes(at, name):
    """The response is continuous there, and what a hundredth of the typical size does is far below its share."""
    change = abs(at(name, 1.0) - at())
    assert change > 1e-4 * abs(at())
    assert abs(at(name, 0.01) - at()) < 1e-3 * change


def test_mean_motion_is_a_harmonic_more(model):
    effect = CATALOGUE["static_dynamic_coupling"]
    whole, half = (effect.apply(model, {"share": share}) for share in (1.0, 0.5))
    assert whole.harmonics.orders == half.harmonics.orders == (0, 1, 2, 3)
    assert whole.contacts is model.contacts
    # the contacts see half of a mean displacement
    x = np.random.default_rng(8).normal(size=(model.system.free.n_relative, 7)) * 1e-7
    half_x = x.copy()
    half_x[:, 0] /= 2
    np.testing.assert_allclose(
        half.system.element_forces(x, 2700.0), whole.system.element_forces(half_x, 2700.0), atol=1e-9
    )
    with pytest.raises(ValueError, match="zero harmonic already"):
        effect.apply(whole, {"share": 1.0})


def test_all_of_them_stack(model, at):
    """At null the response is that without any of them; at a twentieth of the typical size they are solved together."""
    stacked, mixed = model, model
    for effect in CATALOGUE.values():
        stacked = effect.apply(stacked, effect.at_null())
        values = {p.name: p.null + 0.05 * (p.typical - p.null) for p in effect.parameters}
        mixed = effect.apply(mixed, effect.at_null() if effect.name == "static_dynamic_coupling" else values)
    w = 2 * np.pi * model.system.stuck.frequencies[0] * BELOW
    excitation = stacked.excited_by(FORCE)
    solution = solve(stacked.system, excitation, linear_solution(stacked.system, w, excitation), w)
    assert tip(stacked, solution) == pytest.approx(at(), rel=1e-7)
    w = 2 * np.pi * mixed.system.stuck.frequencies[0] * BELOW
    excitation = mixed.excited_by(FORCE)
    together = solve(mixed.system, excitation, linear_solution(mixed.system, w, excitation), w)
    assert together.converged
    assert together.jacobian.n_active > 10


def test_stacked_in_any_order_the_laws_are_the_same(model):
    names = ("pressure_dependent_stiffness", "contact_viscosity", "velocity_dependent_friction", "sub_patch_microslip")
    one, other = model, model
    for name in names:
        one = CATALOGUE[name].apply(one, CATALOGUE[name].at_typical())
    for name in reversed(names):
        other = CATALOGUE[name].apply(other, CATALOGUE[name].at_typical())
    assert one.contacts.law == other.contacts.law
    for entry in one.contacts.parameters._fields:
        np.testing.assert_array_equal(
            getattr(one.contacts.parameters, entry), getattr(other.contacts.parameters, entry)
        )
