"""Makes the files that `updamp init` copies: commands/example/ with a rig, a measurement of it, and the sealed truth.

    OPENBLAS_NUM_THREADS=1 .venv/bin/python tools/make_first_example.py        # a minute; the same files

The rig is that of rigs/virtual_rig.toml with two meshes of its own. The virtual laboratory (docs/virtual_rig.md), which
shares no code with the model beyond the finite elements, measures it on the mesh `medium`, with blades that differ: as
a real rig it is nearer to the finer mesh than to the one that the model has. That one, `small`, has its resonances
0.2 and 0.1 % higher (IP, OOP), for a tenth of the time: few elements across the width and above the platforms, as many
as `medium` where the contacts are. With 16 contact elements IP would be 1 % low: a face has one strip of them then.

Three levels of each mode, of which the middle one is to be held out: at the lowest all contacts stick, and what they
slip at cannot be told from it.
"""

import sys
from pathlib import Path

from updamp.benchmarks.virtual_rig.laboratory import hidden
from updamp.benchmarks.virtual_rig.measurement import make_measurement
from updamp.benchmarks.virtual_rig.plan import SIX_CURVES, TestPlan
from updamp.model.rig_files import load_rig

ROOT = Path(__file__).parents[1]
FOLDER = ROOT / "commands" / "example"
HEAD = """\
# Two blades with a wedge damper under their platforms, on meshes that are coarse enough for a first look.
# Change a value and run `updamp run rig.toml --out prediction` again: what it does not touch is taken from files.
"""
CHANGES = {
    'name = "virtual_rig"': 'name = "first_rig"',
    # Events within a time sample are taken as happening at it: compiled ten times as fast.
    'law = "jenkins_box"               # two': 'law = "jenkins_box_sampled"       # two',
    "modes = 24 ": "modes = 10 ",
    '["2 N", "4 N", "5 N", "8 N", "16 N", "32 N"]     # IP: 2, 5, 8; OOP: 4, 16, 32': '["2 N", "5 N"]',
}
SMALL = """\
[mesh.small]
width = 4
face = 5
platform_outer = 6
platform_inner = 1
platform_height = 9
stem_thickness = 3
stem_below_excitation = 6
stem_below_platform = 2
stem_above_platform = 12
stem_top = 3
damper_across = 6
damper_apex = 1
damper_base = 1
contact_elements = 36
"""


def rig_text() -> str:
    text = (ROOT / "rigs" / "virtual_rig.toml").read_text(encoding="utf-8")
    text = text[text.index('name = "virtual_rig"') :]
    for old, new in CHANGES.items():
        if old not in text:
            raise ValueError(f"rigs/virtual_rig.toml has no {old!r} any more; correct CHANGES")
        text = text.replace(old, new)
    meshes = text.index("# Divisions of the section's edges")
    medium = text[text.index("[mesh.diagnosis]") : text.index("# Finer finite elements, the same")]
    comment = "# Divisions of the section's edges; `contact_elements` counts both faces.\n"
    medium = medium.replace("diagnosis", "medium").rstrip()
    return f"{HEAD}{text[:meshes]}{comment}{SMALL}\n{medium}\n"


def main() -> None:
    rig = FOLDER / "rig.toml"
    rig.write_text(rig_text(), encoding="utf-8")
    effect = hidden("blade_mistuning", "strong")
    plan, sealed = TestPlan(SIX_CURVES, assemblies=2, points=24), FOLDER / "sealed.json"
    make_measurement(
        FOLDER, plan, [effect], seed=1, rig=load_rig(rig), preset="medium", sealed=sealed,
        progress=lambda run: print(run, file=sys.stderr),
    )  # fmt: skip
    for path in sorted(FOLDER.glob("*.*")):
        print(f"{path.relative_to(ROOT)}: {path.stat().st_size / 1e3:.0f} kB")


if __name__ == "__main__":
    main()
