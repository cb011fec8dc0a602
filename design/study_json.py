"""What a study found, in one file for other programs: study.json."""

import json
from collections.abc import Mapping
from dataclasses import asdict
from datetime import UTC, datetime
from importlib.metadata import version
from pathlib import Path
from typing import Any

from updamp.design.run_study import StudyResult
from updamp.design.table import best_records, problem_of

STUDY_JSON = "study.json"


def study_content(result: StudyResult) -> dict[str, Any]:
    study, method = result.study, result.method
    return {
        "study": study.name,
        "rig": result.rig.name,
        "mesh": study.mesh,
        "code": f"updamp {version('updamp')}",
        "written": datetime.now(UTC).isoformat(timespec="seconds"),
        "method": {"kind": study.method_name, **study.method.model_dump(mode="json")},
        "ended": method is not None,
        "variables": [asdict(one) for one in study.variables],
        "responses": [{"kind": type(r).__name__, "unit": r.unit, **r.model_dump(mode="json")} for r in study.responses],
        "objectives": [{"response": one.response, "goal": one.goal.words} for one in study.objectives],
        "constraints": [_limits(asdict(one)) for one in study.constraints],
        "setup": result.setup,
        "modes": [asdict(one) for one in result.references],
        "designs": len(result.records),
        "outcomes": _counted(result),
        "best": [one.number for one in best_records(problem_of(study), result.records)],
        "sensitivities": [asdict(one) for one in method.sensitivities] if method else [],
        "summary": dict(method.summary) if method else {},
        "notes": list(method.notes) if method else ["interrupted: run the same command again to go on"],
    }


def write_study_json(path: Path, result: StudyResult) -> None:
    temporary = path.with_suffix(".tmp")
    temporary.write_text(json.dumps(study_content(result), allow_nan=False, indent=2) + "\n", encoding="utf-8")
    temporary.replace(path)


def _limits(constraint: Mapping[str, Any]) -> dict[str, Any]:
    return {key: None if value in (float("inf"), -float("inf")) else value for key, value in constraint.items()}


def _counted(result: StudyResult) -> dict[str, int]:
    outcomes = [one.outcome for one in result.records]
    return {outcome: outcomes.count(outcome) for outcome in dict.fromkeys(outcomes)}
