"""What scripts and notebooks import: results are those of the rooms, and show themselves."""

import json
import os
import re
from pathlib import Path

import matplotlib as mpl
import numpy as np
import pytest
from support import measured_beam
from support.plain_rig import plain_blade, plain_damper, plain_reduced_model
from support.synthetic_comparison import features_only, synthetic_comparison
from support.synthetic_verdict import synthetic_verdict
from threadpoolctl import threadpool_info, threadpool_limits

from updamp import api
from updamp.fem.static_contact.static_contact import static_contact
from updamp.geometry.build_mesh import build_mesh
from updamp.hbm.contact.friction import FrictionParameters
from updamp.hbm.continuation.smooth_branch import BETWEEN
from updamp.model.build import contact_group, rig_model
from updamp.notebook.outcomes import ComparisonResult, DiagnosisResult
from updamp.workflow import diagnose_run, model_of_rig
from updamp.workflow.stage_functions import StageFunctions

ROOT = Path(__file__).parents[1]
RIG, BEAM = ROOT / "rigs" / "pesaresi2017.toml", ROOT / "rigs" / "brake_reuss.toml"
QUICK = {"contact.law": "jenkins_box_sampled", "harmonic_balance.harmonics": [1, 2, 3]}
TAKEN_UP = """
[calibration]
sliding_friction = 0.9

[[effects]]
name = "edge_gap"
values = { depth = "0.3 um" }
"""


@pytest.fixture
def no_finite_elements(monkeypatch: pytest.MonkeyPatch) -> None:
    quick = StageFunctions(blade=plain_blade, damper=plain_damper)
    monkeypatch.setattr(model_of_rig, "StageFunctions", lambda: quick)


@pytest.fixture(scope="module")
def beam() -> api.Model:
    """One mode and a joint that slips."""
    quadratic = api.catalogue()["joint_quadratic"]
    return api.build_model(BEAM).with_effect(quadratic, coefficient=200.0)


@pytest.fixture(scope="module")
def curve(beam: api.Model) -> api.Curve:
    return api.response_curve(beam, (78.0, 83.0), 1.0)


def taken_up(folder: Path) -> Path:
    path = folder / "rig.toml"
    path.write_text(RIG.read_text(encoding="utf-8") + TAKEN_UP, encoding="utf-8")
    return path


def frictions(model: api.Model) -> FrictionParameters:
    return model.parts.contacts.parameters


# --- the model ---


@pytest.mark.usefixtures("no_finite_elements")
def test_effects_and_calibration_of_the_rig_file_are_in_the_model(tmp_path: Path) -> None:
    bare, whole = api.build_model(api.load_rig(RIG, QUICK)), api.build_model(api.load_rig(taken_up(tmp_path), QUICK))
    rig = whole.rig
    mesh = build_mesh(rig, "small")
    reduced = plain_reduced_model(rig, mesh.contacts)
    rest = static_contact(reduced, rig)
    # What README's example did before: contacts of the rig's own sections alone.
    ignored = contact_group(reduced.contacts.area, rest, rig).parameters
    np.testing.assert_array_equal(frictions(bare).mu, ignored.mu)
    np.testing.assert_allclose(frictions(whole).mu, 0.9 * np.asarray(ignored.mu), rtol=1e-12)
    assert np.ptp(frictions(whole).n0 / ignored.n0) > 0.1, "an edge that does not touch at first presses less"
    expected = rig_model(reduced, rest, rig)
    for found, wanted in zip(frictions(whole), expected.contacts.parameters, strict=True):
        np.testing.assert_array_equal(found, wanted)
    np.testing.assert_array_equal(whole.stuck_frequencies, expected.system.stuck.frequencies)
    assert whole.effects == ("edge_gap",)
    assert bare.effects == ()


@pytest.mark.usefixtures("no_finite_elements")
def test_stages_are_taken_from_their_files(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    rig = api.load_rig(RIG, QUICK)
    in_memory, first = api.build_model(rig), api.build_model(rig, folder=tmp_path)
    assert (tmp_path / "stages" / "static_contact.h5").is_file()

    def refuse(*_: object) -> None:
        raise AssertionError("the stage is there")

    nothing = StageFunctions(refuse, refuse, refuse, refuse)
    monkeypatch.setattr(model_of_rig, "StageFunctions", lambda: nothing)
    again = api.build_model(rig, folder=tmp_path)
    for model in (first, again):
        np.testing.assert_allclose(model.stuck_frequencies, in_memory.stuck_frequencies, rtol=1e-12)


@pytest.mark.usefixtures("no_finite_elements")
def test_a_model_tells_what_can_be_asked(tmp_path: Path) -> None:
    model = api.build_model(taken_up(tmp_path))
    assert model.response_point == "blade_right.tip.x"
    assert model.response_point in model.points
    assert model.modes == {"OOP": (433.0, 451.0), "IP": (340.0, 436.0)}
    for shown in (repr(model), model._repr_html_()):
        assert all(word in shown for word in ("pesaresi2017", "small", "72", "edge_gap", "sliding_friction"))
    with pytest.raises(ValueError, match=r'mesh = "tiny": .* no such preset; it has small, medium, full'):
        api.build_model(model.rig, mesh="tiny")


def test_an_effect_can_be_tried_without_a_file(beam: api.Model) -> None:
    bare = api.build_model(BEAM)
    assert bare.effects == ()
    assert beam.effects == ("joint_quadratic",)
    assert len(beam.system.groups) > len(bare.system.groups)
    twin = api.Effect(
        "heavy", "more mass", (api.EffectParameter("share", 0.0, 0.0, 1.0, 0.1, "", "test"),), lambda m, _: m
    )
    assert bare.with_effect(twin, share=0.2).effects == ("heavy",)
    with pytest.raises(ValueError, match=r'effect = "joint_cubi": not in the catalogue; there are .*joint_cubic'):
        bare.with_effect("joint_cubi", coefficient=1.0)
    with pytest.raises(ValueError, match=r"needs values in SI units, such as coefficient = 1e\+11"):
        bare.with_effect("joint_cubic")
    with pytest.raises(ValueError, match=r'factor = 1.0: no parameter of "joint_cubic"; typical values are coeff'):
        bare.with_effect("joint_cubic", factor=1.0)
    with pytest.raises(ValueError, match=r"share = 2.0: out of range: allowed is 0 to 1"):
        bare.with_effect(twin, share=2.0)
    with pytest.raises(ValueError, match=r'"edge_gap" cannot be applied: .* the model has none: leave the effect out$'):
        bare.with_effect("edge_gap", depth=3e-7)


# --- curves and resonances ---


def test_a_response_curve_is_that_of_the_oscillator(curve: api.Curve) -> None:
    """A mass of 2 kg on a spring with F = 8/(3 pi) c w^2 |x| x in its first harmonic."""
    assert curve.complete
    assert curve.force == 1.0
    w, w0 = 2 * np.pi * curve.frequency, 2 * np.pi * 80.38
    x = curve.amplitude("beam.drive.x")
    stiffness = 2.0 * (w0**2 * (1 + 0.0031j) - w**2) + 1j * 8 / (3 * np.pi) * 200.0 * w**2 * np.abs(x)
    np.testing.assert_allclose(stiffness * x, 1.0, rtol=2e-3)  # the force of the time samples
    at, top = curve.peak()
    assert top == pytest.approx(np.abs(curve.receptance()).max(), rel=1e-2)
    assert 80.3 < at < 80.5


def test_a_mode_of_a_modal_rig_has_a_window_of_its_own(beam: api.Model) -> None:
    assert beam.modes == {"first_bending": pytest.approx((0.95 * 80.38, 1.05 * 80.38))}
    upwards, downwards = (api.response_curve(beam, "first_bending", 0.01, upwards=up) for up in (True, False))
    assert upwards.mode == "first_bending"
    assert upwards.frequency[0] == pytest.approx(0.95 * 80.38)
    assert downwards.frequency[0] == pytest.approx(1.05 * 80.38)


CLOSE = """
kind = "modal"
name = "twins"
excitation = "frame.a.x"
[modes.one]
frequency = "100 Hz"
damping_ratio = 0.002
modal_mass = "1 kg"
shape = { "frame.a.x" = 1.0 }
[modes.two]
frequency = "102 Hz"
damping_ratio = 0.002
modal_mass = "1 kg"
shape = { "frame.a.x" = 0.8 }
"""


def test_of_two_close_modes_each_is_followed_by_its_name(tmp_path: Path) -> None:
    """The window of each holds both, and the first responds more: it was followed under either name."""
    (tmp_path / "twins.toml").write_text(CLOSE, encoding="utf-8")
    model = api.build_model(tmp_path / "twins.toml")
    w = 2 * np.pi * np.linspace(99.0, 103.0, 80001)
    modes = [p**2 / (w0**2 - w**2 + 0.004j * w0 * w) for w0, p in ((200 * np.pi, 1.0), (204 * np.pi, 0.8))]
    size = np.abs(modes[0] + modes[1])
    tops = 1 + np.flatnonzero((size[1:-1] > size[:-2]) & (size[1:-1] > size[2:]))
    found = [api.resonance(model, name, (0.01, 1.0)) for name in ("one", "two")]
    assert [one.frequency[-1] for one in found] == pytest.approx(w[tops] / (2 * np.pi), abs=2e-4)
    assert [abs(one.receptance[-1]) for one in found] == pytest.approx(size[tops], rel=1e-6)
    assert not any("turned" in repr(one) for one in found)


def test_a_resonance_is_the_top_of_the_curve(beam: api.Model, curve: api.Curve) -> None:
    many, one = api.resonance(beam, (78.0, 83.0), (0.1, 1.0)), api.resonance(beam, (78.0, 83.0), 1.0)
    at, top = curve.peak()
    for found in (many, one):
        assert found.complete
        assert found.force[-1] == pytest.approx(1.0)
        assert found.frequency[-1] == pytest.approx(at, abs=0.01)
        assert abs(found.receptance[-1]) == pytest.approx(top, rel=1e-4)
    assert (len(many), len(one)) == (2, 1)
    assert many.loss_factor[0] < many.loss_factor[1]
    quadrature = api.resonance(beam, (78.0, 83.0), 1.0, condition=api.PhaseResonance())
    assert np.angle(quadrature.receptance[0]) == pytest.approx(-np.pi / 2, abs=1e-6)


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        (("second", 1.0), r'window = "second": no such mode; there are first_bending; or give \(low, high\) in Hz'),
        (((83.0, 78.0), 1.0), r"window = \(83, 78\): give the lower frequency first"),
        (((78.0, 83.0), -1.0), r"force = -1.0: give its amplitude in newton, above 0"),
        (((78.0, 83.0), "1 N"), r"force = '1 N': give its amplitude in newton"),
        (((78.0, 83.0), 1.0, "beam.nose.x"), r'point "beam.nose.x": .* no such point; it has beam.drive.x'),
    ],
)
def test_what_cannot_be_is_named(beam: api.Model, arguments, message) -> None:
    for call in (api.response_curve, api.resonance):
        with pytest.raises(ValueError, match=message):
            call(beam, *arguments)


def test_results_show_themselves(beam: api.Model, curve: api.Curve, tmp_path: Path) -> None:
    before = mpl.get_backend(auto_select=False)
    found = api.resonance(beam, (78.0, 83.0), (0.1, 1.0))
    assert re.match(r"<Curve 78-83 Hz, 1 N: \d+ points, peak 0\.\d+ mm/N at 80\.\d+ Hz, complete>", repr(curve))
    assert re.match(r"<Resonance 78-83 Hz at beam.drive.x: 80\.\d+ Hz at 0.1 N to 80\.\d+ Hz at 1 N", repr(found))
    assert "beam.drive.x" in curve._repr_html_()
    assert found._repr_html_().count("<tr>") == 3
    drawn = curve.plot(curve)
    amplitude, phase = drawn.axes
    (line, _), label = amplitude.lines, amplitude.get_legend_handles_labels()[1][0]
    np.testing.assert_allclose(line.get_ydata()[::BETWEEN], 1e3 * np.abs(curve.receptance()), err_msg="at the points")
    np.testing.assert_allclose(phase.lines[0].get_ydata()[[0, -1]], [-3, -177], atol=3)
    assert label == "78-83 Hz, 1 N, beam.drive.x"
    assert "mm/N" in amplitude.get_ylabel()
    drawn.savefig(tmp_path / "curve.png")
    assert drawn._repr_png_().startswith(b"\x89PNG")
    assert found.plot().axes[0].lines[0].get_xdata()[-1] == pytest.approx(1.0)
    assert mpl.get_backend(auto_select=False) == before, "the backend is the user's"


# --- measurements ---


def test_comparison_with_a_measurement(tmp_path: Path) -> None:
    rig, measurement = measured_beam.write(tmp_path, points=12)
    found = api.compare(str(rig), measurement, tmp_path / "out", quiet=True)
    written = json.loads((tmp_path / "out" / "comparison.json").read_text())
    assert found.comparison.chi2_after == pytest.approx(written["chi2_after"])
    assert found.report == tmp_path / "out" / "report.html"
    assert found.report.is_file()
    before, after = found.error
    assert after < before
    assert not found.adequate
    assert found.findings == tuple(entry["text"] for entry in written["findings"])
    assert set(found.calibration) == {entry["name"] for entry in written["calibration"]}
    assert api.load_measurement(measurement).title == "Beam"
    with pytest.raises(ValueError, match="rig: a ModalRig was given; give the path"):
        api.compare(api.load_rig(rig), measurement, tmp_path / "out")


def test_outcomes_show_themselves(tmp_path: Path) -> None:
    comparison = synthetic_comparison()
    shown, verdict = ComparisonResult(comparison, tmp_path / "report.html"), synthetic_verdict(comparison)
    assert f"{len(comparison.findings)} findings" in repr(shown)
    assert all(finding.text.split()[0] in shown._repr_html_() for finding in comparison.findings)
    axes = [ax for ax in shown.plot().axes if ax.get_visible()]
    assert [ax.get_title(loc="left") for ax in axes] == [f"{pair.run}, {pair.channel}" for pair in comparison.curves]
    with pytest.raises(ValueError, match="states features only"):
        ComparisonResult(features_only(), tmp_path).plot()
    diagnosed = DiagnosisResult(verdict, tmp_path, None)
    assert diagnosed.sentence in repr(diagnosed)
    assert all(candidate.name in diagnosed._repr_html_() for candidate in verdict.candidates)


def test_a_diagnosis_is_asked_for_as_on_the_command_line(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    verdict, asked = synthetic_verdict(synthetic_comparison()), []

    def diagnose(files, preset, options, console) -> object:
        asked.append((files.rig, files.measurement, preset, options, console.quiet))
        return verdict

    monkeypatch.setattr(diagnose_run, "diagnose", diagnose)
    found = api.diagnose(
        "rig.toml", "measurement.toml", tmp_path, "small", held_out=["IP 9.6 N"], jobs=2, own_effects=["own.py"],
        criteria=api.Criteria(gain=0.05), quiet=True,
    )  # fmt: skip
    options = diagnose_run.DiagnoseOptions(
        held_out=("IP 9.6 N",), jobs=2, own=(Path("own.py"),), criteria=api.Criteria(gain=0.05)
    )
    assert asked == [(Path("rig.toml"), Path("measurement.toml"), "small", options, True)]
    assert (found.verdict, found.folder, found.report) == (verdict, tmp_path, tmp_path / "report.html")
    with pytest.raises(ValueError, match=r"diagnosis\.json: no such file; make it with: updamp diagnose"):
        api.add_effect(BEAM, tmp_path)


# --- what it promises ---


def test_calls_use_one_thread_of_blas_and_leave_the_process_as_it_is(monkeypatch: pytest.MonkeyPatch) -> None:
    def threads() -> set[int]:
        return {library["num_threads"] for library in threadpool_info() if library["user_api"] == "blas"}

    seen = []
    monkeypatch.setattr(api, "load_rig", lambda _: seen.append(threads()) or 1 / 0)
    with threadpool_limits(limits=2, user_api="blas"):
        before = threads()
        with pytest.raises(ZeroDivisionError):
            api.build_model("some.toml")
        assert threads() == before
    assert seen == [{1}]
    if os.cpu_count() != 1:
        assert before != {1}


def test_public_names_are_there_and_documented() -> None:
    for name in api.__all__:
        assert getattr(api, name).__doc__, name
    for name in ("load_rig", "build_model", "response_curve", "resonance", "compare", "diagnose", "add_effect"):
        assert name in api.__all__
        assert "raises: " in getattr(api, name).__doc__
