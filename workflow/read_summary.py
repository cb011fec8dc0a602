"""What a run left in summary.json, read back."""

import json
from collections.abc import Mapping
from pathlib import Path
from typing import Any

from updamp.workflow.output_folder import SUMMARY

CURVE_KEYS = ("mode", "force_N", "points", "seconds", "problem")  # that every curve's entry has


def read_summary(folder: Path) -> Mapping[str, Any]:
    """raises: ValueError naming the file, what is wrong with it, and the command that makes it"""
    path = folder / SUMMARY
    remedy = f"make it with: updamp run RIG --mesh PRESET --out {folder}"
    if not path.is_file():
        raise ValueError(f"{path}: no such file; {remedy}")
    try:
        content = json.loads(path.read_text(encoding="utf-8"))
    except OSError as error:
        raise ValueError(f"{path}: cannot be read: {error.strerror}; mend that, or {remedy}") from None
    except ValueError as error:  # no JSON, or no text
        raise ValueError(f"{path}: damaged ({error}); {remedy}") from None
    if not _sound(content):
        raise ValueError(f"{path}: not what a run writes; {remedy}")
    return dict(content)


def _sound(content: Any) -> bool:
    if not isinstance(content, dict) or not isinstance(content.get("rig"), str):
        return False
    curves = content.get("curves", [])
    return isinstance(curves, list) and all(isinstance(c, dict) and set(c) >= set(CURVE_KEYS) for c in curves)
