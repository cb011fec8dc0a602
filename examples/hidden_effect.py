"""A sealed effect in a measurement: compare, diagnose, add, compare again, open the seal. Two minutes on one core.

.venv/bin/python examples/hidden_effect.py [FOLDER]

The measurement is made up by the virtual laboratory of benchmarks/virtual_rig: other code than the model's, but the
same coarse mesh, so that what a finer one changes is no error here (on the command line: --finer none).
"""

import json
import os
import sys
from dataclasses import dataclass
from pathlib import Path
from typing import Any

# To be set before numpy is loaded: the products are small, and threads make them many times slower.
for library in ("OMP", "OPENBLAS", "MKL"):
    os.environ.setdefault(f"{library}_NUM_THREADS", "1")
ROOT = Path(__file__).parents[1]

from updamp.api import Rig, Verdict, add_effect, compare, diagnose, keep_compiled, load_rig  # noqa: E402
from updamp.benchmarks.virtual_rig.bench import Hidden  # noqa: E402
from updamp.benchmarks.virtual_rig.laboratory import hidden  # noqa: E402
from updamp.benchmarks.virtual_rig.measurement import make_measurement  # noqa: E402
from updamp.benchmarks.virtual_rig.plan import PlannedRun, TestPlan  # noqa: E402

PRESET = "coarse"
MESH = f"""
[mesh.{PRESET}]
width = 4
face = 2
platform_outer = 1
platform_inner = 1
platform_height = 2
stem_thickness = 1
stem_below_excitation = 2
stem_below_platform = 1
stem_above_platform = 4
stem_top = 1
damper_across = 2
damper_apex = 1
damper_base = 1
contact_elements = 16
"""
# Its law takes what happens between two samples of a period as happening at them: compiled ten times as fast.
CHANGES = {'law = "jenkins_box" ': 'law = "jenkins_box_sampled" ', "modes = 24 ": "modes = 10 "}
PLAN = TestPlan(tuple(PlannedRun(*run) for run in (("IP", 2.0), ("IP", 5.0), ("OOP", 4.0), ("OOP", 16.0))), 2, 24)
HELD_OUT = ("IP 5 N", "OOP 16 N")
NO_FINER = ()


@dataclass(frozen=True)
class Loop:
    """before, after: weighted residual RMS of the calibrated model without and with what was found, all data
    found: effect -> parameter -> value; truth: likewise, from the sealed file
    """

    before: float
    after: float
    verdict: Verdict
    found: dict[str, dict[str, float]]
    truth: dict[str, dict[str, float]]


def write_rig(folder: Path) -> Path:
    """The virtual rig with a coarse mesh."""
    text = (ROOT / "rigs" / "virtual_rig.toml").read_text(encoding="utf-8")
    for old, new in CHANGES.items():
        text = text.replace(old, new)
    folder.mkdir(parents=True, exist_ok=True)
    (folder / "rig.toml").write_text(text + MESH, encoding="utf-8")
    return folder / "rig.toml"


def measure(rig: Path, effect: Hidden, plan: TestPlan) -> tuple[Path, Path]:
    """What the engineer gets, and what is sealed."""
    folder, sealed = rig.parent / "measured", rig.parent / "sealed.json"
    if not sealed.is_file():
        loaded = load_rig(rig)
        assert isinstance(loaded, Rig), "a rig with geometry, not one given by modes"
        make_measurement(folder, plan, [effect], seed=1, rig=loaded, preset=PRESET, sealed=sealed)
    return folder / "measurement.toml", sealed


def loop(folder: Path, effect: Hidden, plan: TestPlan, quiet: bool = False, **search: Any) -> Loop:
    """All of it; where no effect is identified, none is added. search: as `diagnose` takes it"""
    rig = write_rig(folder)
    measurement, sealed = measure(rig, effect, plan)
    out = folder / "model"  # one folder for all steps: the finite elements are computed once
    _, before = compare(rig, measurement, out, PRESET, finer=NO_FINER, quiet=quiet).error
    found = diagnose(rig, measurement, out, PRESET, finer=NO_FINER, quiet=quiet, **search)
    better = add_effect(rig, out, replace=True).rig if found.effects else rig
    _, after = compare(better, measurement, out, PRESET, finer=NO_FINER, quiet=quiet).error
    truth = {one["name"]: one["values"] for one in json.loads(sealed.read_text(encoding="utf-8"))["hidden"]}
    added = {one.name: dict(one.values) for one in load_rig(better).effects}
    return Loop(before, after, found.verdict, added, truth)


def main(folder: Path) -> None:
    keep_compiled()
    result = loop(folder, hidden("blade_mistuning", "strong"), PLAN, held_out=HELD_OUT)
    held_out = result.verdict.error
    print(f"verdict   {result.verdict.verdict}: {result.verdict.sentence}")
    print(f"error     {result.before:.2f} -> {result.after:.2f} times the scatter, all data, each calibrated")
    print(f"held out  {held_out.held_out_before:.2f} -> {held_out.held_out_after:.2f}, not seen by the fit")
    print(f"found     {result.found}")
    print(f"sealed    {result.truth}")


if __name__ == "__main__":
    main(Path(sys.argv[1]) if len(sys.argv) > 1 else ROOT / "results" / "hidden_effect")
