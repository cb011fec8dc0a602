"""Dimensions of the bench that are other than its rig file says."""

from functools import partial

from updamp.benchmarks.virtual_rig.bench import Bench, HiddenEffect, Values, bench_of, strengths
from updamp.benchmarks.virtual_rig.bodies import bodies_of
from updamp.rig.dimensions import DIMENSIONS
from updamp.rig.rig import Rig


def rebuilt(name: str, bench: Bench, values: Values, rig: Rig) -> Bench:
    """Bodies, contacts and wires of a rig with the dimension times 1 + change, on the same mesh; what an assembly has
    drawn stays as factors. They come before all else that is hidden, which acts on what stands there then.

    rig: as its file says; the bench may have another of its dimensions changed already
    """
    known = bench.changes or {}
    before, after = (_changed(rig, changes) for changes in (known, {**known, name: values["change"]}))
    old, new = bench_of(before, bench.bodies).patches, bench_of(after, bodies_of(after, bench.bodies.preset))
    p, q = bench.patches, new.patches
    there = bench.with_patches(kt=p.kt * q.kt / old.kt, kn=p.kn * q.kn / old.kn, n0=p.n0 * q.n0 / old.n0)
    return there.standing_on(new.bodies, new.attachments, {**known, name: values["change"]})


def _changed(rig: Rig, changes: Values) -> Rig:
    for name, change in changes.items():
        rig = DIMENSIONS[name].changed(rig, change)
    return rig


EFFECTS = (
    HiddenEffect(
        "face_length", "the damper's faces are longer than stated", strengths("change", 0.03, 0.06, 0.12),
        partial(rebuilt, "face_length"),
    ),
    HiddenEffect(
        "platform_height", "the platforms are higher than stated", strengths("change", 0.005, 0.01, 0.02),
        partial(rebuilt, "platform_height"),
    ),
    HiddenEffect(
        "blade_thickness", "the blades are thicker than stated", strengths("change", 0.005, 0.01, 0.02),
        partial(rebuilt, "blade_thickness"),
    ),
    HiddenEffect(
        "face_angle", "the faces are steeper than stated", strengths("change", 0.03, 0.05, 0.09),
        partial(rebuilt, "face_angle"),
    ),
)  # fmt: skip
