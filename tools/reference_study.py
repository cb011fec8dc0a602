"""Copy what a parameter study found, and its pictures, to results/reference/, and its findings into the documents.

.venv/bin/python tools/reference_study.py results/studies/pesaresi2017/full
"""

import json
import re
import shutil
from pathlib import Path
from typing import Any

import typer

ROOT = Path(__file__).parents[1]
KEPT = (
    "levels_", "loops_", "test_", "split_responses", "stiffness_", "harmonics_", "asymmetric_", "models_peaks", "fe_",
)  # fmt: skip


def main(study: Path) -> None:
    """study: the folder of a study"""
    reference = ROOT / "results" / "reference"
    content = json.loads((study / "study.json").read_text(encoding="utf-8"))
    kept = {file: caption for file, caption in content["pictures"].items() if Path(file).name.startswith(KEPT)}
    target = reference / "study"
    shutil.rmtree(target, ignore_errors=True)
    target.mkdir(parents=True)
    for file in kept:
        shutil.copy(study / file, target)
    content["pictures"] = {f"study/{Path(file).name}": caption for file, caption in kept.items()}
    (reference / "study.json").write_text(json.dumps(content, indent=1) + "\n", encoding="utf-8")
    page = ROOT / "docs" / "parameter_study.md"
    text = f"<!-- findings -->\n{table(content)}\n<!-- /findings -->"
    found = re.sub(
        r"<!-- findings -->.*<!-- /findings -->", lambda _: text, page.read_text(encoding="utf-8"), flags=re.S
    )
    page.write_text(found, encoding="utf-8")


def table(content: dict[str, Any]) -> str:
    """In Markdown."""
    words = {True: "met", False: "**not met**", None: "not known"}
    curves = content["curves"]
    complete = sum(curve["complete"] for curve in curves)
    head = [
        f"Mesh {content['mesh']}, {content['written'][:10]}: {len(curves)} curves, {complete} of them complete",
        f"({content['seconds_of_curves']:.0f} s); {content['findings_met']} findings are met.",
        "",
        "| | the paper | updamp | |",
        "|---|---|---|---|",
    ]
    rows = [f"| {f['number']} | {f['paper']} | {f['updamp']} | {words[f['met']]} |" for f in content["findings"]]
    return "\n".join([*head, *rows])


if __name__ == "__main__":
    typer.run(main)
