"""Effects hidden in stated frequencies are found or declared in a group; what calibration can do asks for none."""

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from support.plain_rig import plain_reduced_model

from updamp.diagnosis.stated.low_force_modes import low_force_modes
from updamp.diagnosis.stated.stated_predictions import SurvivingExplanation
from updamp.diagnosis.verdict import VERDICT_JSON
from updamp.effects.catalogue import CATALOGUE
from updamp.fem.static_contact.static_contact import static_contact
from updamp.geometry.build_mesh import build_mesh
from updamp.hbm.problem.structural_changes import Attachment
from updamp.measurement.measurement import Feature
from updamp.model.build import rig_model
from updamp.model.calibration import NORMAL
from updamp.model.rig_files import load_rig
from updamp.model.small_amplitude import linear_up_to, small_amplitude
from updamp.workflow.diagnose_stated import diagnose_stated, tables

RIG_FILE = Path(__file__).parents[1] / "data" / "short_faces.toml"
CHANGES = {
    "contact.law": "jenkins_box_sampled",
    "harmonic_balance.harmonics": [1, 2, 3],
    "harmonic_balance.time_samples": 64,
}
BLADE, UNCERTAINTY = "blade_right", 2e-4
EFFECTS = tuple(CATALOGUE[name] for name in ("blade_mistuning", "clamp_flexibility", "pressure_crown"))
FREE, FORCE = "1F without damper", 0.01


@pytest.fixture(scope="module")
def model():
    rig = load_rig(RIG_FILE, CHANGES)
    reduced = plain_reduced_model(rig, build_mesh(rig, "small").contacts)
    return rig_model(reduced, static_contact(reduced, rig), rig)


@pytest.fixture(scope="module")
def windows(model):
    """Of the modes that bend both blades, in phase and out of phase."""
    found, first = small_amplitude(model, 300.0), {}
    for i in range(6):
        left, right = (found.at(f"blade_{side}.tip.x", i) for side in ("left", "right"))
        if abs(right) > 0.1:  # kg^-1/2
            first.setdefault("A" if (left / right).real > 0 else "B", i)
    return {name: (found.frequencies[i] - 0.5, found.frequencies[i] + 0.5) for name, i in sorted(first.items())}


def stated(model, windows, hidden):
    modes = low_force_modes(model, windows, BLADE)
    names = (FREE, *windows)
    nan = float("nan")
    forces = (nan, *(FORCE for _ in windows))
    return [
        Feature("resonance_frequency", name, force, value, nan, nan, UNCERTAINTY)
        for name, force, value in zip(names, forces, modes.frequencies(hidden, names), strict=True)
    ]


def test_small_amplitude_is_the_stuck_structure(model):
    found = small_amplitude(model, 300.0)
    np.testing.assert_allclose(found.frequencies[:6], model.system.stuck.frequencies[:6], rtol=2e-6)
    # the material's loss factor where no other damping is
    assert all(0 < found.loss_factor(i) <= 0.00095 * (1 + 1e-9) for i in range(6))


def test_peak_is_that_of_the_receptance(model):
    found = small_amplitude(model, 300.0)
    stuck, tip = model.system.stuck, f"{BLADE}.tip.x"
    w = 2 * np.pi * found.frequencies[0]
    rows = [slice(stuck.row(p), stuck.row(p) + 1) for p in (tip, model.excitation)]
    assert found.peak(tip, model.excitation, 0) == pytest.approx(abs(stuck.receptance(w, *rows)[0, 0]), rel=1e-2)


def test_open_contacts_carry_nothing(model):
    """All of them open: the blades vibrate alone, and the damper hangs on its wires."""
    count = len(model.contacts.parameters.n0)
    apart = model.with_contacts(n0=np.zeros(count), gap=np.full(count, 1e-5))
    free = model.system.free.frequencies
    vibrating = free > 1.0  # Hz
    np.testing.assert_allclose(small_amplitude(apart, 300.0).frequencies[vibrating], free[vibrating], rtol=2e-6)
    assert small_amplitude(apart, 300.0).frequencies[0] < 0.9 * model.system.stuck.frequencies[0]


def test_film_stiffens_as_its_dashpots_do(model):
    """A film adds to the mode's damping, to first order, i w c times area times displacement squared."""
    c, area = 1e8, model.patches.area
    filmed = small_amplitude(CATALOGUE["contact_viscosity"].apply(model, {"viscosity": c}), 300.0)
    plain = small_amplitude(model, 300.0)
    shape = plain.shapes[: plain.free.n_relative, 0]
    expected = 2 * np.pi * 300.0 * c * np.sum(np.repeat(area, 3) * shape**2).real
    assert (filmed.squared[0] - plain.squared[0]).imag == pytest.approx(expected, rel=0.02)


def test_slip_begins_where_the_linear_response_reaches_the_limit(model):
    found = small_amplitude(model, 300.0)
    onset = linear_up_to(model, found, 0)
    twice = model.with_contacts(n0=2 * np.asarray(model.contacts.parameters.n0))
    assert linear_up_to(twice, small_amplitude(twice, 300.0), 0) == pytest.approx(2 * onset, rel=1e-6)


@pytest.mark.parametrize(
    ("name", "values"), [("blade_mistuning", {"difference": 0.04}), ("clamp_flexibility", {"compliance": 3e-5})]
)
def test_hidden_effect_is_found(model, windows, name, values, tmp_path):
    hidden = CATALOGUE[name].apply(model, values)
    found = diagnose_stated(model, windows, BLADE, stated(model, windows, hidden), EFFECTS)
    verdict = found.verdict
    assert name in verdict.group
    assert verdict.verdict == "inseparable"
    assert verdict.candidates[0].accepted
    best = next(c for c in verdict.candidates if c.name == name)
    (parameter,) = best.parameters
    (truth,) = values.values()
    assert abs(parameter.value) == pytest.approx(truth, rel=0.02)
    assert not next(c for c in verdict.candidates if c.name == "pressure_crown").accepted
    VERDICT_JSON.write(tmp_path / "diagnosis.json", verdict)
    assert VERDICT_JSON.read(tmp_path / "diagnosis.json").group == verdict.group


@pytest.mark.long
def test_softer_contacts_ask_for_no_effect(model, windows):
    features = stated(model, windows, NORMAL.apply(model, 0.5))
    found = diagnose_stated(model, windows, BLADE, features, EFFECTS)
    assert found.verdict.verdict == "undecidable"
    assert "normal_stiffness" in found.verdict.group
    single = next(e for e in found.found.single if e.name == "normal_stiffness")
    assert single.factors["normal_stiffness"] == pytest.approx(0.5, rel=1e-3)
    apart = {frozenset(m.effects) for m in found.verdict.next_measurement if m.separation > 3}
    assert frozenset(("normal_stiffness", "normal_stiffness by pressure")) in apart
    assert len(tables(found)) == 3


def test_nothing_hidden(model, windows):
    verdict = diagnose_stated(model, windows, BLADE, stated(model, windows, model), EFFECTS).verdict
    assert (verdict.verdict, verdict.group, verdict.next_measurement) == ("adequate", (), ())


def test_what_is_not_in_the_catalogue(model, windows):
    """A mass of 10 g at one tip, but only springs of the clamps to explain it."""
    heavy = replace(model, attachments=(*model.attachments, Attachment("mass", {f"{BLADE}.tip.x": 1.0}, mass=0.01)))
    verdict = diagnose_stated(model, windows, BLADE, stated(model, windows, heavy), EFFECTS[2:]).verdict
    assert (verdict.verdict, verdict.group) == ("unknown", ())


def test_only_low_forces_are_used(model, windows):
    features = stated(model, windows, model)
    slipping = replace(features[1], force=1e4, value=100.0)
    found = diagnose_stated(model, windows, BLADE, [*features, slipping], EFFECTS[2:])
    assert found.left_out == (slipping,)
    with pytest.raises(ValueError, match="none of the 1 stated features"):
        diagnose_stated(model, windows, BLADE, [slipping], EFFECTS)


def test_load_leaves_the_stated_pressure(model, windows):
    """k = k0 (p/p0)^m with a fixed p0: under twice the load all contacts are stiffer by 2^m, and so are the wires."""
    effect = CATALOGUE["pressure_dependent_stiffness"]
    features = stated(model, windows, model)
    found = diagnose_stated(model, windows, BLADE, features, EFFECTS[2:])
    with_effect = replace(
        found.found.as_given, parametrisation=found.problem.parametrisation((), (effect,)), u=np.array([1.5])
    )
    loaded = SurvivingExplanation("pressure", with_effect).model(with_effect.u, 2.0)
    stiffer = NORMAL.apply(model.with_pull(2.0), 2**0.3)
    stiffer = stiffer.with_contacts(kt=np.asarray(stiffer.contacts.parameters.kt) * 2**0.3)
    expected = small_amplitude(stiffer, 300.0).frequencies[:3]
    np.testing.assert_allclose(small_amplitude(loaded, 300.0).frequencies[:3], expected, rtol=1e-6)
