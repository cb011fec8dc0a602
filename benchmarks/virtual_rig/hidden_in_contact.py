"""Effects in the contact. Places: `along` the damper and `up` the face, each from -1 to 1 between the edges."""

from dataclasses import replace

import numpy as np
from numpy.typing import NDArray
from scipy.optimize import brentq

from updamp.benchmarks.virtual_rig.bench import Bench, HiddenEffect, Values, strengths
from updamp.rig.rig import Rig

Floats = NDArray[np.float64]


def _each_face_as_before(bench: Bench, n0: Floats) -> Bench:
    """The pull is what it is, and so is what each face carries."""
    carried = n0.copy()
    for side in (0, 1):
        on = bench.bodies.face == side
        carried[on] *= bench.patches.n0[on].sum() / n0[on].sum()
    return bench.with_patches(n0=carried)


def pressure_crown(bench: Bench, values: Values, _rig: Rig) -> Bench:
    """n0 (1 + c (1/3 - s^2)), s along the damper"""
    s = bench.bodies.at_points(bench.bodies.along)
    return _each_face_as_before(bench, bench.patches.n0 * np.maximum(1 + values["crown"] * (1 / 3 - s**2), 0))


def pressure_slope(bench: Bench, values: Values, _rig: Rig) -> Bench:
    """n0 (1 + slope s), s along the damper"""
    return bench.with_patches(n0=bench.patches.n0 * (1 + values["slope"] * bench.bodies.at_points(bench.bodies.along)))


def asymmetric_preload(bench: Bench, values: Values, _rig: Rig) -> Bench:
    """Left face n0 (1 - a), right face n0 (1 + a)"""
    a = values["asymmetry"]
    return bench.with_patches(n0=bench.patches.n0 * np.where(bench.bodies.face == 0, 1 - a, 1 + a))


def pressure_dependent_stiffness(bench: Bench, values: Values, _rig: Rig) -> Bench:
    """kt and kn times (p / p0)^m, p the momentary pressure, p0 its mean at rest"""
    area = bench.bodies.area
    return bench.with_patches(exponent=values["exponent"], stated_at=bench.patches.n0.sum() / area.sum() * area)


def contact_viscosity(bench: Bench, values: Values, _rig: Rig) -> Bench:
    """Dashpots of c times the area in all three directions while in contact"""
    return bench.with_patches(viscosity=values["viscosity"] * bench.bodies.area)


def velocity_dependent_friction(bench: Bench, values: Values, _rig: Rig) -> Bench:
    """mu (1 - d |v| / (|v| + v0)), v0 = 0.1 mm/s: contacts of this rig reach twice that"""
    return bench.with_patches(speed_drop=values["drop"], speed_scale=1e-4)


def sub_patch_microslip(bench: Bench, values: Values, _rig: Rig) -> Bench:
    """Ten Jenkins elements side by side, limits spread evenly over mu N (1 - w) to mu N (1 + w)"""
    return bench.with_patches(spread=values["spread"])


def friction_gradient(bench: Bench, values: Values, _rig: Rig) -> Bench:
    """mu (1 + g s), s up the face"""
    return bench.with_patches(mu=bench.patches.mu * (1 + values["gradient"] * bench.bodies.at_points(bench.bodies.up)))


def friction_by_face(bench: Bench, values: Values, _rig: Rig) -> Bench:
    """Left face mu (1 - d), right face mu (1 + d)"""
    d = values["difference"]
    return bench.with_patches(mu=bench.patches.mu * np.where(bench.bodies.face == 0, 1 - d, 1 + d))


def friction_running_in(bench: Bench, values: Values, _rig: Rig) -> Bench:
    """mu exp(growth s), s from -1/2 in an assembly's first run to 1/2 in its last"""
    return replace(bench, running_in=values["growth"])


def edge_gap(bench: Bench, values: Values, _rig: Rig) -> Bench:
    """Upper and lower edges are rounded: a gap of depth ((|s| - 1/2) / (1/2))^2 beyond |s| = 1/2, s up the face, on top
    of the shape that spreads the load as it was. Each face is pressed on until it carries what it carried before."""
    weights = np.random.default_rng(1).dirichlet((1, 1, 1), size=4000)  # places all over a triangle
    s = bench.bodies.up @ weights.T
    gap = values["depth"] * (np.maximum(2 * np.abs(s) - 1, 0) ** 2).mean(axis=1)
    p, n0, left = bench.patches, np.empty_like(gap), np.empty_like(gap)
    gap += p.gap - p.n0 / p.kn
    for side in (0, 1):
        on = bench.bodies.face == side
        total, kn = p.n0[on].sum(), p.kn[on]

        def missing(way: float, kn: Floats = kn, gap: Floats = gap[on], total: float = total) -> float:
            return float(total - (kn * np.maximum(way - gap, 0)).sum())

        way = brentq(missing, gap[on].min(), gap[on].max() + total / kn.min(), xtol=1e-16)
        n0[on], left[on] = kn * np.maximum(way - gap[on], 0), np.maximum(gap[on] - way, 0)
    return bench.with_patches(n0=n0, gap=left)


def static_dynamic_coupling(bench: Bench, values: Values, _rig: Rig) -> Bench:
    """The mean position is free, and the contacts see a share of where it goes"""
    return replace(bench, mean_share=values["share"])


EFFECTS = (
    HiddenEffect("pressure_crown", "load in the middle", strengths("crown", 0.8, 1.1, 1.3), pressure_crown),
    HiddenEffect("pressure_slope", "one end pressed harder", strengths("slope", 0.3, 0.6, 0.9), pressure_slope),
    HiddenEffect("asymmetric_preload", "one face carries more", strengths("asymmetry", 0.1, 0.25, 0.5),
                 asymmetric_preload),
    HiddenEffect(
        "pressure_dependent_stiffness", "stiffness grows with pressure",
        strengths("exponent", 0.2, 0.4, 0.58), pressure_dependent_stiffness,
    ),
    HiddenEffect("static_dynamic_coupling", "the mean position gives way", strengths("share", 0.2, 0.5, 1.0),
                 static_dynamic_coupling),
    HiddenEffect("contact_viscosity", "a film in the contact", strengths("viscosity", 1e8, 4e8, 1.5e9),
                 contact_viscosity),
    HiddenEffect("velocity_dependent_friction", "friction falls with speed", strengths("drop", 0.15, 0.35, 0.6),
                 velocity_dependent_friction),
    HiddenEffect("sub_patch_microslip", "slip begins early within patches", strengths("spread", 0.6, 0.8, 1.0),
                 sub_patch_microslip),
    HiddenEffect("friction_gradient", "friction varies up the face", strengths("gradient", 0.25, 0.5, 0.9),
                 friction_gradient),
    HiddenEffect("edge_gap", "edges of the faces are rounded", strengths("depth", 5e-8, 1e-7, 2e-7), edge_gap),
    HiddenEffect("friction_by_face", "one face rubs more than the other", strengths("difference", 0.15, 0.3, 0.6),
                 friction_by_face),
    HiddenEffect("friction_running_in", "friction changes from run to run", strengths("growth", 0.15, 0.3, 0.6),
                 friction_running_in),
)  # fmt: skip
