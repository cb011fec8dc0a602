"""Effects hidden as unknown to updamp's catalogue: the right answer is that none of its effects explains them, or, of
those whose law the catalogue has got since under another name, that name."""

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
    Renamed,
    Values,
    spring,
    strengths,
)
from updamp.benchmarks.virtual_rig.hidden_in_structure import TIPS, at_both_tips
from updamp.rig.rig import Rig

Floats = NDArray[np.float64]


def drag(coefficient: float) -> PointForce:
    def force(u: Floats, v: Floats) -> tuple[Floats, Floats, Floats]:
        return coefficient * np.abs(v) * v, np.zeros_like(u), 2 * coefficient * np.abs(v)

    return force


def quadratic_damping(bench: Bench, values: Values, _rig: Rig) -> Bench:
    """c |v| v at both tips, as of air or a fluid [N s^2/m^2]"""
    return at_both_tips(bench, "drag", drag(values["coefficient"]))


def force_drop_off(bench: Bench, values: Values, _rig: Rig) -> Bench:
    """Near resonance less force reaches the blade than is recorded: `stepped_sine.force_on_blade`"""
    return replace(bench, force_drop=values["drop"])


def loose_sensor_gain(bench: Bench, values: Values, _rig: Rig) -> Bench:
    """The left tip's reading shrinks with its amplitude: `sensors.loose`"""
    return replace(bench, loose_gain=values["gain"])


def stop(stiffness: float, gap: float) -> PointForce:
    def force(u: Floats, v: Floats) -> tuple[Floats, Floats, Floats]:
        way = np.maximum(u - gap, 0.0)
        return stiffness * way, np.where(way > 0, stiffness, 0.0), np.zeros_like(v)

    return force


def second_damper_contact(bench: Bench, values: Values, _rig: Rig) -> Bench:
    """The damper's right bottom corner strikes the blade beside it once it has come closer by the gap"""
    closer = {"damper.corner_right.x": 1.0, "blade_right.platform.x": -1.0}
    return bench.with_element(BenchElement("stop", closer, stop(values["stiffness"], values["gap"])))


def absorber_mass(bench: Bench, values: Values, _rig: Rig) -> Bench:
    """A mass on a spring at the left tip, such as a cable or a loose fitting; loss factor 1 %"""
    mass, k = values["mass"], values["mass"] * (2 * np.pi * values["frequency"]) ** 2 * (1 + 0.01j)

    def dynamic_stiffness(w: float) -> complex:
        return complex(-(w**2) * mass * k / (k - w**2 * mass))

    return bench.with_attachment(BenchAttachment("absorber", {TIPS[0]: 1.0}, dynamic_stiffness))


def rub(force: float, creep: float) -> PointForce:
    """Dry friction, of which no stick is left: force times tanh(v / creep)"""

    def on_velocity(u: Floats, v: Floats) -> tuple[Floats, Floats, Floats]:
        share = np.tanh(v / creep)
        return force * share, np.zeros_like(u), force * (1 - share**2) / creep

    return on_velocity


def rubbing_cable(bench: Bench, values: Values, _rig: Rig) -> Bench:
    """A sensor's cable rubs at the left tip [N]"""
    return bench.with_element(BenchElement("cable", {TIPS[0]: 1.0}, rub(values["force"], 5e-4)))


def platform_rub(bench: Bench, values: Values, _rig: Rig) -> Bench:
    """The platforms rub against each other across the gap [N]"""
    across = {"blade_right.platform.x": 1.0, "blade_left.platform.x": -1.0}
    return bench.with_element(BenchElement("rub", across, rub(values["force"], 5e-5)))


def tip_coupling(bench: Bench, values: Values, _rig: Rig) -> Bench:
    """A spring between the two tips [N/m]"""
    between = {TIPS[0]: 1.0, TIPS[1]: -1.0}
    return bench.with_attachment(spring("tip_coupling", between, values["stiffness"]))


def tip_stop(bench: Bench, values: Values, _rig: Rig) -> Bench:
    """The right tip strikes something beside it once it has come closer by the gap"""
    return bench.with_element(BenchElement("tip_stop", {TIPS[1]: 1.0}, stop(values["stiffness"], values["gap"])))


def cracked_blade(bench: Bench, values: Values, _rig: Rig) -> Bench:
    """The left blade loses stiffness once its tip has bent by the opening"""
    lost = stop(-values["stiffness"], values["opening"])
    return bench.with_element(BenchElement("crack", {TIPS[0]: 1.0}, lost))


def in_displacement(on_velocity: PointForce) -> PointForce:
    """The same law in the displacement that another one has in the velocity."""

    def force(u: Floats, v: Floats) -> tuple[Floats, Floats, Floats]:
        value, by_other, by_own = on_velocity(v, u)
        return value, by_own, by_other

    return force


def saturating_spring(bench: Bench, values: Values, _rig: Rig) -> Bench:
    """A spring at the left tip that holds no more than stiffness times reach: k r tanh(u / r)"""
    most = in_displacement(rub(values["stiffness"] * values["reach"], values["reach"]))
    return bench.with_element(BenchElement("saturating", {TIPS[0]: 1.0}, most))


def quadratic_stiffness(bench: Bench, values: Values, _rig: Rig) -> Bench:
    """c |u| u at both tips [N/m^2]"""
    return at_both_tips(bench, "quadratic", in_displacement(drag(values["coefficient"])))


def absorber(mass: float) -> dict[str, float]:
    return {"mass": mass, "frequency": 430.0}


def power_law(values: Values) -> Values:
    """Force at 0.1 m/s, where the catalogue states it."""
    return {"force": 0.1**2 * values["coefficient"], "exponent": 2.0}


def left_tip(values: Values) -> Values:
    return {"left": values["force"], "right": 0.0}


def right_tip(values: Values) -> Values:
    return {"left": 0.0, "right": values["stiffness"], "gap": values["gap"]}


def left_blade(values: Values) -> Values:
    return {"left": values["stiffness"], "right": 0.0, "opening": values["opening"]}


EFFECTS = tuple(
    replace(effect, in_catalogue=False)
    for effect in (
        HiddenEffect("quadratic_damping", "drag", strengths("coefficient", 10, 40, 150), quadratic_damping,
                     renamed=Renamed("power_law_damping", power_law)),
        HiddenEffect("force_drop_off", "unrecorded loss of force", strengths("drop", 0.1, 0.25, 0.5), force_drop_off),
        HiddenEffect("loose_sensor_gain", "the left tip's reading shrinks", strengths("gain", 0.1, 0.25, 0.5),
                     loose_sensor_gain),
        HiddenEffect(
            "second_damper_contact", "the damper strikes the blade",
            {
                "weak": {"stiffness": 1e7, "gap": 2e-7},
                "medium": {"stiffness": 3e7, "gap": 2e-7},
                "strong": {"stiffness": 1e8, "gap": 1e-7},
            }, second_damper_contact,
        ),
        HiddenEffect(
            "absorber_mass", "an unknown resonator on the left blade",
            {"weak": absorber(5e-6), "medium": absorber(2e-5), "strong": absorber(1e-4)}, absorber_mass,
        ),
        HiddenEffect("rubbing_cable", "a cable rubs at the left tip", strengths("force", 0.003, 0.01, 0.03),
                     rubbing_cable, renamed=Renamed("tip_friction", left_tip)),
        HiddenEffect("platform_rub", "the platforms rub", strengths("force", 0.05, 0.15, 0.5), platform_rub,
                     renamed=Renamed("platform_friction", dict)),
        HiddenEffect("tip_coupling", "a spring between the tips", strengths("stiffness", 100, 300, 1000), tip_coupling),
        HiddenEffect(
            "tip_stop", "the right tip strikes something",
            {
                "weak": {"stiffness": 1e3, "gap": 1e-5},
                "medium": {"stiffness": 3e3, "gap": 7e-6},
                "strong": {"stiffness": 1e4, "gap": 5e-6},
            }, tip_stop, renamed=Renamed("blade_stop", right_tip),
        ),
        HiddenEffect(
            "cracked_blade", "a crack in the left blade opens",
            {
                "weak": {"stiffness": 1e3, "opening": 1e-5},
                "medium": {"stiffness": 3e3, "opening": 7e-6},
                "strong": {"stiffness": 1e4, "opening": 5e-6},
            }, cracked_blade, renamed=Renamed("breathing_crack", left_blade),
        ),
        HiddenEffect(
            "saturating_spring", "a spring that holds only so much",
            {name: {"stiffness": k, "reach": 3e-6} for name, k in zip(STRENGTHS, (300, 1e3, 3e3), strict=True)},
            saturating_spring,
        ),
        HiddenEffect("quadratic_stiffness", "stiffness grows with amplitude itself",
                     strengths("coefficient", 1e7, 3e7, 1e8), quadratic_stiffness,
                     renamed=Renamed("blade_square_stiffness", dict)),
    )
)  # fmt: skip
