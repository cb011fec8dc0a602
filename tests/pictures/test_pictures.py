"""Pictures are drawn, small enough to keep, and show what they should."""

import os
import subprocess
import sys
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from matplotlib.colors import to_hex
from matplotlib.figure import Figure
from PIL import Image
from support.curves import softening_curve

from updamp.fem.static_contact.rest_state import StaticContact
from updamp.geometry.build_mesh import build_mesh
from updamp.geometry.contact_elements import LEFT, RIGHT
from updamp.geometry.rig_mesh import mirrored_mesh
from updamp.hbm.newton.observe import ContactState
from updamp.hbm.resonance.resonance_curve import ResonanceCurve
from updamp.hbm.stability.branch_stability import BranchStability, State
from updamp.model.rig_files import load_rig
from updamp.pictures import bodies, branch_lines, faces, kinematics, modes, response, scene, style, variants
from updamp.pictures.resonance import resonance_against_force
from updamp.pictures.style import BLUE, GREY, LIGHT_GREY, ORANGE, VERMILLION, YELLOW

RIG = Path(__file__).parents[1] / "data" / "early_opening.toml"


@pytest.fixture(scope="module")
def rig():
    return load_rig(RIG)


@pytest.fixture(scope="module")
def rig_mesh(rig):
    return build_mesh(rig, "small")


@pytest.fixture
def png_alone(monkeypatch):
    """Of a test that looks at the PNG: SVG and PDF, two thirds of the time, are looked at below."""
    monkeypatch.setattr(style, "FORMATS", ())


def pixels(path):
    assert path.stat().st_size < 300_000
    return np.asarray(Image.open(path).convert("RGB")).reshape(-1, 3).astype(int)


def share(picture, colour, tolerance=12):
    """Part of the picture in this colour."""
    wanted = [int(colour[i : i + 2], 16) for i in (1, 3, 5)]
    return np.mean(np.abs(picture - wanted).max(axis=1) <= tolerance)


def test_the_mesh_shows_both_faces_patches(tmp_path, rig_mesh):
    bodies.mesh(tmp_path / "deep" / "mesh.png", rig_mesh)
    picture = pixels(tmp_path / "deep" / "mesh.png")
    assert share(picture, ORANGE) > 0.005
    assert share(picture, BLUE) > 0.001
    assert share(picture, "#FFFFFF") > 0.3


def bending(component, sign):
    motion = np.zeros_like(component.vertices)
    motion[:, 0] = sign * (component.vertices[:, 1] / 0.15) ** 2
    return motion


def test_mode_shapes_in_a_panel_and_in_motion(tmp_path, rig_mesh):
    left = mirrored_mesh(rig_mesh.blade)
    parts = tuple((body, bending(body, sign)) for body, sign in ((rig_mesh.blade, 1), (left, 1), (rig_mesh.damper, 0)))
    shape = modes.ModeShape("IP: 424.0 Hz", parts)
    modes.panel(tmp_path / "modes.png", [shape] * 4)
    assert share(pixels(tmp_path / "modes.png"), "#FFFFFF") < 0.95
    modes.animation(tmp_path / "mode.gif", shape)
    assert (tmp_path / "mode.gif").stat().st_size < 300_000
    with Image.open(tmp_path / "mode.gif") as film:
        assert film.n_frames == modes.FRAMES
        frames = []
        for number in (0, modes.FRAMES // 4, modes.FRAMES // 2, 3 * modes.FRAMES // 4):
            film.seek(number)
            frames.append(np.asarray(film.convert("L")).astype(int))
    differ = [np.mean(np.abs(frame - frames[0]) > 20) for frame in frames]
    assert differ[1] > 0.01, "a quarter period later it is bent"
    assert differ[3] > 0.01
    assert differ[2] < 0.003, "half a period later it passes through rest again"


def test_the_unrolled_faces_keep_areas_and_stand_upright(rig, rig_mesh):
    contacts = rig_mesh.contacts
    for side in (LEFT, RIGHT):
        corners = faces.unrolled(contacts, side)
        a, b = corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0]
        area = np.abs(a[:, 0] * b[:, 1] - a[:, 1] * b[:, 0]) / 2
        np.testing.assert_allclose(area, 1e6 * contacts.area[contacts.face == side])
        assert corners[..., 1].min() == pytest.approx(0)
        assert corners[..., 1].max() == pytest.approx(1e3 * rig.damper.face_length)
        heights = contacts.point[contacts.face == side, 1]
        assert np.corrcoef(heights, corners[..., 1].mean(axis=1))[0, 1] == pytest.approx(1), "up is up the slope"


@pytest.mark.usefixtures("png_alone")
def test_pressure_and_contact_states(tmp_path, rig, rig_mesh):
    contacts = rig_mesh.contacts
    n = len(contacts)
    rest = StaticContact("uniform", 1e6 * contacts.area, np.zeros((n, 2)), np.zeros(n), 960.0, 1.0, 0.0)
    faces.pressure(tmp_path / "pressure.png", contacts, rest)
    assert share(pixels(tmp_path / "pressure.png"), "#FFFFFF") < 0.9
    only_stuck = np.full(n, ContactState.STUCK)
    half_open = np.where(contacts.face == LEFT, ContactState.NEVER_IN_CONTACT, ContactState.SEPARATING)
    faces.contact_states(tmp_path / "a.png", rig, contacts, "OOP", {1.0: only_stuck})
    faces.contact_states(tmp_path / "b.png", rig, contacts, "IP", {1.0: half_open, 0.1: only_stuck})
    stuck, mixed = pixels(tmp_path / "a.png"), pixels(tmp_path / "b.png")
    assert share(stuck, BLUE) > 0.1
    assert share(stuck, VERMILLION) < 0.01
    one_of_four = share(mixed, BLUE) / 2
    assert one_of_four > 0.03
    assert share(mixed, VERMILLION) == pytest.approx(one_of_four, rel=0.15)
    assert share(mixed, LIGHT_GREY) > one_of_four
    assert share(mixed, YELLOW) < 0.01, "in the key alone"


def test_the_states_are_those_of_the_harmonic_balance_in_order():
    assert [state.name.replace("_", " ").replace("STICK SLIP", "STICK-SLIP").lower() for state in ContactState] == list(
        faces.STATES
    )


@pytest.mark.usefixtures("png_alone")
def test_frequency_responses_with_folds_and_a_stopped_branch(tmp_path):
    curves = [
        softening_curve(force=0.1),
        softening_curve(force=1.0, softening=4.0),
        softening_curve(force=3.0, softening=6.0, stopped="the branch stops"),
    ]
    drawn = response.Responses("IP", "blade_right.tip.x", curves)
    response.frequency_responses(tmp_path / "frf.png", drawn)
    assert share(pixels(tmp_path / "frf.png"), "#FFFFFF") < 0.98
    labels = [mark.get_label() for mark in response._key_of_marks(drawn)]
    assert labels == ["peak", "jump, sweep up", "jump, sweep down", "not followed"]
    one = response.Responses("IP", "blade_right.tip.x", curves[:1])
    assert [mark.get_label() for mark in response._key_of_marks(one)] == ["peak"]
    response.frequency_responses(tmp_path / "one.png", one)
    beside = replace(one, detached={0.1: [softening_curve(force=0.1, centre=418.0)]})
    response.frequency_responses(tmp_path / "beside.png", beside)
    assert [mark.get_label() for mark in response._key_of_marks(beside)] == ["peak", "no part of the curve"]
    assert (tmp_path / "one.png").read_bytes() != (tmp_path / "beside.png").read_bytes()


@pytest.mark.usefixtures("png_alone")
def test_what_is_unstable_or_not_known_is_drawn_otherwise(tmp_path):
    """Solid, dashed, dotted; between two points that differ the less certain."""
    curve = softening_curve(force=1.0)
    state = np.full(len(curve), int(State.STABLE))
    state[10:20], state[20:22] = State.UNSTABLE, State.UNKNOWN
    none = np.zeros(0)
    stability = BranchStability("IP", 1.0, state, state > 0, none, (), none.astype(int), 0.0)
    runs = list(branch_lines._runs(curve, stability))
    assert runs == [
        (0, 9, State.STABLE), (9, 19, State.UNSTABLE), (19, 22, State.UNKNOWN), (22, len(curve) - 1, State.STABLE),
    ]  # fmt: skip
    assert list(branch_lines._runs(curve, None)) == [(0, len(curve) - 1, State.STABLE)]
    labels = [mark.get_label() for mark in branch_lines.key_of_stability({1.0: stability})]
    assert labels == ["unstable", "not known if stable"]
    solid = response.Responses("IP", "blade_right.tip.x", [curve])
    response.frequency_responses(tmp_path / "frf.png", replace(solid, stability={1.0: stability}))
    response.frequency_responses(tmp_path / "solid.png", solid)
    assert (tmp_path / "frf.png").read_bytes() != (tmp_path / "solid.png").read_bytes()


@pytest.mark.usefixtures("png_alone")
def test_what_more_harmonics_change_is_a_band_unless_they_are_not_complete(tmp_path):
    curve = softening_curve(force=1.0)
    finer = replace(curve, response=1.3 * curve.response)
    for name, other in (("band", finer), ("none", replace(finer, complete=False))):
        response.frequency_responses(
            tmp_path / f"{name}.png", response.Responses("IP", "blade_right.tip.x", [curve], [other])
        )
    white = [share(pixels(tmp_path / f"{name}.png"), "#FFFFFF") for name in ("band", "none")]
    assert white[0] < white[1] - 0.005


def test_a_line_is_broken_where_the_branch_was_not_followed():
    curve = softening_curve(force=1.0)
    gap = np.zeros(len(curve), dtype=bool)
    gap[[5, 6]] = True
    runs = list(branch_lines._runs(replace(curve, after_gap=gap), None))
    assert runs == [(0, 4, State.STABLE), (6, len(curve) - 1, State.STABLE)]


@pytest.mark.usefixtures("png_alone")
def test_levels_that_coincide_are_all_seen_and_the_response_without_damper_is_beside_them(tmp_path):
    """The lower force is drawn wider; the frame of the resonances leaves out what is low."""
    curves = [softening_curve(force=force) for force in (2.0, 1.0)]
    alone = response.LinearResponse(np.linspace(200.0, 430.0, 50), np.full(50, 1e-7 + 0j))
    drawn = response.Responses("IP", "blade_right.tip.x", curves, alone=alone)
    (low, _, wide), (high, _, fine) = drawn.levels()
    assert (low.force, high.force) == (1.0, 2.0)
    assert wide > 1.5 * fine
    low_end, high_end = response._resonances(drawn)
    assert curves[0].frequency[0] <= low_end < 420.0 < high_end <= curves[0].frequency[-1]
    assert response._key_of_marks(drawn)[-1].get_label() == "without damper"
    response.frequency_responses(tmp_path / "frf.png", drawn)
    assert share(pixels(tmp_path / "frf.png"), GREY) > share_without(tmp_path, drawn) + 1e-4


@pytest.mark.usefixtures("png_alone")
def test_a_force_without_curve_has_its_peak_in_its_own_colour_and_within_the_frame(tmp_path):
    """As a quick look has it; the colours of the curves are those that they have with all curves there."""
    curves = [softening_curve(force=force) for force in (0.1, 1.0, 3.0)]
    whole = response.Responses("IP", "blade_right.tip.x", curves)
    peak = variants.PeakPoint(3.0, 417.0, 2e-5, True)
    quick = replace(whole, curves=curves[:2], peaks=[peak], note="not checked: stability")
    assert quick.colours() == whole.colours()
    low, high = response._resonances(quick)
    assert low < 417.0 < high
    assert "peak followed in force, no curve" in [mark.get_label() for mark in response._key_of_marks(quick)]
    colour = to_hex(quick.colours()[3.0])
    assert colour not in [to_hex(one) for _, one, _ in quick.levels()]
    response.frequency_responses(tmp_path / "quick.png", quick)
    assert share(pixels(tmp_path / "quick.png"), colour) > 1e-4, "two diamonds and the key's"


def share_without(folder, drawn):
    response.frequency_responses(folder / "without.png", replace(drawn, alone=None))
    return share(pixels(folder / "without.png"), GREY)


def test_pictures_are_there_as_svg_and_pdf_too_the_same_every_time(tmp_path):
    drawn = response.Responses("IP", "blade_right.tip.x", [softening_curve()])
    for name in ("one", "other"):
        response.frequency_responses(tmp_path / f"{name}.png", drawn)
    for ending, begin in ((".svg", b"<?xml"), (".pdf", b"%PDF")):
        content = (tmp_path / f"one{ending}").read_bytes()
        assert content.startswith(begin)
        assert (tmp_path / f"other{ending}").read_bytes() == content
    assert b"receptance, first harmonic" in (tmp_path / "one.svg").read_bytes(), "text stays text"


def test_a_style_file_of_ones_own_replaces_what_it_states(tmp_path):
    """Read once a process, by whichever picture is drawn first."""
    (tmp_path / "mine.mplstyle").write_text("axes.edgecolor: 112233\nimage.cmap: viridis\n", encoding="utf-8")
    script = "from updamp.pictures import style; print(style.GREY, style.SEQUENTIAL, style.BLUE, style.style_key())"

    def told(own):
        environment = {**os.environ, style.OWN_STYLE: own}
        run = subprocess.run([sys.executable, "-c", script], env=environment, capture_output=True, text=True)
        return run.returncode, run.stdout.split(), run.stderr

    code, (grey, levels, blue, key), _ = told(str(tmp_path / "mine.mplstyle"))
    assert (code, grey, levels, blue) == (0, "#112233", "viridis", BLUE)
    assert key != style.style_key(), "pictures of another style are drawn again"
    code, _, error = told(str(tmp_path / "none.mplstyle"))
    assert code == 1
    assert "none.mplstyle: there is no such file" in error


@pytest.mark.usefixtures("png_alone")
def test_damper_motion_translates_in_one_mode_and_rolls_in_the_other(tmp_path, rig):
    curves = {mode: (softening_curve(mode), 100) for mode in ("OOP", "IP")}
    kinematics.damper_kinematics(tmp_path / "motion.png", rig, list(curves.values()))
    assert share(pixels(tmp_path / "motion.png"), "#FFFFFF") < 0.98
    oop, ip = (kinematics.damper_motion(curve, place) for curve, place in curves.values())
    np.testing.assert_allclose(oop["left.x"], oop["right.x"])
    np.testing.assert_allclose(ip["left.y"], -ip["right.y"])
    # softening_curve: amplitude 1e-5 m times the share of the point, and 5 % of third harmonic in phase at its peak
    assert oop["left.x"].max() == pytest.approx(0.3 * 1e-5, rel=0.06)


def test_the_mean_position_is_no_part_of_an_orbit():
    curve = softening_curve("IP")
    curve.response[:, :, 0] = 1.0
    assert max(np.abs(values).max() for values in kinematics.damper_motion(curve, 50).values()) < 1e-4


def test_missing_system_libraries_are_named_before_anything_crashes(tmp_path, rig_mesh, monkeypatch):
    monkeypatch.setattr(scene, "LIBRARIES", {"libc.so.6": "libc6", "libnowhere.so.7": "libnowhere7"})
    with pytest.raises(scene.RenderingError, match=r"libnowhere\.so\.7 missing; apt-get install libnowhere7 \(Debian"):
        bodies.mesh(tmp_path / "mesh.png", rig_mesh)
    assert list(tmp_path.iterdir()) == []


def test_a_flat_line_is_not_at_the_edge_of_the_picture():
    ax = Figure().subplots()
    ax.plot([1, 2], [3.0, 3.0])
    ax.set_ylim(bottom=0)
    assert ax.get_ylim()[1] < 1.06 * 3, "what matplotlib does by itself"
    variants.from_zero(ax)
    assert ax.get_ylim() == pytest.approx((0, 1.08 * 3))


def test_peaks_beyond_the_forces_that_the_resonance_was_followed_in_are_drawn_alone(tmp_path):
    """A run may ask for forces above all levels of the rig file."""
    force, of_points = np.array([0.1, 1.0, 4.0]), np.full(3, 0.01)
    response = np.column_stack([0 * force, 1e-5 * force, 0 * force])
    none = np.zeros(3, int)
    followed = ResonanceCurve(
        "OOP", "tip", (0, 1), force, 440 + force, response, np.zeros((3, 0, 3)),
        of_points, of_points, of_points, of_points,
        np.zeros((3, 4), int), none == 0, none > 0, none, none, of_points, True, "", 0.0,
    )  # fmt: skip
    for asked in (10.0, 1.0):
        peak = variants.PeakPoint(asked, 441.0, 1e-5, True)
        resonance_against_force(tmp_path / f"{asked:g}.png", "OOP", followed, [peak])
        assert (tmp_path / f"{asked:g}.png").stat().st_size > 1000
