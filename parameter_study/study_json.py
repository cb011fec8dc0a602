"""What a parameter study found, in one file for other programs: study.json."""

import json
from collections.abc import Mapping, Sequence
from dataclasses import asdict
from datetime import UTC, datetime
from importlib.metadata import version
from pathlib import Path
from typing import Any

from updamp.parameter_study.design_numbers import design_numbers
from updamp.parameter_study.families import CurveName
from updamp.parameter_study.findings.finding import Checked
from updamp.parameter_study.solved_study import SolvedStudy, UnknownResultError

STUDY_JSON = "study.json"


def study_content(solved: SolvedStudy, findings: Sequence[Checked], pictures: Mapping[str, str]) -> dict[str, Any]:
    """pictures: file -> caption"""
    return {
        "study": solved.study.name,
        "rig": solved.rig.name,
        "mesh": solved.study.mesh,
        "code": f"updamp {version('updamp')}",
        "written": datetime.now(UTC).isoformat(timespec="seconds"),
        "findings_met": f"{sum(one.met is True for one in findings)} of {len(findings)}",
        "findings": [finding_entry(one) for one in findings],
        "design_numbers": [entry for name in solved.curves if (entry := numbers_entry(solved, name))],
        "curves": [curve_entry(solved, name) for name in solved.curves],
        "missing": {name.label: reason for name, reason in solved.missing.items()},
        "seconds_of_curves": round(sum(curve.seconds for curve in solved.curves.values()), 1),
        "pictures": dict(pictures),
    }


def finding_entry(one: Checked) -> dict[str, Any]:
    finding = one.finding
    return {
        "number": finding.number,
        "paper": finding.paper,
        "seen_in": finding.seen_in,
        "updamp": one.updamp,
        "met": one.met,
        "criterion": finding.criterion,
        "measure": {name: float(f"{value:.6g}") for name, value in one.numbers.items()},
    }


def curve_entry(solved: SolvedStudy, name: CurveName) -> dict[str, Any]:
    curve = solved.curves[name]
    peak = solved.peak_of(name, curve) if len(curve) else None
    return {
        "variant": name.variant,
        "mode": name.mode,
        "force_N": name.force,
        "peak_receptance_mm_per_N": 1e3 * peak.receptance if peak else None,
        "peak_frequency_Hz": peak.frequency if peak else None,
        "points": len(curve),
        "complete": curve.complete,
        "problem": "" if curve.complete else curve.stopped,
        "harmonics": list(curve.orders),
        "seconds": round(curve.seconds, 2),
    }


def numbers_entry(solved: SolvedStudy, name: CurveName) -> dict[str, Any] | None:
    """Table 1b of the rig's own levels; None where they are not known"""
    try:
        numbers = asdict(design_numbers(solved, name))
    except UnknownResultError:
        return None
    return {"variant": name.variant, "mode": name.mode, "force_N": name.force, **numbers}


def write_study_json(path: Path, content: Mapping[str, Any]) -> None:
    temporary = path.with_suffix(".tmp")
    temporary.write_text(json.dumps(content, indent=1, allow_nan=False) + "\n", encoding="utf-8")
    temporary.replace(path)
