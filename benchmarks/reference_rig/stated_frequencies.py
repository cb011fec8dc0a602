"""The tables of docs/stated_frequencies.md: what could explain the stated frequencies, and what it would do elsewhere.

    .venv/bin/python benchmarks/reference_rig/stated_frequencies.py [--mesh full] [--out FOLDER] [--without EFFECT ...]

`updamp diagnose` says the same of small forces; here no curve is traced. Besides: the low-force frequencies against
contact stiffness, and the resonances at the study's forces of what explains the stated values and of the normal
stiffness that comes nearest (as given they are in results/reference/summary.json).
"""

from updamp.parallel.resources import one_thread

one_thread()  # before numpy is loaded: threads make small products many times slower

import argparse
import sys
import time
from dataclasses import replace
from pathlib import Path

from rich.console import Console

from updamp.api import (
    Model,
    ResonanceOptions,
    build_model,
    catalogue,
    keep_compiled,
    load_measurement,
    resonance,
    response_curve,
)
from updamp.diagnosis.stated.low_force_modes import LowForceModes
from updamp.diagnosis.stated.stated_verdict import survivors_of
from updamp.model.calibration import NORMAL, TANGENTIAL, YOUNGS_MODULUS
from updamp.model.small_amplitude import linear_up_to
from updamp.workflow.diagnose_stated import StatedDiagnosis, diagnose_stated, tables

ROOT = Path(__file__).parents[2]
RIG = ROOT / "rigs" / "pesaresi2017.toml"
MEASURED = ROOT / "rigs" / "pesaresi2017_measured.toml"
FACTORS = (1.0, 0.5, 0.315, 0.2, 0.1, 0.05, 0.02)  # 0.315 explained the first rig's frequencies
MOST_POINTS = 600  # of one resonance: beyond, it turns to and fro among contacts that open and close
WIDTH = 200


def main() -> None:
    reader = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    reader.add_argument("--mesh", default="full")
    reader.add_argument("--out", type=Path, default=ROOT / "results" / "stated_frequencies")
    reader.add_argument("--without", nargs="*", default=[], help="effects not to be tried, alone or in pairs")
    stated, console = reader.parse_args(), Console(width=WIDTH)
    keep_compiled()
    model = build_model(RIG, stated.mesh, stated.out / stated.mesh)
    effects = tuple(effect for name, effect in catalogue().items() if name not in stated.without)
    found = diagnose_stated(
        model.parts, model.modes, model.response_point.partition(".")[0], load_measurement(MEASURED).features, effects,
        progress=lambda at: print(f"{time.process_time():.0f} s of processor time: {at}", file=sys.stderr, flush=True),
    )  # fmt: skip
    console.print(f"{found.verdict.verdict}: {found.verdict.sentence}")
    for table in tables(found):
        console.print(table)
    console.print("does not move any of them:", ", ".join(found.found.still))
    for name, why in found.found.without_place.items():
        console.print(f"{name}: {why}")
    softer(console, model, found.problem.modes)
    for name, one in explained(model, found):
        console.print(name)
        for mode in model.modes:
            at_forces(console, one, mode, found.problem.modes)


def softer(console: Console, model: Model, modes: LowForceModes) -> None:
    """Low-force frequencies [Hz] where contacts, or all of the material, are softer."""
    names = tuple(model.modes)
    console.print("factor:", ", ".join(f"{mode} with kn, kt, both; E" for mode in names))
    for factor in FACTORS:
        normal, tangential = (one.apply(model.parts, factor) for one in (NORMAL, TANGENTIAL))
        changed = (normal, tangential, NORMAL.apply(tangential, factor), YOUNGS_MODULUS.apply(model.parts, factor))
        found = [modes.frequencies(one, names) for one in changed]
        console.print(f"{factor:g}:", ", ".join(" ".join(f"{f[i]:.1f}" for f in found) for i in range(len(names))))


def explained(model: Model, found: StatedDiagnosis) -> list[tuple[str, Model]]:
    """What meets the stated values, and the normal stiffness that comes nearest to them."""
    distinct = [one.explanation for one in survivors_of(found.found) if not one.load_exponent]
    nearest = [one for one in found.found.single if one.name == NORMAL.name and not one.met]
    return [(one.name, replace(model, parts=one.model())) for one in (*nearest, *distinct)]


def at_forces(console: Console, model: Model, mode: str, modes: LowForceModes) -> None:
    """The resonance at each force of the study; the highest peak of the curve where it does not begin: it starts from
    the structure with all contacts closed, which open ones are far from."""
    begun, solved = time.process_time(), modes.solved(model.parts, (mode,))[mode]
    console.print(f"  {mode}: linear up to {linear_up_to(model.parts, *solved):.3g} N")
    forces = model.rig.study.force_levels
    followed = resonance(model, mode, forces, options=ResonanceOptions(max_points=MOST_POINTS))
    if len(followed):
        rows = zip(followed.force, followed.frequency, abs(followed.receptance), strict=True)
        for force, frequency, receptance in rows:
            console.print(f"  {mode} {force:g} N: {frequency:.2f} Hz, {1e3 * receptance:.5f} mm/N")
    else:
        for force in forces:
            console.print(f"  {response_curve(model, mode, force)!r}")
    console.print(f"  {len(followed.data)} points, {time.process_time() - begun:.0f} s {followed.stopped}")


if __name__ == "__main__":
    main()
