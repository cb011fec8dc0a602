"""Another source, another key; the same source, the same key: in any process, from any folder, in any place."""

import ast
import os
import shutil
import subprocess
import sys
from collections.abc import Iterator
from pathlib import Path

import pytest

from updamp.workflow import code_version as module
from updamp.workflow.code_version import SEARCH, code_version, hash_of, source_files

ROOT = Path(__file__).parents[2]
FILES = [("fem/a.py", b"x = 1\n"), ("fem/solvers/b.py", b"y = 2\n")]
PRINT = "from updamp.workflow.code_version import SEARCH, code_version; print(code_version(*SEARCH))"


def by_another_process(cwd: Path, path: str) -> str:
    environment = {**os.environ, "PYTHONPATH": path, "PYTHONDONTWRITEBYTECODE": "1"}
    found = subprocess.run(
        [sys.executable, "-c", PRINT], cwd=cwd, env=environment, capture_output=True, text=True, check=True
    )
    return found.stdout.strip()


@pytest.mark.parametrize(
    "other",
    [
        [("fem/a.py", b"x = 2\n"), FILES[1]],
        [("fem/c.py", b"x = 1\n"), FILES[1]],
        FILES[:1],
        [*FILES, ("fem/c.py", b"")],
        [("fem/a.py", b"x = 1\nfem/solvers/b.py y = 2\n")],
    ],
)
def test_what_a_file_holds_and_is_called_counts(other: list[tuple[str, bytes]]) -> None:
    assert hash_of(other) != hash_of(FILES)


def test_order_and_ends_of_lines_do_not_count() -> None:
    assert hash_of(reversed(FILES)) == hash_of(FILES)
    assert hash_of([("fem/a.py", b"x = 1\r\n"), FILES[1]]) == hash_of(FILES)


def test_versions_of_libraries_count(monkeypatch: pytest.MonkeyPatch) -> None:
    assert hash_of(FILES, ["numpy 2.4.0"]) != hash_of(FILES, ["numpy 2.5.0"])
    known = code_version.__wrapped__("rig")
    monkeypatch.setattr(module, "version", lambda _: "0.0.1")
    assert code_version.__wrapped__("rig") != known


@pytest.fixture
def copy(tmp_path: Path) -> Path:
    """As installed: the rooms under a folder updamp."""
    ignored = shutil.ignore_patterns("__pycache__")
    for room in {part.split("/")[0] for part in SEARCH}:
        shutil.copytree(ROOT / room, tmp_path / "site" / "updamp" / room, ignore=ignored)
    return tmp_path / "site"


def test_the_same_in_another_process_folder_and_place(copy: Path, tmp_path: Path) -> None:
    here = code_version(*SEARCH)
    assert by_another_process(ROOT, "") == here
    assert by_another_process(tmp_path, "") == here
    changed = copy / "updamp" / "comparison" / "compare.py"
    changed.write_bytes(changed.read_bytes().replace(b"\n", b"\r\n"))
    assert by_another_process(tmp_path, str(copy)) == here, "a copy, as a wheel installs it"
    changed.write_bytes(changed.read_bytes() + b"# another sentence\n")
    assert by_another_process(tmp_path, str(copy)) != here


def test_only_python_files_of_the_parts_are_read(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    room = tmp_path / "oddly" / "room"
    for name in ("a.py", "below/b.py", "__pycache__/a.cpython-311.py", "notes.txt", "beside.py"):
        (room / name).parent.mkdir(parents=True, exist_ok=True)
        (room / name).write_text("")
    monkeypatch.setattr(module, "PACKAGE", "oddly")
    monkeypatch.syspath_prepend(tmp_path)
    assert {name for name, _ in source_files("room")} == {"room/a.py", "room/below/b.py", "room/beside.py"}
    assert [name for name, _ in source_files("room/beside.py")] == ["room/beside.py"]


@pytest.mark.parametrize("part", ["attic", "fem/attic", "workflow/attic.py"])
def test_a_part_that_is_not_there_is_refused(part: str) -> None:
    with pytest.raises(ValueError, match=f"{part}: not a part of updamp"):
        list(source_files(part))


def imported_rooms(room: str) -> Iterator[str]:
    for name, content in source_files(room):
        for node in ast.walk(ast.parse(content, name)):
            names = [node.module or ""] if isinstance(node, ast.ImportFrom) else []
            names += [alias.name for alias in node.names] if isinstance(node, ast.Import) else []
            yield from (n.split(".")[1] for n in names if n.startswith("updamp."))


def test_what_a_search_imports_is_in_its_key() -> None:
    rooms = {part for part in SEARCH if "/" not in part}
    imported = {found for room in rooms for found in imported_rooms(room)}
    assert imported <= rooms
    by_workflow = {found for part in SEARCH if "/" in part for found in imported_rooms(part)}
    assert by_workflow - rooms == {"report", "workflow"}, "these show what was found, and change nothing of it"
