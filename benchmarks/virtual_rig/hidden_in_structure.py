"""Effects in blades, clamps, wires and shaker."""

from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from updamp.benchmarks.virtual_rig.bench import (
    STRENGTHS,
    Bench,
    BenchAttachment,
    BenchElement,
    HiddenEffect,
    PointForce,
    Values,
    strengths,
    wires,
)
from updamp.rig.rig import Rig

Floats = NDArray[np.float64]
TIPS = ("blade_left.tip.x", "blade_right.tip.x")


def wire_stiffness(bench: Bench, values: Values, rig: Rig) -> Bench:
    """A factor on the axial stiffness of both wires"""
    others = tuple(a for a in bench.attachments if not a.name.startswith("wire_"))
    return replace(bench, attachments=(*wires(rig, values["factor"]), *others))


def shaker_attachment(bench: Bench, values: Values, _rig: Rig) -> Bench:
    """Mass, spring and dashpot to the ground at the excitation point"""

    def dynamic_stiffness(w: float) -> complex:
        return values["stiffness"] + 1j * w * values["dashpot"] - w**2 * values["mass"]

    return bench.with_attachment(BenchAttachment("shaker", {bench.excitation: 1.0}, dynamic_stiffness))


def clamp_flexibility(bench: Bench, values: Values, _rig: Rig) -> Bench:
    """Both roots turn about z by the compliance times the moment"""
    return replace(bench, clamp_compliance=values["compliance"])


def blade_mistuning(bench: Bench, values: Values, _rig: Rig) -> Bench:
    """Young's moduli such that the right blade's frequencies are times 1 + d/2, the left one's times 1 - d/2"""
    d = values["difference"]
    return bench.tuned(blade_right=1 + d / 2, blade_left=1 - d / 2)


def material_damping(bench: Bench, values: Values, _rig: Rig) -> Bench:
    """Each blade's loss factor times 1 + b A / 1 mm, A the amplitude of its tip"""
    return replace(bench, loss_growth=values["growth"] / 1e-3)


def at_both_tips(bench: Bench, name: str, force: PointForce) -> Bench:
    return bench.with_element(*(BenchElement(f"{name} {tip}", {tip: 1.0}, force) for tip in TIPS))


def cubic(coefficient: float) -> PointForce:
    def force(u: Floats, v: Floats) -> tuple[Floats, Floats, Floats]:
        return coefficient * u**3, 3 * coefficient * u**2, np.zeros_like(v)

    return force


def blade_cubic_stiffness(bench: Bench, values: Values, _rig: Rig) -> Bench:
    """A cubic spring at both tips"""
    return at_both_tips(bench, "cubic", cubic(values["coefficient"]))


def beyond(dashpot: float, threshold: float) -> PointForce:
    def force(u: Floats, v: Floats) -> tuple[Floats, Floats, Floats]:
        size = np.abs(u)
        out = size > threshold
        share = threshold / np.where(out, size, threshold)
        return (
            dashpot * v * (1 - share),
            np.where(out, dashpot * v * share**2 * np.sign(u) / threshold, 0.0),
            dashpot * (1 - share),
        )

    return force


def threshold_damping(bench: Bench, values: Values, _rig: Rig) -> Bench:
    """c v (1 - a / |u|) at both tips while |u| is above a"""
    return at_both_tips(bench, "threshold", beyond(values["dashpot"], values["threshold"]))


def shaker(mass: float, stiffness: float, dashpot: float) -> dict[str, float]:
    return {"mass": mass, "stiffness": stiffness, "dashpot": dashpot}


EFFECTS = (
    HiddenEffect("wire_stiffness", "wires stiffer than stated", strengths("factor", 5, 15, 40), wire_stiffness),
    HiddenEffect(
        "shaker_attachment", "the shaker adds mass, stiffness and damping",
        {"weak": shaker(0.2, 5e4, 200), "medium": shaker(0.5, 1e5, 500), "strong": shaker(0.8, 1e5, 800)},
        shaker_attachment,
    ),
    HiddenEffect("clamp_flexibility", "the roots turn", strengths("compliance", 2e-6, 6e-6, 1.5e-5), clamp_flexibility),
    HiddenEffect("blade_mistuning", "blades are not alike", strengths("difference", 0.002, 0.005, 0.015),
                 blade_mistuning),
    HiddenEffect("material_damping", "material damping grows with amplitude", strengths("growth", 5, 15, 50),
                 material_damping),
    HiddenEffect("blade_cubic_stiffness", "blades stiffen with amplitude", strengths("coefficient", 5e11, 2e12, 8e12),
                 blade_cubic_stiffness),
    HiddenEffect(
        "threshold_damping", "a loss sets in above an amplitude",
        {name: {"dashpot": c, "threshold": 7e-6} for name, c in zip(STRENGTHS, (1.0, 3.0, 10.0), strict=True)},
        threshold_damping,
    ),
)  # fmt: skip
