"""Runs the examples for `make docs` and writes them as pages, with what they show: docs/tutorial/generated/.

The notebook is run cell by cell without Jupyter, as its test does: values show themselves by `_repr_png_` or
`_repr_html_`. myst-nb would do the same with a kernel and some forty packages; sphinx-gallery knows pyplot's figures
alone, and those of this program are none, so that a notebook's backend stays.
"""

import ast
import contextlib
import io
import json
import os
import runpy
import textwrap
from collections.abc import Iterator
from pathlib import Path
from typing import Any

ROOT = Path(__file__).parents[1]
NOTEBOOK = ROOT / "examples" / "first_look.ipynb"
SCRIPT = ROOT / "examples" / "multi_element_oscillator.py"


def write_examples(folder: Path) -> None:
    """Both pages. raises: whatever an example raises, since then it does not run as it stands"""
    folder.mkdir(parents=True, exist_ok=True)
    (folder / "first_look.md").write_text(notebook_page(NOTEBOOK, folder), encoding="utf-8")
    (folder / "multi_element_oscillator.md").write_text(script_page(SCRIPT), encoding="utf-8")


def notebook_page(path: Path, folder: Path) -> str:
    """Markdown of a notebook that has been run; its pictures go into the folder."""
    cells = json.loads(path.read_text(encoding="utf-8"))["cells"]
    names: dict[str, Any] = {}
    parts: list[str] = []
    with contextlib.chdir(path.parent):
        for number, cell in enumerate(cells):
            source = "".join(cell["source"])
            if cell["cell_type"] == "markdown":
                parts.append(source)
                continue
            parts.append(f"```python\n{source}\n```")
            parts += outputs(source, names, folder / f"{path.stem}_{number}.png")
    return "\n\n".join([*parts, f"This page is `{path.relative_to(ROOT)}`, run when it was built.\n"])


def outputs(source: str, names: dict[str, Any], picture: Path) -> Iterator[str]:
    """What a cell prints, and the value of its last expression"""
    tree = ast.parse(source)
    last = tree.body[-1]
    value: Any = None
    with contextlib.redirect_stdout(io.StringIO()) as printed:
        if isinstance(last, ast.Expr):
            tree.body.pop()
        exec(compile(tree, "<cell>", "exec"), names)
        if isinstance(last, ast.Expr):
            value = eval(compile(ast.Expression(last.value), "<cell>", "eval"), names)
    if printed.getvalue():
        yield f"```text\n{printed.getvalue().rstrip()}\n```"
    if hasattr(value, "_repr_png_"):
        picture.write_bytes(value._repr_png_())
        yield f"![what the cell shows]({picture.name})"
    elif hasattr(value, "_repr_html_"):
        yield f"```{{raw}} html\n{value._repr_html_()}\n```"


def script_page(path: Path) -> str:
    """A script, and what it prints"""
    with contextlib.redirect_stdout(io.StringIO()) as printed:
        runpy.run_path(str(path), run_name="__main__")
    source = path.read_text(encoding="utf-8")
    about = ast.get_docstring(ast.parse(source)) or path.stem
    title, body = "Harmonic balance without a rig", textwrap.fill(about, 120)
    code = source[source.index('"""', 3) + 3 :].strip()
    return (
        f"# {title}\n\n{body}\n\n```python\n{code}\n```\n\nIt prints\n\n```text\n{printed.getvalue().rstrip()}\n```\n"
    )


if __name__ == "__main__":
    os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")
    write_examples(ROOT / "docs" / "tutorial" / "generated")
