"""README's example and the notebook run as they stand, without Jupyter."""

import ast
import json
import re
from pathlib import Path
from typing import Any

import pytest

from updamp import api

ROOT = Path(__file__).parents[2]
NOTEBOOK = ROOT / "examples" / "first_look.ipynb"


def evaluated(source: str, names: dict[str, Any]) -> Any:
    """Run a cell; returns: the value of its last expression, which a notebook shows, None where there is none"""
    tree = ast.parse(source)
    last = tree.body.pop() if isinstance(tree.body[-1], ast.Expr) else None
    exec(compile(tree, "<cell>", "exec"), names)
    return eval(compile(ast.Expression(last.value), "<cell>", "eval"), names) if last is not None else None


def imported(source: str) -> set[str]:
    return {node.module for node in ast.walk(ast.parse(source)) if isinstance(node, ast.ImportFrom) and node.module}


def test_the_notebook_runs_and_every_cell_shows_something(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(NOTEBOOK.parent)
    cells = [cell for cell in json.loads(NOTEBOOK.read_text(encoding="utf-8"))["cells"] if cell["cell_type"] == "code"]
    assert all(not cell["outputs"] and cell["execution_count"] is None for cell in cells), "outputs are not stored"
    names: dict[str, Any] = {}
    shown = []
    for cell in cells:
        source = "".join(cell["source"])
        assert imported(source) <= {"updamp.api"}
        value = evaluated(source, names)
        if value is not None:
            shown.append(value._repr_png_() if hasattr(value, "_repr_png_") else value._repr_html_())
    assert [isinstance(one, bytes) for one in shown] == [False, True, False, True, False]
    assert all(curve.complete for curve in names["curves"])
    assert list(names["backbone"].force) == pytest.approx([0.1, 1.0, 10.0])
    assert all(before > after for before, after in zip(*two_ends(names["backbone"].frequency), strict=True))


def two_ends(values: Any) -> tuple[Any, Any]:
    return values[:-1], values[1:]


def test_the_example_of_the_readme_runs(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    (source,) = re.findall(r"```python\n(.*?)```", (ROOT / "README.md").read_text(encoding="utf-8"), re.DOTALL)
    assert imported(source) == {"updamp.api"}
    load_rig = api.load_rig

    def quick(path: str, changes: dict[str, Any]) -> Any:
        """A law that is compiled ten times as fast, and fewer harmonics."""
        return load_rig(path, {**changes, "contact.law": "jenkins_box_sampled", "harmonic_balance.harmonics": [0, 1]})

    monkeypatch.setattr(api, "load_rig", quick)
    (tmp_path / "rigs").symlink_to(ROOT / "rigs")
    monkeypatch.chdir(tmp_path)
    names: dict[str, Any] = {}
    exec(compile(source, "README.md", "exec"), names)
    assert (tmp_path / "results" / "first" / "oop.png").is_file()
    assert names["curve"].complete
    assert names["gap"].complete
    (frequency, peak), (lower, larger) = names["curve"].peak(), names["gap"].peak()
    assert names["backbone"].frequency[-1] == pytest.approx(frequency, abs=0.01)
    assert lower < frequency
    assert larger != pytest.approx(peak, rel=1e-3)
    assert names["model"].rig.contact.friction_coefficient == 0.4
