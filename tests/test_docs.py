"""What README and docs name is there: files, what they define, pages that are linked."""

import re
from collections import Counter
from collections.abc import Iterator
from pathlib import Path

import pytest

ROOT = Path(__file__).parents[1]
MADE = {"_build", "generated"}  # by `make docs`
PAGES = (
    ROOT / "README.md",
    *sorted(path for path in (ROOT / "docs").rglob("*.md") if not MADE & set(path.relative_to(ROOT).parts)),
)
FOLDERS_OF_CODE = [path for path in ROOT.iterdir() if path.is_dir() and path.name[0] != "." and path.name != "build"]
FILES = [
    path.relative_to(ROOT).as_posix()
    for path in (*ROOT.glob("*.py"), *(f for folder in FOLDERS_OF_CODE for f in folder.rglob("*.py")))
]
NAMES = Counter(Path(name).name for name in FILES)
OF_A_READER = {"oily.py", "own.py", "my_effect.py"}  # files that a reader would write
MARKS = re.compile(r"<!--.*?-->")  # of generated tables
MENTION = re.compile(r"(?<![\w/.*-])((?:[\w-]+/)*[\w-]+\.py)\b(?::\s(\w+)`)?")


def mentions(page: Path) -> Iterator[tuple[str, str]]:
    """Python files that a page names, with what it says that they define, "" for nothing"""
    for path, name in MENTION.findall(MARKS.sub("", page.read_text(encoding="utf-8"))):
        if path not in OF_A_READER:
            yield path, name


@pytest.mark.parametrize("page", PAGES, ids=lambda page: page.relative_to(ROOT).as_posix())
def test_files_that_are_named_are_there(page: Path) -> None:
    """With their folders, from the root of the repo; by name alone where no other file has it."""
    named = {path for path, _ in mentions(page)}
    wrong = [path for path in sorted(named) if (path not in FILES if "/" in path else NAMES[path] != 1)]
    assert wrong == []


def test_files_that_the_code_names_are_there() -> None:
    """In its comments and docstrings; by name alone where the file is close by."""
    wrong = [
        (name, path)
        for name in FILES
        if not name.startswith("tests/")
        for path, _ in mentions(ROOT / name)
        if (path not in FILES if "/" in path else NAMES[path] == 0)
    ]
    assert wrong == []


@pytest.mark.parametrize("page", PAGES, ids=lambda page: page.relative_to(ROOT).as_posix())
def test_what_is_named_in_a_file_is_there(page: Path) -> None:
    found = {(path, name) for path, name in mentions(page) if name and path in FILES}
    wrong = [pair for pair in found if not re.search(rf"\b{pair[1]}\b", (ROOT / pair[0]).read_text(encoding="utf-8"))]
    assert wrong == []


@pytest.mark.parametrize("page", PAGES, ids=lambda page: page.relative_to(ROOT).as_posix())
def test_pages_and_pictures_that_are_linked_are_there(page: Path) -> None:
    text = page.read_text(encoding="utf-8")
    linked = re.findall(r"\]\((?!https?://|#)([^)#]+)", text)
    other_pages = re.findall(r"`([\w-]+\.md)`", text)
    wrong = [link for link in linked if not (page.parent / link).exists() and not MADE & set(Path(link).parts)]
    assert wrong + [name for name in other_pages if not (ROOT / "docs" / name).exists()] == []


def test_the_glossary_has_each_term_once_and_names_what_there_is() -> None:
    rows = re.findall(
        r"^\| (.+?) \| (.+?) \| (.*?)\|$", (ROOT / "docs" / "glossary.md").read_text("utf-8"), re.MULTILINE
    )
    terms = [term for term, _, _ in rows if term != "term"]
    assert len(terms) > 60
    assert [term for term, count in Counter(terms).items() if count > 1] == []
    code = "\n".join((ROOT / name).read_text(encoding="utf-8") for name in FILES if not name.startswith("tests/"))
    named = [name for *_, where in rows for name in re.findall(r"`([^`]+)`", where) if not name.endswith(".py")]
    assert [name for name in named if not re.search(rf"\b{name}\b", code)] == []
