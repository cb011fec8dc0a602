"""Effects that updamp's catalogue does not know: the right answer is that none of its effects explains them."""

from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from updamp.benchmarks.virtual_rig.bench import (
    Bench,
    BenchAttachment,
    BenchElement,
    HiddenEffect,
    PointForce,
    Values,
    strengths,
)
from updamp.benchmarks.virtual_rig.hidden_in_structure import TIPS
from updamp.rig.rig import Rig

Floats = NDArray[np.float64]


def drag(coefficient: float) -> PointForce:
    def force(u: Floats, v: Floats) -> tuple[Floats, Floats, Floats]:
        return coefficient * np.abs(v) * v, np.zeros_like(u), 2 * coefficient * np.abs(v)

    return force


def quadratic_damping(bench: Bench, values: Values, _rig: Rig) -> Bench:
    """c |v| v at both tips, as of air or a fluid [N s^2/m^2]"""
    return bench.with_element(*(BenchElement(f"drag {tip}", {tip: 1.0}, drag(values["coefficient"])) for tip in TIPS))


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


def absorber(mass: float) -> dict[str, float]:
    return {"mass": mass, "frequency": 430.0}


EFFECTS = tuple(
    replace(effect, in_catalogue=False)
    for effect in (
        HiddenEffect("quadratic_damping", "drag", strengths("coefficient", 10, 40, 150), quadratic_damping),
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
    )
)  # fmt: skip
