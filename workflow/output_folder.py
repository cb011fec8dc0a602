"""The folder that a command writes into: there or to be made, ours to write, and of one rig alone."""

import json
import os
from contextlib import suppress
from pathlib import Path

SUMMARY = "summary.json"
STATE = "state of the rig"  # key of their provenance
OWNERS = ("comparison.json", "diagnosis.json")  # which name their rig among what they rest on


def check_folder(folder: Path, rig: str) -> None:
    """Before the work begins; nothing is made or written.

    rig: name in the rig file
    raises: ValueError naming the folder, what is wrong with it, and the option that names another
    """
    existing = folder
    while not existing.exists() and existing != existing.parent:
        existing = existing.parent
    if not existing.is_dir():
        raise ValueError(f"{existing}: is a file, no folder; give another folder with --out")
    if not os.access(existing, os.W_OK | os.X_OK):
        raise ValueError(f"{existing}: no permission to write there; give another folder with --out")
    owner = owner_of(folder)
    if owner and owner != rig:
        raise ValueError(
            f"{folder}: holds results of the rig '{owner}', and this is '{rig}'; give another folder with --out"
        )


def make_folder(folder: Path) -> None:
    """raises: ValueError where the system does not make it, though nothing that was looked at speaks against it: below
    /proc, say, or on a disk without room"""
    try:
        folder.mkdir(parents=True, exist_ok=True)
    except OSError as error:
        raise ValueError(
            f"{folder}: this folder cannot be made: {error.strerror}; give another one with --out"
        ) from None


def results_of_other_states(folder: Path, state: str) -> list[str]:
    """Comparisons and diagnoses in the folder that were made with another state of the rig (`Rig.state`)."""
    found = []
    for name in OWNERS:
        with suppress(OSError, ValueError, KeyError, AttributeError, TypeError):
            stated = json.loads((folder / name).read_text(encoding="utf-8"))["provenance"].get(STATE, state)
            found += [name] if stated != state else []
    return found


def owner_of(folder: Path) -> str:
    """Name of the rig whose results are there, "" where none are, or they do not say."""
    for name in (SUMMARY, *OWNERS):
        with suppress(OSError, ValueError, AttributeError, TypeError):
            content = json.loads((folder / name).read_text(encoding="utf-8"))
            owner = content.get("rig") if name == SUMMARY else content.get("provenance", {}).get("rig")
            if isinstance(owner, str) and owner:
                return owner
    return ""
