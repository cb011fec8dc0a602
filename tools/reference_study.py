"""Copy what a parameter study found, and its pictures, to results/reference/.

.venv/bin/python tools/reference_study.py results/studies/pesaresi2017/full
"""

import json
import shutil
from pathlib import Path

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


if __name__ == "__main__":
    typer.run(main)
