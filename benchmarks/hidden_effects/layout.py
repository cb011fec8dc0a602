"""Where the benchmark's files are: what a diagnosis may see, the truth apart from it, and verdicts.

FOLDER/data/case_001/measurement.toml, sweeps.csv
FOLDER/truth/case_001.json
FOLDER/expected/case_001.json: what of the truth can be seen
FOLDER/verdicts/case_001/diagnosis.json, run.json
FOLDER/models/virtual_rig/diagnosis: stages of the model that is fitted
"""

import json
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

HERE = Path(__file__).parent


@dataclass(frozen=True)
class Layout:
    folder: Path = HERE / "data"

    def data(self, case: str) -> Path:
        return self.folder / "data" / case

    def measurement(self, case: str) -> Path:
        return self.data(case) / "measurement.toml"

    def truth(self, case: str) -> Path:
        return self.folder / "truth" / f"{case}.json"

    def models(self, rig: Path) -> Path:
        """Of a rig file: what is fitted, a folder for each mesh preset."""
        return self.folder / "models" / rig.stem

    def expected(self, case: str) -> Path:
        return self.folder / "expected" / f"{case}.json"

    def verdict(self, case: str) -> Path:
        return self.folder / "verdicts" / case


def write_whole(path: Path, content: Mapping[str, Any]) -> None:
    """JSON, in one piece or not at all: what is there counts as finished."""
    path.parent.mkdir(parents=True, exist_ok=True)
    partial = path.with_suffix(".partial")
    partial.write_text(json.dumps(content, indent=1) + "\n", encoding="utf-8")
    partial.replace(path)


def read(path: Path) -> dict[str, Any] | None:
    """None where there is no such file. raises: ValueError naming a file that is not JSON"""
    if not path.is_file():
        return None
    try:
        content = json.loads(path.read_text(encoding="utf-8"))
    except json.JSONDecodeError as error:
        raise ValueError(f"{path}: not JSON ({error}); delete it to have it made again") from error
    return dict(content)
