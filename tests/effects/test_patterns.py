"""What single effects do to the contacts, the structure and the tips, against their definitions."""

from dataclasses import replace

import numpy as np
import pytest
from scipy.special import gamma
from support.plain_rig import SHORT_FACES, SLIPPING, plain_model

from updamp.effects.catalogue import CATALOGUE
from updamp.effects.contact_faces import along_damper, up_the_face
from updamp.effects.edge_gap import approach, profile
from updamp.effects.material_damping import PER, bending_modes
from updamp.effects.structure import TIPS
from updamp.geometry.contact_elements import LEFT, RIGHT
from updamp.hbm.problem.elements import over_period
from updamp.model.calibration import PRELOAD


def changed(model, name, **values):
    return CATALOGUE[name].apply(model, values)


def entry(model, name):
    return np.asarray(getattr(model.contacts.parameters, name))


@pytest.mark.parametrize("crown", [0.8, -1.0])
def test_crown_keeps_each_face_s_load(model, crown):
    before, after = entry(model, "n0"), entry(changed(model, "pressure_crown", crown=crown), "n0")
    s = along_damper(model.patches)
    assert 0.8 < np.abs(s).max() < 1
    for side in (LEFT, RIGHT):
        on = model.patches.face == side
        assert after[on].sum() == pytest.approx(before[on].sum())
        share = after[on] / before[on] / (1 + crown * (1 / 3 - s[on] ** 2))
        np.testing.assert_allclose(share, share[0])


def test_slope_and_asymmetry_and_gradient_are_linear(model):
    patches, n0, mu = model.patches, entry(model, "n0"), entry(model, "mu")
    half_width = np.abs(patches.triangle[..., 2]).max()
    np.testing.assert_allclose(
        entry(changed(model, "pressure_slope", slope=0.5), "n0") / n0, 1 + 0.5 * patches.point[:, 2] / half_width
    )
    unequal = entry(changed(model, "asymmetric_preload", asymmetry=0.2), "n0") / n0
    np.testing.assert_allclose(unequal, np.where(patches.face == LEFT, 0.8, 1.2))
    graded = entry(changed(model, "friction_gradient", gradient=0.4), "mu") / mu
    up = patches.point[:, 1]
    for side in (LEFT, RIGHT):  # the upper edge of the face is the upper one of the rig
        on = patches.face == side
        assert np.corrcoef(graded[on], up[on])[0, 1] > 0.999
    assert graded.max() - 1 == pytest.approx(1 - graded.min())
    # centroids of triangles half a face high, moved out until their second moment, 5 / 18, is the face's, a third
    assert np.abs(up_the_face(patches)).max() == pytest.approx(2 / 3 * (6 / 5) ** 0.5)


def test_edge_gap_is_refused_where_no_contact_element_lies_at_an_edge_alone():
    """One strip: upright and turned triangles from edge to edge lose the same, which taking up the load makes none."""
    one_strip = plain_model(SHORT_FACES, {**SLIPPING, "mesh.small.contact_strips": 1})
    with pytest.raises(ValueError, match=r"reaches from the upper to the lower edge.*contact_strips = 2"):
        changed(one_strip, "edge_gap", depth=1e-6)


def test_edge_gap_keeps_each_face_s_load_and_takes_it_off_the_edges(model):
    """Small: n0 falls in proportion to the gap less its mean; large: edges are open, by what is left of it."""
    kn, n0, gap = entry(model, "kn"), entry(model, "n0"), profile(model.patches)
    for depth in (1e-9, 2e-6):
        after = changed(model, "edge_gap", depth=depth)
        for side in (LEFT, RIGHT):
            on = model.patches.face == side
            assert entry(after, "n0")[on].sum() == pytest.approx(n0[on].sum())
        if depth < 1e-8:
            mean = (kn * gap).sum() / kn.sum()
            np.testing.assert_allclose(entry(after, "n0") - n0, kn * depth * (mean - gap), atol=1e-6 * n0.max())
            assert not entry(after, "gap").any()
        else:
            open_ = entry(after, "gap") > 0
            assert open_.any()
            assert not entry(after, "n0")[open_].any()
            lower = gap[~open_].max()
            assert (gap[open_] > lower).all()


def test_profile_is_the_mean_over_the_patch(model):
    """Against a million places of the whole face: areas times means add up to 1/6 of the face's area."""
    patches = model.patches
    for side in (LEFT, RIGHT):
        on = patches.face == side
        mean = (profile(patches)[on] * patches.area[on]).sum() / patches.area[on].sum()
        s = np.linspace(-1, 1, 1_000_001)
        assert mean == pytest.approx((np.maximum(2 * np.abs(s) - 1, 0) ** 2).mean(), rel=0.01)


def test_approach_balances_the_load():
    rng = np.random.default_rng(9)
    opening, stiffness = rng.normal(size=20), rng.uniform(0.5, 2.0, 20)
    for total in (1e-6, 0.3, 5.0, 200.0):
        d = approach(opening, stiffness, total)
        assert (stiffness * np.maximum(d - opening, 0)).sum() == pytest.approx(total)


def test_stiffness_at_rest_follows_the_pressure(model):
    """A crowned face: stuck stiffness of each patch is k0 (p/p0)^m; over a uniform one it stays."""
    m = 0.4
    uniform = changed(model, "pressure_dependent_stiffness", exponent=m)
    np.testing.assert_allclose(uniform.system.stuck.frequencies, model.system.stuck.frequencies, rtol=1e-9)
    crowned = changed(model, "pressure_crown", crown=0.8)
    both = changed(crowned, "pressure_dependent_stiffness", exponent=m)
    pressure = entry(crowned, "n0") / model.patches.area
    mean = entry(crowned, "n0").sum() / model.patches.area.sum()
    expected = entry(model, "kt") * (pressure / mean) ** m
    np.testing.assert_allclose(both.contacts.reference_stiffness()[:, 0], expected)


def test_more_preload_is_more_stiffness(model):
    """kt and kn are stated at the pressure of the rig file, to which a changed preload makes no difference."""
    m, load = 0.4, 1.3
    loaded = changed(PRELOAD.apply(model, load), "pressure_dependent_stiffness", exponent=m)
    np.testing.assert_allclose(loaded.contacts.reference_stiffness()[:, 0], entry(model, "kt") * load**m)


def test_mistuning_moves_the_blades_apart_and_keeps_their_loss_factor(model):
    apart = changed(model, "blade_mistuning", difference=0.02).components
    before, owner = model.components, np.array(model.owner)
    factor = np.select([owner == "blade_left", owner == "blade_right"], [0.99, 1.01], 1.0)
    np.testing.assert_allclose(np.sqrt(apart.omega_squared), np.sqrt(before.omega_squared) * factor)
    elastic = before.omega_squared > 0
    np.testing.assert_allclose(
        np.diag(apart.hysteretic)[elastic] / apart.omega_squared[elastic],
        np.diag(before.hysteretic)[elastic] / before.omega_squared[elastic],
    )


def test_wires_and_shaker_are_attachments(model):
    stiff = changed(model, "wire_stiffness", factor=3.0)
    ratio = [b.stiffness / a.stiffness for a, b in zip(model.attachments, stiff.attachments, strict=True)]
    assert sorted(ratio) == [1.0] * 5 + [3.0] * 2
    shaken = changed(model, "shaker_attachment", mass=0.1, stiffness=1e5, dashpot=3.0)
    *same, shaker = shaken.attachments
    assert tuple(same) == model.attachments
    assert (shaker.points, shaker.mass, shaker.stiffness, shaker.dashpot) == ({model.excitation: 1.0}, 0.1, 1e5, 3.0)


def test_tip_dampers_lose_what_the_loss_factor_asks_for(model):
    """Work a cycle of the dampers in each of the two bending modes, over pi h q^2: growth x amplitude."""
    growth, q = 10.0, 1e-5
    stuck = model.system.stuck
    group = changed(model, "material_damping", growth=growth).system.groups[1]
    of_blades = np.array([owner != "damper" for owner in model.owner])
    hysteretic = model.components.hysteretic * np.outer(of_blades, of_blades)
    blades = replace(model, components=replace(model.components, hysteretic=hysteretic)).system.stuck.hysteretic
    for mode in bending_modes(stuck):
        tips = q * stuck.phi[[stuck.row(tip) for tip in TIPS], mode]
        w = np.sqrt(stuck.omega_squared[mode])
        motion = np.zeros((1, 2, 6))
        motion[0, :, 0] = tips
        _, power = over_period(group, _power(group.law), motion, w, model.harmonics, 512)
        work = power.sum(axis=(0, 2)).mean() * 2 * np.pi / w
        ratio = work / (np.pi * blades[mode, mode] * q**2) / (growth * np.abs(tips).mean() / PER)
        assert ratio == pytest.approx(1.0, rel=0.001)


def work_of(group, amplitudes, w, harmonics):
    """A cycle's work of an element whose directions move in phase by these amplitudes [J]."""
    motion = np.zeros((1, len(amplitudes), harmonics.n_coefficients))
    motion[0, :, 0] = amplitudes
    _, power = over_period(group, _power(group.law), motion, w, harmonics, 4096)
    return power.sum(axis=(0, 2)).mean() * 2 * np.pi / w


def test_tips_lose_to_a_power_of_the_velocity_what_the_closed_form_says(model):
    w, A, p = 2700.0, 3e-5, 1.8
    groups = changed(model, "power_law_damping", force=0.4, exponent=p).system.groups[1:]
    assert [group.rows.tolist() for group in groups] == [[[108]], [[109]]]
    expected = 0.4 * A * (w * A / 0.1) ** p * 2 * np.sqrt(np.pi) * gamma(p / 2 + 1) / gamma(p / 2 + 1.5)
    for group in groups:
        assert work_of(group, [A], w, model.harmonics) == pytest.approx(expected, rel=1e-5)


def test_each_tip_loses_to_its_own_friction_and_platforms_to_their_relative_motion(model):
    """Four times force and amplitude where the motion is fast; nothing where both platforms move alike."""
    w, A = 2700.0, 1e-4
    left, right = changed(model, "tip_friction", left=0.01, right=0.03).system.groups[1:]
    assert work_of(left, [A], w, model.harmonics) == pytest.approx(4 * 0.01 * A, rel=1e-3)
    assert work_of(right, [A], w, model.harmonics) == pytest.approx(4 * 0.03 * A, rel=1e-3)
    rubbing = changed(model, "platform_friction", force=0.2)
    assert rubbing.elements[0].points == ("blade_left.platform.x", "blade_right.platform.x")
    (group,) = rubbing.system.groups[1:]
    assert work_of(group, [A, -A / 2], w, model.harmonics) == pytest.approx(4 * 0.2 * 1.5 * A, rel=1e-3)
    assert abs(work_of(group, [A, A], w, model.harmonics)) < 1e-12 * A


def test_friction_by_face_goes_opposite_ways_and_leaves_the_preload(model):
    unequal = changed(model, "friction_by_face", difference=0.3)
    ratio = entry(unequal, "mu") / entry(model, "mu")
    np.testing.assert_allclose(ratio, np.where(model.patches.face == LEFT, 0.7, 1.3))
    np.testing.assert_array_equal(entry(unequal, "n0"), entry(model, "n0"))


def test_friction_runs_in_about_the_middle_of_a_test(model):
    running_in = changed(changed(model, "friction_running_in", growth=0.3), "friction_running_in", growth=0.1)
    for place, factor in ((-0.5, np.exp(-0.2)), (0.0, 1.0), (0.25, np.exp(0.1)), (0.5, np.exp(0.2))):
        there = running_in.in_run(place)
        np.testing.assert_allclose(entry(there, "mu"), factor * entry(model, "mu"), rtol=1e-14)
        np.testing.assert_array_equal(entry(there, "n0"), entry(model, "n0"))
        assert there.in_run(place) is there
    assert model.in_run(0.5) is model


@pytest.mark.parametrize("name", ["power_law_damping", "tip_friction", "platform_friction"])
def test_effects_at_points_name_the_point_that_is_missing(model, name):
    points = model.components.points
    renamed = tuple(
        point.replace("right.tip", "right.top").replace("right.platform", "right.ledge") for point in points
    )
    without = replace(model, components=replace(model.components, points=renamed))
    with pytest.raises(ValueError, match=r"the model has no blade_right\.(tip|platform)\.x$"):
        changed(without, name, **CATALOGUE[name].at_typical())


def _power(law):
    return lambda u, v, p: law.force(u, v, p) * v


@pytest.mark.parametrize("name", ["edge_gap", "sub_patch_microslip", "pressure_dependent_stiffness"])
def test_effects_of_the_contact_say_when_there_is_none(model, name):
    with pytest.raises(ValueError, match="leave the effect out"):
        CATALOGUE[name].apply(replace(model, contacts=None, patches=None), CATALOGUE[name].at_typical())
