"""Makes the files that `updamp init` copies: commands/example/ with a rig, a measurement of it, and the sealed truth.

    OPENBLAS_NUM_THREADS=1 .venv/bin/python tools/make_first_example.py        # 20 s; the same files every time

The rig is that of rigs/virtual_rig.toml with two meshes of its own. The virtual laboratory (docs/virtual_rig.md), which
shares no code with the model beyond the finite elements, measures it on the mesh `small`, with blades that differ.
"""

import sys
from pathlib import Path

from updamp.benchmarks.virtual_rig.laboratory import hidden
from updamp.benchmarks.virtual_rig.measurement import make_measurement
from updamp.examples.hidden_effect import MESH, PLAN, PRESET
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
    '["430 Hz", "446 Hz"]': '["436 Hz", "456 Hz"]',  # so coarse a mesh has its resonances elsewhere
    '["405 Hz", "428 Hz"]': '["390 Hz", "410 Hz"]',
    '["2 N", "4 N", "5 N", "8 N", "16 N", "32 N"]     # IP: 2, 5, 8; OOP: 4, 16, 32': '["2 N", "5 N"]',
}
SMALL = MESH.strip().replace(f"[mesh.{PRESET}]", "[mesh.small]") + "\n"


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
    make_measurement(
        FOLDER, PLAN, [effect], seed=1, rig=load_rig(rig), preset="small", sealed=FOLDER / "sealed.json",
        progress=lambda run: print(run, file=sys.stderr),
    )  # fmt: skip
    for path in sorted(FOLDER.glob("*.*")):
        print(f"{path.relative_to(ROOT)}: {path.stat().st_size / 1e3:.0f} kB")


if __name__ == "__main__":
    main()
