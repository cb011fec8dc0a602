"""Examples as pages: what a cell prints and shows stands below it; one that fails stops the building."""

import json
import sys
from pathlib import Path

import pytest

sys.path.insert(0, str(Path(__file__).parents[2] / "tools"))

from write_examples import notebook_page, script_page

SHOWN = """
class Picture:
    def _repr_png_(self):
        return b"a picture"
class Table:
    def _repr_html_(self):
        return "<table></table>"
"""


def notebook(folder: Path, *cells: tuple[str, str]) -> Path:
    path = folder / "one.ipynb"
    path.write_text(json.dumps({"cells": [{"cell_type": kind, "source": [source]} for kind, source in cells]}))
    return path


@pytest.fixture
def inside_the_repo(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    monkeypatch.setattr("write_examples.ROOT", tmp_path)
    return tmp_path


def test_a_page_has_what_every_cell_prints_and_shows(inside_the_repo: Path) -> None:
    path = notebook(
        inside_the_repo, ("markdown", "# Title"), ("code", SHOWN), ("code", "x = 2\nprint('x is', x)\nPicture()"),
        ("code", "Table()"), ("code", "y = x + 1"),
    )  # fmt: skip
    page = notebook_page(path, inside_the_repo)
    assert page.startswith("# Title\n\n```python")
    assert "```text\nx is 2\n```\n\n![what the cell shows](one_2.png)" in page
    assert (inside_the_repo / "one_2.png").read_bytes() == b"a picture"
    assert "```{raw} html\n<table></table>\n```" in page
    assert page.endswith("```python\ny = x + 1\n```\n\nThis page is `one.ipynb`, run when it was built.\n")


def test_an_example_that_does_not_run_is_an_error(inside_the_repo: Path) -> None:
    with pytest.raises(ZeroDivisionError):
        notebook_page(notebook(inside_the_repo, ("code", "1 / 0")), inside_the_repo)


def test_a_script_s_page_has_its_code_and_what_it_prints(tmp_path: Path) -> None:
    script = tmp_path / "script.py"
    script.write_text('"""What it is about."""\n\nif __name__ == "__main__":\n    print(6 * 7)\n')
    page = script_page(script)
    assert "What it is about.\n\n```python\nif __name__" in page
    assert "It prints\n\n```text\n42\n```" in page
