"""Effects and calibrations in rig files: read with everything else, applied by all that take the rig, hashed."""

import hashlib
import io
import pickle
import subprocess
import sys
import textwrap
from dataclasses import replace
from importlib.metadata import EntryPoint
from pathlib import Path

import numpy as np
import pytest
from rich.console import Console
from support.plain_rig import around_first_stuck_mode, plain_reduced_model

from updamp.comparison.prediction.parameters import Parametrisation
from updamp.effects import catalogue, edge_gap
from updamp.effects.catalogue import CATALOGUE
from updamp.effects.chosen import resolved
from updamp.fem.finite_element_model import FiniteElementResult
from updamp.fem.static_contact.static_contact import static_contact
from updamp.geometry.build_mesh import build_mesh
from updamp.hbm.continuation.response_curve import ResponseCurve
from updamp.hbm.problem.structural_changes import attach
from updamp.model.build import from_reduced, modal_model, rig_before_effects, rig_model, wire_attachments
from updamp.model.calibration import FRICTION, LOSS_FACTOR, NORMAL, YOUNGS_MODULUS
from updamp.model.rig_files import load_modal, load_rig
from updamp.rig.errors import RigError
from updamp.rig.rig import Rig
from updamp.rig.tables import values_table
from updamp.workflow import stages, store
from updamp.workflow.curve_jobs import CurveJob, curve_problem, trace_curve
from updamp.workflow.job_pool import JobEnd
from updamp.workflow.store import Stamp

RIGS = Path(__file__).parents[2] / "rigs"
RIG = Path(__file__).parents[1] / "data" / "short_faces.toml"
SHAKER = {"name": "shaker_attachment", "values": {"mass": "50 g", "stiffness": "1e5 N/m", "dashpot": "20 N*s/m"}}
AT_NULL = {"name": "shaker_attachment", "values": {"mass": "0 kg"}}
OWN = """
from updamp.effects.effect import Effect, EffectParameter

def apply(model, values):
    return model.with_contacts(mu=model.contacts.parameters.mu * values["factor"])

EFFECT = Effect("oily", "someone oiled it", (EffectParameter("factor", 1.0, 0.01, 1.0, 0.3, "", "a guess"),), apply)
"""


def with_effects(*effects: dict, **overrides: object) -> Rig:
    return load_rig(RIG, {"effects": list(effects), **overrides})


def keys(rig: Rig) -> dict[str, str]:
    choice = {"preset": "small", "mode": "OOP", "force": "3.84"}
    return {stage.name: stage.key(rig, choice) for stage in stages.STAGES}


def changed(a: Rig, b: Rig) -> set[str]:
    before, after = keys(a), keys(b)
    return {name for name in before if before[name] != after[name]}


# --- reading ---


def test_problems_of_effects_come_with_those_of_all_other_keys():
    with pytest.raises(RigError) as caught:
        load_rig(
            RIG,
            {
                "blade.height": "150",
                "effects": [{"name": "edge_gab", "values": {}}, {"name": "edge_gap", "values": {"depth": "1 mm"}}],
                "calibration": {"sliding_frictoin": 0.9, "preload": 2.0, "loss_factor": "high"},
            },
        )
    lines = str(caught.value).splitlines()[1:]
    for line, start in zip(
        lines,
        (
            "blade.height =",
            'effects[0].name = "edge_gab": no such effect; did you mean edge_gap?',
            "effects[1].values.depth = '1 mm': out of range: allowed is 0 to 5e-06 m",
            "calibration.sliding_frictoin: unknown factor; did you mean sliding_friction?",
            "calibration.preload = 2.0: out of range: allowed is 0.9048 to 1.105",
            "calibration.loss_factor = 'high': a factor is wanted",
        ),
        strict=True,
    ):
        assert line.startswith(start)


@pytest.mark.parametrize("key", ["effects", "calibration"])
def test_other_than_tables_is_refused(key):
    with pytest.raises(RigError, match=f"\n{key}: an? (array of tables|table of factors) is wanted"):
        load_rig(RIG, {key: "edge_gap"})


def test_a_modal_rig_reads_them_too(tmp_path):
    text = (RIGS / "brake_reuss.toml").read_text(encoding="utf-8")
    path = tmp_path / "beam.toml"
    path.write_text(text + '\n[[effects]]\nname = "shaker_attachment"\nvalues = { mass = "1 t" }\n', encoding="utf-8")
    with pytest.raises(RigError, match=r"effects\[0\]\.values\.mass = '1 t': out of range"):
        load_modal(path)


def test_reading_a_rig_without_effects_does_not_load_the_diagnosis():
    read = f"from updamp.model.rig_files import load_rig; load_rig({str(RIG)!r})"
    code = f"import sys; {read}; print('jax' in sys.modules)"
    shown = subprocess.run([sys.executable, "-c", code], check=True, capture_output=True, text=True)
    assert shown.stdout.strip() == "False"


def test_check_shows_them():
    rig = with_effects(SHAKER, **{"calibration.sliding_friction": 0.93})
    console = Console(width=200, file=io.StringIO())
    console.print(values_table(rig))
    lines = [line.split() for line in console.file.getvalue().splitlines()]
    cells = [[cell for cell in line if cell not in "│┃"] for line in lines]
    assert ["effects.shaker_attachment.mass", "0.05", "kg"] in cells
    assert ["calibration.sliding_friction", "0.93"] in cells


# --- hashes ---


def test_only_curves_depend_on_effects_and_calibration():
    plain, shaker = load_rig(RIG), with_effects(SHAKER)
    heavier = {"name": "shaker_attachment", "values": SHAKER["values"] | {"mass": "60 g"}}
    assert changed(plain, shaker) == {"curve"}
    assert changed(shaker, with_effects(heavier)) == {"curve"}
    assert changed(plain, load_rig(RIG, {"calibration.preload": 1.01})) == {"curve"}
    assert changed(shaker, with_effects(SHAKER | {"origin": "fitted to campaign 3"})) == set()
    assert changed(plain, load_rig(RIG, {"effects": [], "calibration": {"origin": "none"}})) == set()
    in_grams = {"name": "shaker_attachment", "values": SHAKER["values"] | {"mass": "0.05 kg"}}
    assert changed(shaker, with_effects(in_grams)) == set()


def test_a_change_in_a_user_s_file_is_noticed(tmp_path):
    own = tmp_path / "oily.py"
    own.write_text(OWN)
    oily = {"name": "oily", "file": str(own), "values": {"factor": 0.5}}
    before = with_effects(oily)
    assert changed(before, with_effects(oily)) == set()
    own.write_text(OWN + "\n# factor squared from now on\n")
    assert changed(before, with_effects(oily)) == {"curve"}


def test_effects_of_other_packages_are_hashed_by_their_source(monkeypatch):
    class Installed(EntryPoint):
        def load(self):
            return replace(CATALOGUE["edge_gap"], name=self.name)

    monkeypatch.setattr(catalogue, "entry_points", lambda group: [Installed("rounded", "x", group)])
    own, other = with_effects({"name": "edge_gap", "values": {}}, {"name": "rounded", "values": {}}).effects
    assert own.code == ""
    assert other.code == hashlib.sha256(Path(edge_gap.__file__).read_bytes()).hexdigest()


# --- what they do ---


@pytest.fixture(scope="module")
def folder(tmp_path_factory) -> Path:
    """Stages of a plain rig, for curves near its first stuck mode."""
    folder = tmp_path_factory.mktemp("stages")
    rig = load_rig(RIG)
    reduced = plain_reduced_model(rig, build_mesh(rig, "small").contacts)
    nothing = np.zeros(0)
    store.write(folder / "fe.h5", FiniteElementResult(reduced, nothing, nothing), Stamp("fe"))
    store.write(folder / "rest.h5", static_contact(reduced, rig), Stamp("rest"))
    return folder


def job_of(folder: Path, *effects: dict) -> CurveJob:
    """Events at the samples: compiles ten times as fast."""
    window = around_first_stuck_mode(RIG, 2.0)
    rig = with_effects(
        *effects, **{"study.modes.OOP.window": window, "contact.law": "jenkins_box_sampled",
                     "harmonic_balance.time_samples": 64}
    )  # fmt: skip
    output = folder / f"{len(list(folder.iterdir()))}.h5"
    return CurveJob(rig, "OOP", 0.5, "key", folder / "fe.h5", folder / "rest.h5", output)


def curve_of(job: CurveJob) -> ResponseCurve:
    assert trace_curve(job) is JobEnd.FINISHED
    return store.read(job.output, ResponseCurve)


def test_an_effect_at_its_null_value_leaves_the_curve_and_one_with_values_changes_it(folder):
    plain, null = curve_of(job_of(folder)), curve_of(job_of(folder, AT_NULL))
    np.testing.assert_array_equal(null.response, plain.response)
    shaker = curve_of(job_of(folder, {"name": "shaker_attachment", "values": {"mass": "1 kg", "dashpot": "1 kN*s/m"}}))
    assert shaker.complete
    peaks = [curve.peak("blade_right.tip.x") for curve in (plain, shaker)]
    assert peaks[1][0] < (1 - 1e-4) * peaks[0][0], "a mass lowers the frequency"
    assert peaks[1][1] < 0.98 * peaks[0][1], "a dashpot lowers the peak"


def test_elements_at_the_tips_are_traced_too(folder):
    damping = {"name": "material_damping", "values": {"growth": 100.0}}
    plain, damped = curve_of(job_of(folder)), curve_of(job_of(folder, damping))
    assert damped.complete
    assert damped.displacement.shape[1] == plain.displacement.shape[1] + 2
    assert damped.peak("blade_right.tip.x")[1] < 0.99 * plain.peak("blade_right.tip.x")[1]


def test_the_problem_of_a_curve_is_that_of_the_diagnosis_and_without_effects_that_of_the_rig(folder, tmp_path):
    plain, request = curve_problem(job_of(folder))
    rig = job_of(folder).rig
    reduced = plain_reduced_model(rig, build_mesh(rig, "small").contacts)
    rest = static_contact(reduced, rig)
    by_hand = attach(from_reduced(reduced, rig.loss_factors), wire_attachments(rig))
    for name in ("omega_squared", "phi", "residual", "hysteretic", "viscous"):
        np.testing.assert_array_equal(getattr(plain.free, name), getattr(by_hand, name))
    assert request.excitation.force == 0.5
    own = tmp_path / "oily.py"
    own.write_text(OWN)
    oily = {"name": "oily", "file": str(own), "values": {"factor": 0.5}}
    job = pickle.loads(pickle.dumps(job_of(folder, SHAKER, oily)))
    both, _ = curve_problem(job)
    built = rig_model(reduced, rest, job.rig).system
    np.testing.assert_array_equal(both.free.omega_squared, built.free.omega_squared)
    np.testing.assert_allclose(both.groups[0].parameters.mu, 0.5 * np.asarray(plain.groups[0].parameters.mu))
    # the shaker's mass on the residual flexibility brings a mode of its own
    assert len(both.free.omega_squared) == len(plain.free.omega_squared) + 1


def test_a_calibration_is_what_a_fit_applies():
    rig = load_rig(RIG)
    reduced = plain_reduced_model(rig, build_mesh(rig, "small").contacts)
    rest = static_contact(reduced, rig)
    factors = {YOUNGS_MODULUS: 1.02, LOSS_FACTOR: 0.7, FRICTION: 0.9}
    model = rig_model(reduced, rest, rig)
    for nuisance, factor in factors.items():
        model = nuisance.apply(model, factor)
    taken = load_rig(RIG, {"calibration": {nuisance.name: factor for nuisance, factor in factors.items()}})
    calibrated = rig_model(reduced, rest, taken)
    np.testing.assert_array_equal(calibrated.components.omega_squared, model.components.omega_squared)
    np.testing.assert_array_equal(calibrated.components.hysteretic, model.components.hysteretic)
    np.testing.assert_array_equal(calibrated.contacts.parameters.mu, model.contacts.parameters.mu)


def test_calibrated_friction_leaves_the_preload_that_a_stated_coefficient_changes():
    rig = load_rig(RIG)
    mu = rig.contact.friction_coefficient
    reduced = plain_reduced_model(rig, build_mesh(rig, "small").contacts)

    def contacts(**changes):
        changed = load_rig(RIG, changes)
        return rig_model(reduced, static_contact(reduced, changed), changed).contacts.parameters

    plain = contacts()
    calibrated, stated = (
        contacts(**{"calibration": {"sliding_friction": 0.5}}),
        contacts(**{"contact.friction_coefficient": mu / 2}),
    )
    np.testing.assert_allclose(calibrated.mu, stated.mu, rtol=1e-15)
    np.testing.assert_array_equal(calibrated.n0, plain.n0)
    alpha = rig.platform.underside_angle
    ratio = (np.cos(alpha) + mu * np.sin(alpha)) / (np.cos(alpha) + mu / 2 * np.sin(alpha))  # eq. (5)
    assert ratio > 1.02
    np.testing.assert_allclose(stated.n0, ratio * np.asarray(plain.n0), rtol=1e-12)


def test_the_earlier_name_of_a_factor_is_told_with_the_present_one():
    with pytest.raises(RigError) as caught:
        load_rig(RIG, {"calibration": {"friction_coefficient": 0.94}})
    (line,) = str(caught.value).splitlines()[1:]
    assert line.startswith("calibration.friction_coefficient: is now called sliding_friction, since")
    assert "write sliding_friction = 0.94." in line
    assert "change contact.friction_coefficient instead" in line


@pytest.mark.parametrize(
    ("nuisance", "name", "entry"), [(LOSS_FACTOR, "material_damping", "in_phase"), (NORMAL, "edge_gap", "n0")]
)
def test_a_fit_finds_the_same_whether_values_are_free_or_taken_up(nuisance, name, entry):
    """These effects depend on what is calibrated: the order counts."""
    effect = CATALOGUE[name]
    stated = {p.name: f"{p.typical} {p.unit}" if p.unit else p.typical for p in effect.parameters}
    rig = with_effects({"name": name, "values": stated})
    reduced = plain_reduced_model(rig, build_mesh(rig, "small").contacts)
    base = rig_before_effects(reduced, static_contact(reduced, rig), rig)
    free = Parametrisation(base, (nuisance,), (effect,)).model(np.array([0.5, 1.0]))
    taken = Parametrisation(base, (nuisance,), rig_effects=resolved(rig.effects)).model(np.array([0.5]))
    other_order = nuisance.apply(rig_model(reduced, static_contact(reduced, rig), rig), float(np.exp(0.5)))

    def entries(model):
        return np.asarray(getattr((model.elements or (model.contacts,))[0].parameters, entry))

    np.testing.assert_allclose(entries(taken), entries(free), rtol=1e-12)
    assert np.abs(entries(other_order) / entries(taken) - 1).max() > 0.01


def test_a_taken_effect_goes_to_a_process_that_has_not_read_its_file(tmp_path):
    own = tmp_path / "oily.py"
    own.write_text(OWN)
    rig = with_effects({"name": "oily", "file": str(own), "values": {"factor": 0.5}}, SHAKER)
    (tmp_path / "taken.pickle").write_bytes(pickle.dumps(resolved(rig.effects)))
    code = textwrap.dedent(f"""
        import pickle
        from pathlib import Path
        oily, shaker = pickle.loads(Path({str(tmp_path / "taken.pickle")!r}).read_bytes())
        print(oily.effect.sentence, dict(oily.values), shaker.values["mass"])
    """)
    shown = subprocess.run([sys.executable, "-c", code], check=True, capture_output=True, text=True)
    assert shown.stdout.strip() == "someone oiled it {'factor': 0.5} 0.05"


def modal(tmp_path: Path, more: str) -> Path:
    path = tmp_path / "beam.toml"
    path.write_text((RIGS / "brake_reuss.toml").read_text(encoding="utf-8") + more, encoding="utf-8")
    return path


def test_a_modal_rig_has_its_effects_and_calibration(tmp_path):
    more = """
[[effects]]
name = "shaker_attachment"
values = { mass = "20 g" }

[calibration]
modal_mass = 1.1
"""
    plain, loaded = (modal_model(load_modal(modal(tmp_path, text))) for text in ("", more))
    before, after = plain.system.free.frequencies[0], loaded.system.free.frequencies[0]
    assert after / before == pytest.approx((1 + 0.02 / 2.2) ** -0.5, rel=1e-9)


@pytest.mark.parametrize(
    ("more", "says"),
    [
        (
            '[[effects]]\nname = "edge_gap"\nvalues = { depth = "1 um" }',
            'the effect "edge_gap" cannot be applied: .*updamp remove',
        ),
        ('[[effects]]\nname = "material_damping"\nvalues = { growth = 1 }', 'the effect "material_damping" cannot'),
        ("[calibration]\npreload = 1.01", "calibration.preload: this model has no place for it"),
    ],
)
def test_what_a_model_has_no_place_for_is_named(tmp_path, more, says):
    rig = load_modal(modal(tmp_path, more + "\n"))
    with pytest.raises(ValueError, match=says):
        modal_model(rig)


def test_a_rig_travels_between_processes_with_its_effects():
    rig = with_effects(SHAKER, **{"calibration.preload": 1.01})
    assert pickle.loads(pickle.dumps(rig)) == rig
    assert replace(job_of(Path(), SHAKER), key="other").rig.effects == rig.effects
