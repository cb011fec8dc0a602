"""Copy the summary and some pictures of a full run to results/reference/, and its numbers into README.md.

.venv/bin/python tools/reference_results.py results/pesaresi2017
"""

import json
import re
import shutil
from pathlib import Path
from typing import Any

import typer

ROOT = Path(__file__).parents[1]
PICTURES = (
    "frf_OOP.png",
    "frf_IP.png",
    "mesh.png",
    "contact_states_OOP.png",
    "contact_states_IP.png",
    "damper_motion.png",
)

STUCK = {"OOP": 440, "IP": 424}  # Hz, wanted


def main(run: Path) -> None:
    """run: the folder of a full run"""
    reference = ROOT / "results" / "reference"
    reference.mkdir(parents=True, exist_ok=True)
    shutil.copy(run / "summary.json", reference)
    for name in PICTURES:
        if (run / "pictures" / name).exists():
            shutil.copy(run / "pictures" / name, reference)
    summary = json.loads((run / "summary.json").read_text())
    readme = ROOT / "README.md"
    table = f"<!-- results -->\n{tables(summary)}\n<!-- /results -->"
    readme.write_text(re.sub(r"<!-- results -->.*<!-- /results -->", lambda _: table, readme.read_text(), flags=re.S))


def tables(summary: dict[str, Any]) -> str:
    """Two tables in Markdown: the model, and its curves."""
    mesh, coupled, timing = summary["mesh"], summary["coupled_linear"], summary["timing_s"]
    rows = [
        ("elements of both blades / of the damper / contacts", "54,972 / 3,620 / 146",
         f"{mesh['blade_elements']:,} / {mesh['damper_elements']:,} / {mesh['contact_elements']}"),
        ("free 1F", "269 Hz", f"{summary['modes']['free_1F_Hz']:.2f} Hz"),
        *((f"stuck {m}, full / reduced model", f"{want} Hz", both(coupled[f"{m}_Hz"])) for m, want in STUCK.items()),
        ("wall time: mesh to reduced model / curves", "",
         f"{sum(timing[k] for k in ('mesh', 'assembly', 'modes', 'reduction')):.0f} s / {timing['hbm']:.0f} s"),
        ("peak memory", "below 12 GB", f"{summary['peak_memory_GB']:.1f} GB"),
    ]  # fmt: skip
    model = ["| quantity | wanted | found |", "|---|---|---|", *(f"| {a} | {b} | {c} |" for a, b, c in rows)]
    head = "| mode | force N | peak mm/N | at Hz | friction in the loss at the peak | points | complete | s |"
    return "\n".join([*model, "", head, "|---" * 8 + "|", *(curve(c) for c in summary["curves"])])


def both(frequency: dict[str, float]) -> str:
    """Of the full and of the reduced model."""
    return f"{frequency['full']:.3f} / {frequency['reduced']:.3f} Hz"


def curve(c: dict[str, Any]) -> str:
    """One row."""
    share = c.get("friction_share_of_loss_at_peak", 0.0)
    return (
        f"| {c['mode']} | {c['force_N']:g} | {c['peak_receptance_mm_per_N']:.5f} | {c['peak_frequency_Hz']:.2f} "
        f"| {max(share, 0.0):.0%} | {c['points']} | {'yes' if c['complete'] else 'no'} | {c['seconds']:.0f} |"
    )


if __name__ == "__main__":
    typer.run(main)
